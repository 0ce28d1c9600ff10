// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailActions_h
#define pqChainMailActions_h

#include <QActionGroup>
#include <QPointer>
#include <QTimer>
#include <QToolBar>

class pqPipelineSource;

/// What can be done to tissue with one click: a toolbar of ParaView, and the menu Tissue. Everything that is made
/// appears where the view shows tissue, with a size that fits the scan, and acts at once.
class pqChainMailActions : public QActionGroup
{
  Q_OBJECT
  typedef QActionGroup Superclass;

public:
  pqChainMailActions(QObject* parent = nullptr);

private Q_SLOTS:
  void updateEnableState();
  /// Makes a probe on the tissue that is seen and a deformation of the selected scan, shows it instead of the scan with
  /// the scan's look, and selects the probe.
  void grab();
  /// Makes a forearm, and grabs it.
  void openExample();
  /// Takes the selected probes, blades and drills out of their deformations, and deletes them; ParaView's Delete leaves
  /// what something depends on.
  void remove();

protected:
  /// The key Delete in the pipeline browser.
  bool eventFilter(QObject* browser, QEvent* event) override;

private:
  Q_DISABLE_COPY(pqChainMailActions)

  QAction* addAction(const QString& name, const QString& text, const QString& help);
  void addMenu();
  /// Gives the buttons room in the window: at the end of its tool bars, or in a line of their own.
  void makeRoom();
  /// Makes the panel of properties as wide as what is in it, where part of that is hidden. To be called when the view
  /// has been drawn: else its new size makes it update, where pqChainMailAbortBehavior handles events, while Qt lays
  /// out the window.
  void widenPanel();
  void addToPipelineBrowser();
  /// Makes a source for an input of the deformation that is selected, or that the selected source belongs to.
  void addTo(const char* input, const char* source, double opacity);

  QTimer Later;
  QPointer<QToolBar> Bar;
  QTimer Resized;
  QTimer Drawn;
  int Moves = 0;
  int WidestPanel = 0;
  QAction* Grab;
  QAction* TurnBone;
  QAction* Remove;
  QList<QAction*> Additions;
};

#endif
