// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailSnapBehavior.h"

#include "ViewRay.h"

#include "pqInteractivePropertyWidget.h"
#include "pqView.h"

#include "vtkAbstractWidget.h"
#include "vtkCallbackCommand.h"
#include "vtkInteractorObserver.h"
#include "vtkLineRepresentation.h"
#include "vtkMath.h"
#include "vtkPointHandleRepresentation3D.h"
#include "vtkRenderWindow.h"
#include "vtkRenderWindowInteractor.h"
#include "vtkRenderer.h"
#include "vtkSMNewWidgetRepresentationProxy.h"
#include "vtkSMProxy.h"
#include "vtkSMRenderViewProxy.h"

#include <algorithm>

//------------------------------------------------------------------------------
pqChainMailSnapBehavior::pqChainMailSnapBehavior(pqInteractivePropertyWidget* widget)
  : QObject(widget)
  , Widget(widget)
{
  this->Observer->SetClientData(this);
  this->Observer->SetCallback(
    [](vtkObject*, unsigned long event, void* client, void*)
    {
      auto* self = static_cast<pqChainMailSnapBehavior*>(client);
      event == vtkCommand::StartInteractionEvent ? self->start() : self->move();
    });
  // Before ParaView reads where the ends are.
  this->Mouse = widget->widgetProxy()->GetWidget();
  if (this->Mouse)
  {
    this->Mouse->AddObserver(vtkCommand::StartInteractionEvent, this->Observer, 1.0f);
    this->Mouse->AddObserver(vtkCommand::InteractionEvent, this->Observer, 1.0f);
  }
  QObject::connect(widget, &pqInteractivePropertyWidget::endInteraction, this, [this] { this->ViewRay.reset(); });
}

//------------------------------------------------------------------------------
pqChainMailSnapBehavior::~pqChainMailSnapBehavior()
{
  if (this->Mouse)
  {
    this->Mouse->RemoveObserver(this->Observer);
  }
}

//------------------------------------------------------------------------------
bool pqChainMailSnapBehavior::isPull(vtkSMProxy* source)
{
  return source->GetProperty("Position") && source->GetProperty("Target");
}

//------------------------------------------------------------------------------
std::array<pqChainMailSnapBehavior::Place, 2> pqChainMailSnapBehavior::ray(vtkRenderer* renderer, double x, double y)
{
  std::array<Place, 2> ends;
  for (int n = 0; n < 2; ++n)
  {
    double world[4];
    vtkInteractorObserver::ComputeDisplayToWorld(renderer, x, y, n, world);
    std::copy_n(world, 3, ends[n].begin());
  }
  return ends;
}

bool pqChainMailSnapBehavior::pick(
  const vtkChainMail::ViewRay& sight, vtkRenderer* renderer, double x, double y, Place& hit)
{
  const std::array<Place, 2> ends = pqChainMailSnapBehavior::ray(renderer, x, y);
  return sight.IsValid() && sight.Pick(ends[0], ends[1], hit);
}

//------------------------------------------------------------------------------
vtkLineRepresentation* pqChainMailSnapBehavior::line() const
{
  vtkSMProxy* shown = this->Widget->widgetProxy()->GetRepresentationProxy();
  return vtkLineRepresentation::SafeDownCast(shown ? shown->GetClientSideObject() : nullptr);
}

vtkRenderer* pqChainMailSnapBehavior::renderer() const
{
  auto* view = vtkSMRenderViewProxy::SafeDownCast(this->Widget->view() ? this->Widget->view()->getProxy() : nullptr);
  return view ? view->GetRenderer() : nullptr;
}

const int* pqChainMailSnapBehavior::mouse() const
{
  return this->renderer()->GetRenderWindow()->GetInteractor()->GetEventPosition();
}

//------------------------------------------------------------------------------
pqChainMailSnapBehavior::Place pqChainMailSnapBehavior::end(int n) const
{
  Place place;
  n == 0 ? this->line()->GetPoint1WorldPosition(place.data()) : this->line()->GetPoint2WorldPosition(place.data());
  return place;
}

void pqChainMailSnapBehavior::setEnd(int n, const Place& place)
{
  Place copy = place;
  n == 0 ? this->line()->SetPoint1WorldPosition(copy.data()) : this->line()->SetPoint2WorldPosition(copy.data());
}

std::array<double, 2> pqChainMailSnapBehavior::onScreen(const Place& place) const
{
  double display[3];
  vtkInteractorObserver::ComputeWorldToDisplay(this->renderer(), place[0], place[1], place[2], display);
  return { { display[0], display[1] } };
}

//------------------------------------------------------------------------------
void pqChainMailSnapBehavior::start()
{
  this->ViewRay.reset();
  vtkLineRepresentation* line = this->line();
  if (line == nullptr || this->renderer() == nullptr)
  {
    return;
  }
  const int state = line->GetInteractionState();
  const bool isWhole = state == vtkLineRepresentation::OnLine;
  const bool isPull = pqChainMailSnapBehavior::isPull(this->Widget->proxy());
  this->IsDragged[0] = isWhole || state == vtkLineRepresentation::OnP1 || state == vtkLineRepresentation::TranslatingP1;
  this->IsDragged[1] =
    !isPull && (isWhole || state == vtkLineRepresentation::OnP2 || state == vtkLineRepresentation::TranslatingP2);
  if (!this->IsDragged[0] && !this->IsDragged[1])
  {
    return;
  }
  for (int n = 0; n < 2; ++n)
  {
    const std::array<double, 2> at = this->onScreen(this->end(n));
    this->FromMouse[n] = { { at[0] - this->mouse()[0], at[1] - this->mouse()[1] } };
  }
  this->Last = this->end(0);
  const Place second = this->end(1);
  vtkMath::Subtract(second.data(), this->Last.data(), this->Pull.data());
  this->ViewRay = std::make_unique<vtkChainMail::ViewRay>(this->Widget->proxy()->GetSessionProxyManager());
  if (!this->ViewRay->IsValid())
  {
    this->ViewRay.reset(); // there is nothing to keep to
  }
}

//------------------------------------------------------------------------------
void pqChainMailSnapBehavior::move()
{
  vtkRenderer* renderer = this->renderer();
  if (this->ViewRay == nullptr || renderer == nullptr || this->line()->GetPoint1Representation()->GetConstrained())
  {
    return;
  }
  Place on[2];
  bool isOnTissue[2];
  for (int n = 0; n < 2; ++n)
  {
    isOnTissue[n] = this->IsDragged[n] &&
                    pqChainMailSnapBehavior::pick(*this->ViewRay, renderer, this->mouse()[0] + this->FromMouse[n][0],
                      this->mouse()[1] + this->FromMouse[n][1], on[n]);
  }
  if (pqChainMailSnapBehavior::isPull(this->Widget->proxy()))
  {
    this->Last = isOnTissue[0] ? on[0] : this->Last;
    this->setEnd(0, this->Last);
    Place target;
    vtkMath::Add(this->Last.data(), this->Pull.data(), target.data());
    this->setEnd(1, target);
    return;
  }
  for (int n = 0; n < 2; ++n)
  {
    if (isOnTissue[n])
    {
      this->setEnd(n, on[n]);
    }
  }
}
