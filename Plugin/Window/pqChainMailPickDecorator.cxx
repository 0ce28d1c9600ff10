// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPickDecorator.h"

#include "Sight.h"
#include "pqChainMailDrag.h"
#include "pqChainMailGrip.h"

#include "pqInteractivePropertyWidget.h"
#include "pqKeySequences.h"
#include "pqLinePropertyWidget.h"
#include "pqModalShortcut.h"
#include "pqPointPickingHelper.h"
#include "pqPropertyWidget.h"
#include "pqRenderView.h"
#include "pqServer.h"
#include "pqShortcutDecorator.h"

#include "vtkRenderWindowInteractor.h"
#include "vtkRenderer.h"
#include "vtkSMProxy.h"
#include "vtkSMRenderViewProxy.h"

#include <QEvent>
#include <QKeySequence>
#include <QLabel>
#include <QTimer>

#include <algorithm>

namespace
{
/// Where the mouse points to at a depth of the picture, 0 the front and 1 the back.
vtkChainMail::Place PlaceUnderMouse(vtkRenderer* renderer, const int* at, double depth)
{
  renderer->SetDisplayPoint(at[0], at[1], depth);
  renderer->DisplayToWorld();
  const double* world = renderer->GetWorldPoint();
  return { { world[0] / world[3], world[1] / world[3], world[2] / world[3] } };
}
}

//------------------------------------------------------------------------------
pqChainMailPickDecorator::pqChainMailPickDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  if (auto* interactive = qobject_cast<pqInteractivePropertyWidget*>(parent))
  {
    new pqChainMailDrag(interactive);
    if (qobject_cast<pqLinePropertyWidget*>(parent) && interactive->proxy()->GetProperty("Radius"))
    {
      new pqChainMailGrip(interactive);
    }
  }
  // These would put an end to the origin where the mouse is over a volume.
  qDeleteAll(parent->findChildren<pqPointPickingHelper*>());
  if (qobject_cast<pqLinePropertyWidget*>(parent))
  {
    this->addKey("1", "pickPoint1");
    this->addKey("2", "pickPoint2");
    this->addKey("P", nullptr);
  }
  else
  {
    this->addKey("P", "setCenter");
  }
  if (auto* help = parent->findChild<QLabel*>("pickLabel"))
  {
    help->setText(
      tr("Over the tissue in the view, the keys 1 and 2 put the ends there, and P one after the other. While "
         "dragging, X, Y, Z and L keep to an axis or the line."));
  }
  parent->installEventFilter(this);
}

//------------------------------------------------------------------------------
void pqChainMailPickDecorator::addKey(const QString& key, const char* slot)
{
  pqPropertyWidget* widget = this->parentWidget();
  pqModalShortcut* shortcut = pqKeySequences::instance().addModalShortcut(QKeySequence(key), nullptr, widget);
  if (auto* frame = widget->findChild<pqShortcutDecorator*>())
  {
    frame->addShortcut(shortcut);
  }
  QObject::connect(shortcut, &pqModalShortcut::activated, this, [this, slot] { this->pick(slot); });
  const auto setView = [this, shortcut](pqView* view)
  {
    this->View = view;
    if (view && view->widget())
    {
      shortcut->setContextWidget(view->widget());
    }
  };
  QObject::connect(widget, &pqPropertyWidget::viewChanged, shortcut, setView);
  setView(widget->view());
}

//------------------------------------------------------------------------------
void pqChainMailPickDecorator::pick(const char* slot)
{
  auto* view = qobject_cast<pqRenderView*>(this->View);
  vtkSMRenderViewProxy* proxy = view ? view->getRenderViewProxy() : nullptr;
  if (proxy == nullptr || proxy->GetInteractor() == nullptr || proxy->GetRenderer() == nullptr)
  {
    return;
  }
  const int* at = proxy->GetInteractor()->GetEventPosition();
  const vtkChainMail::Place from = PlaceUnderMouse(proxy->GetRenderer(), at, 0.0);
  const vtkChainMail::Place to = PlaceUnderMouse(proxy->GetRenderer(), at, 1.0);
  const vtkChainMail::Sight sight(view->getServer()->proxyManager());
  vtkChainMail::Place hit;
  if (!sight.IsValid() || !sight.Pick(from, to, hit))
  {
    return;
  }
  if (slot == nullptr)
  {
    slot = this->NextIsFirst ? "pickPoint1" : "pickPoint2";
    this->NextIsFirst = !this->NextIsFirst;
  }
  QMetaObject::invokeMethod(
    this->parentWidget(), slot, Q_ARG(double, hit[0]), Q_ARG(double, hit[1]), Q_ARG(double, hit[2]));
  // A place that was picked counts at once, like a drag that has ended.
  if (auto* interactive = qobject_cast<pqInteractivePropertyWidget*>(this->parentWidget()))
  {
    Q_EMIT interactive->startInteraction();
    Q_EMIT interactive->endInteraction();
  }
}

//------------------------------------------------------------------------------
bool pqChainMailPickDecorator::eventFilter(QObject* widget, QEvent* event)
{
  auto* interactive = qobject_cast<pqInteractivePropertyWidget*>(widget);
  if (interactive && event->type() == QEvent::Show)
  {
    QTimer::singleShot(0, interactive, [interactive] { interactive->setWidgetVisible(true); });
  }
  return this->Superclass::eventFilter(widget, event);
}
