// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPickDecorator.h"

#include "ViewRay.h"
#include "pqChainMailDrag.h"
#include "pqChainMailPoseWidget.h"
#include "pqChainMailProbeGlyph.h"
#include "pqChainMailSnapBehavior.h"

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
#include "vtkSMUncheckedPropertyHelper.h"

#include <QEvent>
#include <QKeySequence>
#include <QLabel>
#include <QTimer>

#include <cstring>

//------------------------------------------------------------------------------
pqChainMailPickDecorator::pqChainMailPickDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  if (auto* interactive = qobject_cast<pqInteractivePropertyWidget*>(parent))
  {
    auto* drag = new pqChainMailDrag(interactive);
    if (qobject_cast<pqLinePropertyWidget*>(parent))
    {
      new pqChainMailSnapBehavior(interactive);
    }
    if (qobject_cast<pqLinePropertyWidget*>(parent) && pqChainMailSnapBehavior::isPull(interactive->proxy()))
    {
      auto* grip = new pqChainMailProbeGlyph(interactive);
      QObject::connect(drag, &pqChainMailDrag::previewed, grip, &pqChainMailProbeGlyph::setReached);
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
  auto* help = parent->findChild<QLabel*>("pickLabel");
  if (help && !qobject_cast<pqChainMailPoseWidget*>(parent))
  {
    help->setText(qobject_cast<pqLinePropertyWidget*>(parent)
                    ? tr("With the mouse over the tissue, the keys 1 and 2 put the first and second end there, and P "
                         "the two in turn. While dragging, the keys X, Y and Z keep to that axis, L to the line.")
                    : tr("With the mouse over the tissue, the key P puts the middle there."));
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
  if (auto* pose = qobject_cast<pqChainMailPoseWidget*>(this->parentWidget()))
  {
    const std::array<pqChainMailSnapBehavior::Place, 2> ray =
      pqChainMailSnapBehavior::ray(proxy->GetRenderer(), at[0], at[1]);
    if (pose->hold({ ray[0][0], ray[0][1], ray[0][2], ray[1][0], ray[1][1], ray[1][2] }))
    {
      this->countAtOnce();
    }
    return;
  }
  const vtkChainMail::ViewRay sight(view->getServer()->proxyManager());
  vtkChainMail::Place hit;
  if (!pqChainMailSnapBehavior::pick(sight, proxy->GetRenderer(), at[0], at[1], hit))
  {
    return;
  }
  if (slot == nullptr)
  {
    slot = this->NextIsFirst ? "pickPoint1" : "pickPoint2";
    this->NextIsFirst = !this->NextIsFirst;
  }
  const auto put = [this](const char* end, const vtkChainMail::Place& place)
  {
    QMetaObject::invokeMethod(
      this->parentWidget(), end, Q_ARG(double, place[0]), Q_ARG(double, place[1]), Q_ARG(double, place[2]));
  };
  vtkSMProxy* source = this->parentWidget()->proxy();
  vtkChainMail::Place target = hit;
  const bool takesTarget = std::strcmp(slot, "pickPoint1") == 0 && pqChainMailSnapBehavior::isPull(source);
  for (unsigned int a = 0; takesTarget && a < 3; ++a)
  {
    target[a] += vtkSMUncheckedPropertyHelper(source, "Target").GetAsDouble(a) -
                 vtkSMUncheckedPropertyHelper(source, "Position").GetAsDouble(a);
  }
  put(slot, hit);
  if (takesTarget)
  {
    put("pickPoint2", target);
  }
  this->countAtOnce();
}

//------------------------------------------------------------------------------
void pqChainMailPickDecorator::countAtOnce()
{
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
