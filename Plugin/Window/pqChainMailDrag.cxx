// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailDrag.h"

#include "Sight.h"

#include "pqCoreUtilities.h"
#include "pqInteractivePropertyWidget.h"
#include "pqPropertiesPanel.h"
#include "pqUndoStack.h"
#include "pqView.h"

#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVLogger.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMViewProxy.h"

#include <QElapsedTimer>

bool pqChainMailDrag::IsOn = true;

namespace
{
// Of a whole frame, for ten a second.
constexpr double AllowedMilliseconds = 100.0;
}

//------------------------------------------------------------------------------
pqChainMailDrag::pqChainMailDrag(pqInteractivePropertyWidget* widget)
  : QObject(widget)
  , Widget(widget)
{
  this->Next.setSingleShot(true);
  QObject::connect(&this->Next, &QTimer::timeout, this, &pqChainMailDrag::follow);
  this->Rest.setSingleShot(true);
  this->Rest.setInterval(400);
  QObject::connect(&this->Rest, &QTimer::timeout, this, &pqChainMailDrag::refine);
  QObject::connect(widget, &pqInteractivePropertyWidget::startInteraction, this, &pqChainMailDrag::start);
  QObject::connect(widget, &pqInteractivePropertyWidget::interaction, &this->Next, QOverload<>::of(&QTimer::start));
  QObject::connect(widget, &pqInteractivePropertyWidget::endInteraction, this, &pqChainMailDrag::finish);
}

//------------------------------------------------------------------------------
pqChainMailDrag::~pqChainMailDrag()
{
  this->finish(); // the source was deleted, or another was selected
}

//------------------------------------------------------------------------------
void pqChainMailDrag::start()
{
  this->Deformation = pqChainMailDrag::IsOn ? vtkChainMail::DeformationOf(this->Widget->proxy()) : nullptr;
  if (this->Deformation == nullptr)
  {
    return;
  }
  this->View = this->Widget->view();
  BEGIN_UNDO_SET(tr("Drag"));
  this->Trace.reset(new vtkSMTrace::TraceItem("PropertiesModified"));
  *this->Trace = vtkSMTrace::TraceItemArgs().arg("proxy", this->Widget->proxy());
  this->TooSlow = false;
  this->IsFirst = true;
  this->IsOfNewModel = false;
  this->IsSketching = this->View && this->Canvas.open(this->Deformation, this->View->getViewProxy()) &&
                      pqChainMailSketch::canShow(this->Deformation);
  if (!this->IsSketching)
  {
    this->borrow("RelaxationPreset", this->KeptPreset, 1);
  }
  this->setDrawnByParaView(false);
}

//------------------------------------------------------------------------------
void pqChainMailDrag::follow()
{
  if (this->Deformation == nullptr || this->IsDrawing || this->TooSlow || this->View == nullptr)
  {
    return;
  }
  this->IsDrawing = true;
  if (this->IsSketching)
  {
    this->drawSketch();
  }
  else
  {
    this->drawItself();
  }
  this->IsDrawing = false;
  this->Rest.start();
}

//------------------------------------------------------------------------------
void pqChainMailDrag::beginSketch()
{
  if (this->Sketch == nullptr || this->Sketch->deformation() != this->Deformation)
  {
    this->Sketch = std::make_unique<pqChainMailSketch>(this->Deformation, this->Widget->proxy());
  }
  this->Sketch->begin();
  this->IsFirst = false;
}

void pqChainMailDrag::drawSketch()
{
  if (this->IsFirst)
  {
    this->beginSketch();
  }
  QElapsedTimer clock;
  clock.start();
  vtkImageData* image = this->Sketch->update(vtkSMPropertyHelper(this->View->getProxy(), "ViewTime").GetAsDouble());
  this->Canvas.draw(image, false);
  vtkVLogF(PARAVIEW_LOG_APPLICATION_VERBOSITY(),
    "Tissue followed in %d ms: sketch of every %d. voxel %.0f, rays for every %d. pixel %.0f",
    static_cast<int>(clock.elapsed()), this->Sketch->step(), this->Sketch->milliseconds(),
    this->Canvas.mapper()->GetStep(), this->Canvas.mapper()->GetMilliseconds());
}

//------------------------------------------------------------------------------
void pqChainMailDrag::drawItself()
{
  QElapsedTimer clock;
  clock.start();
  this->Widget->apply();
  this->View->getViewProxy()->InteractiveRender();
  const double drawing = this->Canvas.isOpen() ? this->Canvas.mapper()->GetMilliseconds() : 0.0;
  this->adapt(static_cast<double>(clock.elapsed()));
  vtkVLogF(PARAVIEW_LOG_APPLICATION_VERBOSITY(), "Tissue followed in %d ms: drawing %.0f",
    static_cast<int>(clock.elapsed()), drawing);
}

//------------------------------------------------------------------------------
void pqChainMailDrag::refine()
{
  // The hand rests with the button held: it must not wait long when it goes on.
  if (this->Deformation && this->Canvas.isOpen() && !this->IsDrawing && !this->TooSlow &&
      this->Canvas.mapper()->GetStep() > 1 && this->Canvas.mapper()->GetFineMilliseconds() < 1000.0)
  {
    this->IsDrawing = true;
    this->Canvas.redraw(true);
    this->IsDrawing = false;
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::finish()
{
  this->Next.stop();
  this->Rest.stop();
  if (this->Deformation == nullptr)
  {
    return;
  }
  this->setDrawnByParaView(true);
  this->KeptRenders = -1;
  this->Canvas.close();
  this->giveBack("RelaxationPreset", this->KeptPreset);
  this->giveBack("ModelReduction", this->KeptReduction);
  this->Deformation = nullptr;
  if (this->Widget)
  {
    this->Widget->apply();
  }
  this->Trace.reset();
  // As with the button Apply: the states of the panel, and the views. All of it is one step of Undo.
  QWidget* window = pqCoreUtilities::mainWidget();
  auto* panel = window ? window->findChild<pqPropertiesPanel*>() : nullptr;
  if (panel == nullptr)
  {
    END_UNDO_SET();
    return;
  }
  QTimer::singleShot(0, panel,
    [panel]
    {
      panel->apply();
      END_UNDO_SET();
    });
}

//------------------------------------------------------------------------------
void pqChainMailDrag::setDrawnByParaView(bool drawn)
{
  // Each frame shows the probe where the mouse has it. What ParaView draws besides, for every movement, is the tissue
  // of the frame before once more.
  if (this->View)
  {
    vtkSMPropertyHelper helper(this->View->getProxy(), "EnableRenderOnInteraction", true);
    this->KeptRenders = this->KeptRenders < 0 ? helper.GetAsInt() : this->KeptRenders;
    helper.Set(drawn ? this->KeptRenders : 0);
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::borrow(const char* property, int& kept, int value)
{
  vtkSMPropertyHelper helper(this->Deformation, property);
  kept = kept < 0 ? helper.GetAsInt() : kept;
  helper.Set(value);
  this->Deformation->UpdateVTKObjects();
}

void pqChainMailDrag::giveBack(const char* property, int& kept)
{
  if (kept >= 0)
  {
    vtkSMPropertyHelper(this->Deformation, property).Set(kept);
    this->Deformation->UpdateVTKObjects();
    kept = -1;
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::adapt(double milliseconds)
{
  const bool isOfNewModel = this->IsOfNewModel;
  const bool isFirst = this->IsFirst;
  this->IsOfNewModel = this->IsFirst = false;
  const int reduction = vtkSMPropertyHelper(this->Deformation, "ModelReduction").GetAsInt();
  if (milliseconds > 1.3 * AllowedMilliseconds && !isOfNewModel && reduction < 8 && this->isReducible() &&
      this->millisecondsOfElements() > 0.4 * milliseconds)
  {
    this->borrow("ModelReduction", this->KeptReduction, 2 * reduction);
    this->IsOfNewModel = true;
  }
  else if (milliseconds > 1000.0 && !isOfNewModel && !isFirst)
  {
    this->TooSlow = true;
    this->setDrawnByParaView(true);
  }
}

bool pqChainMailDrag::isReducible() const
{
  // Step by step, another model would start from rest, and bodies cannot be told apart in it.
  const char* bodies = vtkSMPropertyHelper(this->Deformation, "BodyArray").GetAsString();
  return vtkSMPropertyHelper(this->Deformation, "Mode").GetAsInt() == 0 && (bodies == nullptr || *bodies == '\0') &&
         vtkSMPropertyHelper(this->Deformation, "JointSize").GetAsInt() == 0;
}

double pqChainMailDrag::millisecondsOfElements() const
{
  auto* source = vtkSMSourceProxy::SafeDownCast(this->Deformation);
  vtkPVDataInformation* data = source ? source->GetDataInformation(0) : nullptr;
  vtkPVArrayInformation* times = data ? data->GetArrayInformation("Milliseconds", vtkDataObject::FIELD) : nullptr;
  return times && times->GetNumberOfComponents() == 5 ? times->GetComponentRange(1)[0] + times->GetComponentRange(2)[0]
                                                      : 0.0;
}
