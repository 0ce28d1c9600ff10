// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailProbeGlyph.h"

#include "Probes.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqInteractivePropertyWidget.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"
#include "pqView.h"

#include "vtkActor.h"
#include "vtkBillboardTextActor3D.h"
#include "vtkCallbackCommand.h"
#include "vtkDataArray.h"
#include "vtkInteractorObserver.h"
#include "vtkLineRepresentation.h"
#include "vtkMath.h"
#include "vtkPVRenderView.h"
#include "vtkPolyDataMapper.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkSMNewWidgetRepresentationProxy.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMUncheckedPropertyHelper.h"
#include "vtkSMViewProxy.h"
#include "vtkSphereSource.h"
#include "vtkTextProperty.h"

#include <QTimer>

#include <algorithm>
#include <cmath>

namespace
{
// Told apart from each other by people who see few colours, too, and from skin, flesh and bone.
const double PositionColour[3] = { 1.0, 0.85, 0.1 };
const double TargetColour[3] = { 0.1, 0.45, 1.0 };

// The report names what holds a probe that came less far than this share of its way.
constexpr double FarEnough = 0.9;
constexpr double MarkPixels = 5.0; // its radius
}

//------------------------------------------------------------------------------
pqChainMailProbeGlyph::pqChainMailProbeGlyph(pqInteractivePropertyWidget* widget)
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

  vtkNew<vtkPolyDataMapper> markMapper;
  markMapper->SetInputConnection(this->Mark->GetOutputPort());
  this->MarkActor->SetMapper(markMapper);
  this->MarkActor->PickableOff();
  this->MarkActor->GetProperty()->LightingOff();
  this->Label->PickableOff();
  this->Label->SetDisplayOffset(8, 8);
  this->Label->GetTextProperty()->SetFontSize(16);
  this->Label->GetTextProperty()->SetBackgroundColor(0.0, 0.0, 0.0);
  this->Label->GetTextProperty()->SetBackgroundOpacity(0.5);

  if (vtkLineRepresentation* line = this->line())
  {
    line->GetEndPointProperty()->SetColor(PositionColour[0], PositionColour[1], PositionColour[2]);
    line->GetEndPoint2Property()->SetColor(TargetColour[0], TargetColour[1], TargetColour[2]);
  }
  this->BeforeFrame->SetClientData(this);
  this->BeforeFrame->SetCallback(
    [](vtkObject*, unsigned long, void* self, void*) { static_cast<pqChainMailProbeGlyph*>(self)->place(); });
  QObject::connect(widget, &pqInteractivePropertyWidget::widgetVisibilityUpdated, this, &pqChainMailProbeGlyph::show);
  QObject::connect(pqApplicationCore::instance()->getServerManagerModel(), &pqServerManagerModel::dataUpdated, this,
    [this](pqPipelineSource* updated)
    {
      if (this->Renderer && updated->getProxy() == vtkChainMail::DeformationOf(this->Widget->proxy()))
      {
        this->readReached();
      }
    });
  // Where a drag has changed nothing in the end, there is no update.
  QObject::connect(widget, &pqInteractivePropertyWidget::endInteraction, this, &pqChainMailProbeGlyph::readReached);
  // A radius that is typed is seen before it is applied.
  pqCoreUtilities::connect(
    widget->proxy()->GetProperty("Radius"), vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(render()));
}

//------------------------------------------------------------------------------
pqChainMailProbeGlyph::~pqChainMailProbeGlyph()
{
  this->show(false);
}

//------------------------------------------------------------------------------
vtkLineRepresentation* pqChainMailProbeGlyph::line() const
{
  vtkSMProxy* shown = this->Widget->widgetProxy()->GetRepresentationProxy();
  return vtkLineRepresentation::SafeDownCast(shown ? shown->GetClientSideObject() : nullptr);
}

std::array<vtkProp*, 3> pqChainMailProbeGlyph::props() const
{
  return { { this->Actor, this->MarkActor, this->Label } };
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::show(bool shown)
{
  if (this->Renderer)
  {
    for (vtkProp* prop : this->props())
    {
      this->Renderer->RemoveViewProp(prop);
    }
    this->Renderer->RemoveObserver(this->BeforeFrame);
    this->Renderer = nullptr;
  }
  pqView* view = shown ? this->Widget->view() : nullptr;
  auto* client = vtkPVRenderView::SafeDownCast(view ? view->getViewProxy()->GetClientSideView() : nullptr);
  if (client && this->line())
  {
    // Where ParaView draws the line: over what servers have drawn.
    this->Renderer = client->GetNonCompositedRenderer();
    for (vtkProp* prop : this->props())
    {
      this->Renderer->AddViewProp(prop);
    }
    this->Renderer->AddObserver(vtkCommand::StartEvent, this->BeforeFrame);
    this->readReached();
  }
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::readReached()
{
  vtkSMProxy* deformation = vtkChainMail::DeformationOf(this->Widget->proxy());
  this->HasReached = deformation && vtkChainMail::ReachedBy(deformation, this->Widget->proxy(), this->Reached);
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::setReached(vtkDataArray* reached)
{
  vtkSMProxy* deformation = vtkChainMail::DeformationOf(this->Widget->proxy());
  const long long n = deformation ? vtkChainMail::FirstProbeOf(deformation, this->Widget->proxy()) : -1;
  this->HasReached = reached && n >= 0 && n < reached->GetNumberOfTuples() && reached->GetNumberOfComponents() == 3;
  if (this->HasReached)
  {
    reached->GetTuple(n, this->Reached.data());
  }
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::place()
{
  double position[3];
  double target[3];
  this->line()->GetPoint1WorldPosition(position);
  this->line()->GetPoint2WorldPosition(target);
  const double radius = vtkSMUncheckedPropertyHelper(this->Widget->proxy(), "Radius").GetAsDouble();
  this->Ball->SetCenter(position);
  this->Ball->SetRadius(std::max(radius, 0.0));
  this->Actor->SetVisibility(radius > 0.0);
  this->placeMark(position, target);
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::placeMark(const double position[3], const double target[3])
{
  const double asked = std::sqrt(vtkMath::Distance2BetweenPoints(position, target));
  const double reached = vtkMath::Norm(this->Reached.data());
  const bool isAnchor = vtkSMUncheckedPropertyHelper(this->Widget->proxy(), "Anchor").GetAsInt() != 0;
  const bool isSoft = vtkSMUncheckedPropertyHelper(this->Widget->proxy(), "Tolerance").GetAsDouble() > 0.0;
  const bool isShort = this->HasReached && !isAnchor && !isSoft && reached < FarEnough * asked;
  this->MarkActor->SetVisibility(isShort);
  this->Label->SetVisibility(isShort);
  if (!isShort)
  {
    return;
  }
  double place[3];
  vtkMath::Add(position, this->Reached.data(), place);
  // As large on the screen wherever it is.
  double display[3];
  double beside[4];
  vtkInteractorObserver::ComputeWorldToDisplay(this->Renderer, place[0], place[1], place[2], display);
  vtkInteractorObserver::ComputeDisplayToWorld(this->Renderer, display[0] + MarkPixels, display[1], display[2], beside);
  this->Mark->SetCenter(place);
  this->Mark->SetRadius(std::sqrt(vtkMath::Distance2BetweenPoints(place, beside)));
  this->Label->SetPosition(place);
  this->Label->SetInput(tr("%1 of %2 mm").arg(reached, 0, 'g', 3).arg(asked, 0, 'g', 3).toUtf8().constData());
}

//------------------------------------------------------------------------------
void pqChainMailProbeGlyph::render()
{
  if (this->Renderer && this->Widget->view())
  {
    this->Widget->view()->render();
  }
}
