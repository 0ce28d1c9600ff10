// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailAbortBehavior_h
#define pqChainMailAbortBehavior_h

#include <QElapsedTimer>
#include <QMouseEvent>
#include <QObject>
#include <QPointer>
#include <QSet>

#include "vtkWeakPointer.h"

#include <memory>
#include <utility>
#include <vector>

class QToolButton;
class QWidget;
class pqPipelineSource;
class vtkAlgorithm;
class vtkObject;

/// Lets the X beside ParaView's progress bar stop deformations of the built-in server. Before ParaView 6.1 nothing
/// looks for a click while an update runs, and nothing would do what it asks for. ParaView 6.1 looks for events but
/// drops the click, and what it would stop by it never runs again. Since 6.2, ParaView does all of this itself. With a
/// remote server the X stays as it is: its updates run elsewhere.
///
/// What the mouse does in a view meanwhile comes afterwards, such as the next drag while the tissue of the last one
/// settles. All other input during an update is dropped, as ParaView does.
class pqChainMailAbortBehavior : public QObject
{
  Q_OBJECT
  typedef QObject Superclass;

public:
  explicit pqChainMailAbortBehavior(QObject* parent = nullptr);

private Q_SLOTS:
  void begin();
  void listen(vtkObject* deformation);
  void end();

protected:
  /// During an update: a click on the X stops it, the mouse in a view is put off, no other input comes through, and the
  /// window is drawn as it was.
  bool eventFilter(QObject* receiver, QEvent* event) override;

private:
  Q_DISABLE_COPY(pqChainMailAbortBehavior)

  void watch(pqPipelineSource* source);
  /// Makes the X a button to press, or an ornament again.
  void enable(bool enabled);
  /// Handles the events that have come since the last call.
  void handleEvents();
  /// Whether an event that is none of the mouse has to wait or is dropped during an update.
  bool takesAway(QObject* receiver, QEvent* event);
  void stop(vtkAlgorithm* deformation);
  /// What was stopped may run again.
  void release();
  void putOff(QObject* receiver, const QMouseEvent* event);
  /// Lets the mouse do what was put off, once ParaView is idle.
  void catchUp();

  QPointer<QToolButton> Button;
  QElapsedTimer Clock; ///< since the update began, or since the last look
  bool MayListen = false;
  bool IsEnabled = false;
  bool IsListening = false;
  bool IsUpdating = false;
  bool IsStopped = false;
  std::vector<vtkWeakPointer<vtkAlgorithm>> Stopped;
  QSet<QWidget*> Undrawn;
  bool IsParaViewBusy = false;
  std::vector<std::pair<QPointer<QObject>, std::unique_ptr<QMouseEvent>>> PutOff;
};

#endif
