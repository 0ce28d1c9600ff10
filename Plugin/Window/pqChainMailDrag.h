// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailDrag_h
#define pqChainMailDrag_h

#include "pqChainMailPreview.h"
#include "pqChainMailPreviewRenderer.h"

#include <QObject>
#include <QPointer>
#include <QTimer>

#include "vtkCallbackCommand.h"
#include "vtkDataArray.h" // Qt wants to know what its signals carry
#include "vtkNew.h"
#include "vtkRenderWindowInteractor.h"
#include "vtkSMProxy.h"
#include "vtkSMTrace.h"
#include "vtkWeakPointer.h"

#include <memory>

#include "pqInteractivePropertyWidget.h"
#include "pqView.h"

/// Lets the tissue follow while a probe, blade or drill is dragged, without Apply. Frames that the hand waits for are
/// previews: made of fewer voxels, relaxed with the preset for dragging, and drawn with fewer rays, as few as it takes
/// for ten frames a second. Where a preview would not do, the deformation itself follows, with that preset, with fewer
/// elements where that makes it faster, and drawn with fewer rays where this process draws; where a frame then takes
/// longer than a second, the tissue waits for the end of the drag. When the hand lets go, everything is as it was set,
/// the tissue settles, and the drag is one step of Undo.
class pqChainMailDrag : public QObject
{
  Q_OBJECT

public:
  explicit pqChainMailDrag(pqInteractivePropertyWidget* widget);
  ~pqChainMailDrag() override;

  /// Whether tissue follows, for all drags; else it waits for Apply, as ParaView's filters do.
  static bool IsOn;

Q_SIGNALS:
  /// A preview was made, in which the probes of the deformation reached so much.
  void previewed(vtkDataArray* reached);

private:
  Q_DISABLE_COPY(pqChainMailDrag)

  void start();
  void follow();
  void refine();
  void finish();
  void apply();

  bool canDraw() const;
  void endDrawing();
  void beginPreview();
  void drawPreview();
  void drawItself();

  /// Whether ParaView draws the view for each movement of the mouse, too.
  void setDrawnByParaView(bool drawn);
  /// Sets a property of the deformation, keeping what it was.
  void borrow(const char* property, int& kept, int value);
  void giveBack(const char* property, int& kept);
  /// After a frame of the deformation itself.
  void adapt(double milliseconds);
  bool isReducible() const;
  double millisecondsOfElements() const;

  QPointer<pqInteractivePropertyWidget> Widget;
  QTimer Next;
  QTimer Rest;
  QTimer Applying;
  bool IsUnderWay = false; // a drag
  QPointer<pqView> View;   // of it, as all that follows
  vtkWeakPointer<vtkSMProxy> Deformation;
  vtkWeakPointer<vtkRenderWindowInteractor> Silenced;
  vtkNew<vtkCallbackCommand> Silence;
  bool IsDrawing = false;
  bool IsOver = false; // while a frame is drawn
  bool IsFirst = true; // frame of a drag, which may take longer than those to come, as does that of another model
  bool IsOfNewModel = false;
  bool TooSlow = false;
  bool IsPreviewing = false;
  int KeptPreset = -1;
  int KeptReduction = -1;
  std::unique_ptr<vtkSMTrace::TraceItem> Trace;
  pqChainMailPreviewRenderer Renderer;
  std::unique_ptr<pqChainMailPreview> Preview; // of the drag that is under way or of the last one
};

#endif
