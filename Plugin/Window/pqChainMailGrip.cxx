// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailGrip.h"

#include "pqCoreUtilities.h"
#include "pqInteractivePropertyWidget.h"
#include "pqView.h"

#include "vtkActor.h"
#include "vtkCallbackCommand.h"
#include "vtkLineRepresentation.h"
#include "vtkPVRenderView.h"
#include "vtkPolyDataMapper.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkSMNewWidgetRepresentationProxy.h"
#include "vtkSMProperty.h"
#include "vtkSMUncheckedPropertyHelper.h"
#include "vtkSMViewProxy.h"
#include "vtkSphereSource.h"

#include <QTimer>

#include <algorithm>

namespace
{
// Told apart from each other by people who see few colours, too, and from skin, flesh and bone.
const double PositionColour[3] = { 1.0, 0.85, 0.1 };
const double TargetColour[3] = { 0.1, 0.45, 1.0 };
}

//------------------------------------------------------------------------------
pqChainMailGrip::pqChainMailGrip(pqInteractivePropertyWidget* widget)
  : QObject(widget)
  , Widget(widget)
{
  this->Ball->SetThetaResolution(48);
  this->Ball->SetPhiResolution(24);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(this->Ball->GetOutputPort());
  this->Actor->SetMapper(mapper);
  this->Actor->PickableOff();
  this->Actor->GetProperty()->SetColor(PositionColour[0], PositionColour[1], PositionColour[2]);
  this->Actor->GetProperty()->SetOpacity(0.3);
  this->Actor->GetProperty()->SetAmbient(0.6);
  this->Actor->GetProperty()->SetDiffuse(0.4);
  this->Actor->GetProperty()->BackfaceCullingOn();

  if (vtkLineRepresentation* line = this->line())
  {
    line->GetEndPointProperty()->SetColor(PositionColour[0], PositionColour[1], PositionColour[2]);
    line->GetEndPoint2Property()->SetColor(TargetColour[0], TargetColour[1], TargetColour[2]);
  }
  this->BeforeFrame->SetClientData(this);
  this->BeforeFrame->SetCallback(
    [](vtkObject*, unsigned long, void* self, void*) { static_cast<pqChainMailGrip*>(self)->place(); });
  QObject::connect(widget, &pqInteractivePropertyWidget::widgetVisibilityUpdated, this, &pqChainMailGrip::show);
  // A radius that is typed is seen before it is applied.
  pqCoreUtilities::connect(
    widget->proxy()->GetProperty("Radius"), vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(render()));
}

//------------------------------------------------------------------------------
pqChainMailGrip::~pqChainMailGrip()
{
  this->show(false);
}

//------------------------------------------------------------------------------
vtkLineRepresentation* pqChainMailGrip::line() const
{
  vtkSMProxy* shown = this->Widget->widgetProxy()->GetRepresentationProxy();
  return vtkLineRepresentation::SafeDownCast(shown ? shown->GetClientSideObject() : nullptr);
}

//------------------------------------------------------------------------------
void pqChainMailGrip::show(bool shown)
{
  if (this->Renderer)
  {
    this->Renderer->RemoveActor(this->Actor);
    this->Renderer->RemoveObserver(this->BeforeFrame);
    this->Renderer = nullptr;
  }
  pqView* view = shown ? this->Widget->view() : nullptr;
  auto* client = vtkPVRenderView::SafeDownCast(view ? view->getViewProxy()->GetClientSideView() : nullptr);
  if (client && this->line())
  {
    // Where ParaView draws the line: over what servers have drawn.
    this->Renderer = client->GetNonCompositedRenderer();
    this->Renderer->AddActor(this->Actor);
    this->Renderer->AddObserver(vtkCommand::StartEvent, this->BeforeFrame);
  }
}

//------------------------------------------------------------------------------
void pqChainMailGrip::place()
{
  double position[3];
  this->line()->GetPoint1WorldPosition(position);
  const double radius = vtkSMUncheckedPropertyHelper(this->Widget->proxy(), "Radius").GetAsDouble();
  this->Ball->SetCenter(position);
  this->Ball->SetRadius(std::max(radius, 0.0));
  this->Actor->SetVisibility(radius > 0.0);
}

//------------------------------------------------------------------------------
void pqChainMailGrip::render()
{
  if (this->Renderer && this->Widget->view())
  {
    this->Widget->view()->render();
  }
}
