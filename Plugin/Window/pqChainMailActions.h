// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailActions_h
#define pqChainMailActions_h

#include <QActionGroup>
#include <QTimer>

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

private:
  Q_DISABLE_COPY(pqChainMailActions)

  QAction* addAction(const QString& name, const QString& text, const QString& help);
  void addMenu();
  /// Makes a source for an input of the deformation that is selected, or that the selected source belongs to.
  void addTo(const char* input, const char* source, double opacity);

  QTimer Later;
  QAction* Grab;
  QList<QAction*> Additions;
};

#endif
