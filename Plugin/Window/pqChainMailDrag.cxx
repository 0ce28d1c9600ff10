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
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMViewProxy.h"

#include <QElapsedTimer>

bool pqChainMailDrag::IsOn = true;

//------------------------------------------------------------------------------
pqChainMailDrag::pqChainMailDrag(pqInteractivePropertyWidget* widget)
  : QObject(widget)
  , Widget(widget)
{
  this->Next.setSingleShot(true);
  QObject::connect(&this->Next, &QTimer::timeout, this, &pqChainMailDrag::follow);
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
  if (this->Deformation)
  {
    BEGIN_UNDO_SET(tr("Drag"));
    this->Trace.reset(new vtkSMTrace::TraceItem("PropertiesModified"));
    *this->Trace = vtkSMTrace::TraceItemArgs().arg("proxy", this->Widget->proxy());
    this->TooSlow = false;
    this->IsFirst = true;
    this->borrow("RelaxationPreset", this->KeptPreset, 1);
  }
}

//------------------------------------------------------------------------------
void pqChainMailDrag::follow()
{
  pqView* view = this->Widget->view();
  if (this->Deformation == nullptr || this->IsDrawing || this->TooSlow || view == nullptr)
  {
    return;
  }
  this->IsDrawing = true;
  QElapsedTimer clock;
  clock.start();
  this->Widget->apply();
  // As ParaView draws while the camera is dragged: a volume is sampled as finely as time allows.
  view->getViewProxy()->InteractiveRender();
  this->adapt(static_cast<double>(clock.elapsed()));
  this->IsDrawing = false;
}

//------------------------------------------------------------------------------
void pqChainMailDrag::finish()
{
  this->Next.stop();
  if (this->Deformation == nullptr)
  {
    return;
  }
  this->giveBack("RelaxationPreset", this->KeptPreset);
  this->giveBack("ModelReduction", this->KeptReduction);
  this->Deformation = nullptr;
  this->Widget->apply();
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
void pqChainMailDrag::borrow(const char* property, int& kept, int value)
{
  vtkSMPropertyHelper helper(this->Deformation, property);
  kept = helper.GetAsInt();
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
  this->TooSlow = milliseconds > 1000.0 && !this->IsFirst;
  this->IsFirst = false;
  auto* source = vtkSMSourceProxy::SafeDownCast(this->Deformation);
  vtkPVDataInformation* data = source ? source->GetDataInformation(0) : nullptr;
  vtkPVArrayInformation* times = data ? data->GetArrayInformation("Milliseconds", vtkDataObject::FIELD) : nullptr;
  if (milliseconds < 150.0 || this->KeptReduction >= 0 || times == nullptr || times->GetNumberOfComponents() != 5)
  {
    return;
  }
  // Fewer elements help where they are what takes the time. Step by step, another model would start from rest, and
  // bodies cannot be told apart in it.
  const double elements = times->GetComponentRange(1)[0] + times->GetComponentRange(2)[0];
  const bool fromRest = vtkSMPropertyHelper(this->Deformation, "Mode").GetAsInt() == 0;
  const char* bodies = vtkSMPropertyHelper(this->Deformation, "BodyArray").GetAsString();
  const bool reducible =
    (bodies == nullptr || *bodies == '\0') && vtkSMPropertyHelper(this->Deformation, "JointSize").GetAsInt() == 0;
  if (fromRest && reducible && elements > 0.4 * milliseconds &&
      vtkSMPropertyHelper(this->Deformation, "ModelReduction").GetAsInt() == 1)
  {
    this->borrow("ModelReduction", this->KeptReduction, 2);
    this->TooSlow = false;
    this->IsFirst = true;
  }
}
