// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailDrag.h"

#include "ViewRay.h"

#include "pqCoreUtilities.h"
#include "pqInteractivePropertyWidget.h"
#include "pqPropertiesPanel.h"
#include "pqUndoStack.h"
#include "pqView.h"

#include "vtkCommand.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVLogger.h"
#include "vtkRenderWindow.h"
#include "vtkRenderWindowInteractor.h"
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

/// As the button Apply does: the states of the panel, and the views. Ends the step of Undo that the drag is.
void ApplyAll(const QPointer<pqView>& view)
{
  QWidget* window = pqCoreUtilities::mainWidget();
  if (auto* panel = window ? window->findChild<pqPropertiesPanel*>() : nullptr)
  {
    panel->apply();
  }
  END_UNDO_SET();
  // Where nothing has changed in the end, the view still shows the last picture of the drag.
  vtkRenderWindow* drawn = view ? view->getViewProxy()->GetRenderWindow() : nullptr;
  if (drawn && drawn->GetDesiredUpdateRate() >= 1.0)
  {
    view->forceRender();
  }
}
}

//------------------------------------------------------------------------------
pqChainMailDrag::pqChainMailDrag(pqInteractivePropertyWidget* widget)
  : QObject(widget)
  , Widget(widget)
{
  this->Silence->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  this->Silence->AbortFlagOnExecuteOn();
  this->Next.setSingleShot(true);
  QObject::connect(&this->Next, &QTimer::timeout, this, &pqChainMailDrag::follow);
  this->Rest.setSingleShot(true);
  this->Rest.setInterval(400);
  QObject::connect(&this->Rest, &QTimer::timeout, this, &pqChainMailDrag::refine);
  this->Applying.setSingleShot(true);
  QObject::connect(&this->Applying, &QTimer::timeout, this, &pqChainMailDrag::apply);
  QObject::connect(widget, &pqInteractivePropertyWidget::startInteraction, this, &pqChainMailDrag::start);
  QObject::connect(widget, &pqInteractivePropertyWidget::interaction, &this->Next, QOverload<>::of(&QTimer::start));
  QObject::connect(widget, &pqInteractivePropertyWidget::endInteraction, this, &pqChainMailDrag::finish);
  // Another view is active, as this one is closed, or another source is selected: nobody will see the button go up.
  QObject::connect(widget, &pqPropertyWidget::viewChanged, this, &pqChainMailDrag::finish);
  QObject::connect(widget, &pqInteractivePropertyWidget::widgetVisibilityUpdated, this,
    [this](bool visible)
    {
      if (!visible)
      {
        this->finish();
      }
    });
}

//------------------------------------------------------------------------------
pqChainMailDrag::~pqChainMailDrag()
{
  this->IsDrawing = false;
  this->finish(); // the source is deleted
  this->setDrawnByParaView(true);
  if (this->Applying.isActive())
  {
    QTimer::singleShot(0, [view = this->View] { ApplyAll(view); });
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::start()
{
  this->finish(); // the last drag, where nobody has seen the button go up
  if (this->IsUnderWay)
  {
    return;
  }
  if (this->Applying.isActive())
  {
    this->Applying.stop();
    this->apply();
  }
  this->Deformation = pqChainMailDrag::IsOn ? vtkChainMail::DeformationOf(this->Widget->proxy()) : nullptr;
  if (this->Deformation == nullptr)
  {
    return;
  }
  this->IsUnderWay = true;
  this->View = this->Widget->view();
  BEGIN_UNDO_SET(tr("Drag"));
  this->Trace.reset(new vtkSMTrace::TraceItem("PropertiesModified"));
  *this->Trace = vtkSMTrace::TraceItemArgs().arg("proxy", this->Widget->proxy());
  this->TooSlow = false;
  this->IsFirst = true;
  this->IsOfNewModel = false;
  this->IsPreviewing = this->View && this->Renderer.open(this->Deformation, this->View->getViewProxy()) &&
                       pqChainMailPreview::canShow(this->Deformation);
  if (!this->IsPreviewing)
  {
    this->borrow("RelaxationPreset", this->KeptPreset, 1);
  }
  this->setDrawnByParaView(false);
}

//------------------------------------------------------------------------------
void pqChainMailDrag::follow()
{
  if (!this->canDraw())
  {
    return;
  }
  this->IsDrawing = true;
  if (this->IsPreviewing)
  {
    this->drawPreview();
  }
  else
  {
    this->drawItself();
  }
  this->Rest.start();
  this->endDrawing();
}

bool pqChainMailDrag::canDraw() const
{
  return this->IsUnderWay && this->Deformation && this->View && !this->IsDrawing && !this->TooSlow;
}

void pqChainMailDrag::endDrawing()
{
  this->IsDrawing = false;
  if (this->IsOver)
  {
    this->finish();
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::beginPreview()
{
  if (this->Preview == nullptr || this->Preview->deformation() != this->Deformation)
  {
    this->Preview = std::make_unique<pqChainMailPreview>(this->Deformation, this->Widget->proxy());
  }
  this->Preview->begin();
  this->IsFirst = false;
}

void pqChainMailDrag::drawPreview()
{
  if (this->IsFirst)
  {
    this->beginPreview();
  }
  QElapsedTimer clock;
  clock.start();
  vtkImageData* image = this->Preview->update(vtkSMPropertyHelper(this->View->getProxy(), "ViewTime").GetAsDouble());
  Q_EMIT this->previewed(image->GetFieldData()->GetArray("ProbeReached"));
  this->Renderer.draw(image, false);
  vtkVLogF(PARAVIEW_LOG_APPLICATION_VERBOSITY(),
    "Tissue followed in %d ms: preview of every %d. voxel %.0f, rays for every %d. pixel %.0f",
    static_cast<int>(clock.elapsed()), this->Preview->step(), this->Preview->milliseconds(),
    this->Renderer.mapper()->GetStep(), this->Renderer.mapper()->GetMilliseconds());
}

//------------------------------------------------------------------------------
void pqChainMailDrag::drawItself()
{
  QElapsedTimer clock;
  clock.start();
  this->Widget->apply();
  this->View->getViewProxy()->InteractiveRender();
  const double drawing = this->Renderer.isOpen() ? this->Renderer.mapper()->GetMilliseconds() : 0.0;
  this->adapt(static_cast<double>(clock.elapsed()));
  vtkVLogF(PARAVIEW_LOG_APPLICATION_VERBOSITY(), "Tissue followed in %d ms: drawing %.0f",
    static_cast<int>(clock.elapsed()), drawing);
}

//------------------------------------------------------------------------------
void pqChainMailDrag::refine()
{
  // The hand rests with the button held: it must not wait long when it goes on.
  if (this->canDraw() && this->Renderer.isOpen() && this->Renderer.mapper()->GetStep() > 1 &&
      this->Renderer.mapper()->GetFineMilliseconds() < 1000.0)
  {
    this->IsDrawing = true;
    this->Renderer.redraw(true);
    this->endDrawing();
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::finish()
{
  this->Next.stop();
  this->Rest.stop();
  this->IsOver = this->IsUnderWay && this->IsDrawing;
  if (!this->IsUnderWay || this->IsDrawing)
  {
    return;
  }
  this->IsUnderWay = false;
  this->Renderer.close();
  if (this->Preview)
  {
    this->Preview->end();
  }
  this->giveBack("RelaxationPreset", this->KeptPreset);
  this->giveBack("ModelReduction", this->KeptReduction);
  this->Deformation = nullptr;
  if (this->Widget)
  {
    this->Widget->apply();
  }
  this->Trace.reset();
  this->setDrawnByParaView(false);
  this->Applying.start();
}

//------------------------------------------------------------------------------
void pqChainMailDrag::apply()
{
  this->setDrawnByParaView(true);
  ApplyAll(this->View);
}

//------------------------------------------------------------------------------
void pqChainMailDrag::setDrawnByParaView(bool drawn)
{
  if (this->Silenced)
  {
    this->Silenced->RemoveObserver(this->Silence);
    this->Silenced = nullptr;
  }
  vtkRenderWindow* window = this->View && !drawn ? this->View->getViewProxy()->GetRenderWindow() : nullptr;
  if (window && window->GetInteractor())
  {
    // Each frame shows the probe where the mouse has it. What ParaView draws besides, for every movement, is the tissue
    // of the frame before once more; and when the button goes up after an interaction that it has seen, what is drawn
    // again at once for what is applied.
    this->Silenced = window->GetInteractor();
    this->Silenced->AddObserver(vtkCommand::RenderEvent, this->Silence, 1.0f);
    this->Silenced->AddObserver(vtkCommand::InteractionEvent, this->Silence, 1.0f);
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
  if (kept >= 0 && this->Deformation)
  {
    vtkSMPropertyHelper(this->Deformation, property).Set(kept);
    this->Deformation->UpdateVTKObjects();
  }
  kept = -1;
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
