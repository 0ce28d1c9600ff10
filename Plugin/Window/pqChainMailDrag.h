// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailDrag_h
#define pqChainMailDrag_h

#include <QObject>
#include <QTimer>

#include "vtkSMTrace.h"

#include <memory>

class pqInteractivePropertyWidget;
class vtkSMProxy;

/// Lets the tissue follow while a probe, blade or drill is dragged, without Apply. Frames that the hand waits for relax
/// with the preset for dragging, with fewer elements where that makes them faster, and are drawn coarsely. When the
/// hand lets go, everything is as it was set, the tissue settles, and the drag is one step of Undo. Where a frame takes
/// longer than a second, the tissue waits for the end of the drag.
class pqChainMailDrag : public QObject
{
  Q_OBJECT

public:
  explicit pqChainMailDrag(pqInteractivePropertyWidget* widget);
  ~pqChainMailDrag() override;

  /// Whether tissue follows, for all drags; else it waits for Apply, as ParaView's filters do.
  static bool IsOn;

private:
  Q_DISABLE_COPY(pqChainMailDrag)

  void start();
  void follow();
  void finish();

  /// Sets a property of the deformation, keeping what it was.
  void borrow(const char* property, int& kept, int value);
  void giveBack(const char* property, int& kept);
  /// After a frame that took so long.
  void adapt(double milliseconds);

  pqInteractivePropertyWidget* Widget;
  vtkSMProxy* Deformation = nullptr; // of the drag that is under way
  QTimer Next;
  bool IsDrawing = false;
  bool IsFirst = true; // frame of a drag, or of another model: it takes longer than those to come
  bool TooSlow = false;
  int KeptPreset = -1;
  int KeptReduction = -1;
  std::unique_ptr<vtkSMTrace::TraceItem> Trace;
};

#endif
