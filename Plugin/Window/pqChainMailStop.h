// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailStop_h
#define pqChainMailStop_h

#include <QElapsedTimer>
#include <QObject>
#include <QPointer>
#include <QSet>

#include "vtkWeakPointer.h"

#include <vector>

class QToolButton;
class QWidget;
class pqPipelineSource;
class vtkAlgorithm;
class vtkObject;

/// Lets the X beside ParaView's progress bar stop deformations of the built-in server. Before ParaView 6.1 nothing
/// looks for a click while an update runs, and nothing would do what it asks for; since then, ParaView does both
/// itself. With a remote server the X stays as it is: its updates run elsewhere.
class pqChainMailStop : public QObject
{
  Q_OBJECT
  typedef QObject Superclass;

public:
  explicit pqChainMailStop(QObject* parent = nullptr);

private Q_SLOTS:
  void begin();
  void listen(vtkObject* deformation);
  void end();

protected:
  /// While it listens: nothing but a click on the X comes through, and the window is drawn as it was.
  bool eventFilter(QObject* receiver, QEvent* event) override;

private:
  Q_DISABLE_COPY(pqChainMailStop)

  void watch(pqPipelineSource* source);
  /// Makes the X a button to press, or an ornament again.
  void enable(bool enabled);
  /// Handles the events that have come since the last call.
  void handleEvents();
  void stop(vtkAlgorithm* deformation);
  /// What was stopped may run again.
  void release();

  QPointer<QToolButton> Button;
  QElapsedTimer Clock; ///< since the update began, or since the last look
  bool MayListen = false;
  bool IsEnabled = false;
  bool IsListening = false;
  bool IsStopped = false;
  std::vector<vtkWeakPointer<vtkAlgorithm>> Stopped;
  QSet<QWidget*> Undrawn;
};

#endif
