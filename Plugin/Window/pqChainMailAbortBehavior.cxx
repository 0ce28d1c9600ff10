// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailAbortBehavior.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqPipelineSource.h"
#include "pqProgressManager.h"
#include "pqProgressWidget.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqView.h"

#include "vtkChainMailDeformation.h"
#include "vtkCommand.h"
#include "vtkPVVersion.h"
#include "vtkSMProxy.h"

#include <QAbstractEventDispatcher>
#include <QApplication>
#include <QTimer>
#include <QToolButton>
#include <QWidget>
#include <QWindow>

namespace
{
// Updates that take less are not worth a click, and dragged tissue must not wait for events.
constexpr int MillisecondsBefore = 500;
constexpr int MillisecondsBetween = 100;
// What ParaView draws a moment later, for what was stopped, must not begin it anew.
constexpr int MillisecondsAfter = 500;

#if QT_VERSION < QT_VERSION_CHECK(6, 0, 0)
QPoint PlaceOf(const QMouseEvent* event)
{
  return event->globalPos();
}

QMouseEvent* CopyOf(const QMouseEvent* event)
{
  return new QMouseEvent(*event);
}
#else
QPoint PlaceOf(const QMouseEvent* event)
{
  return event->globalPosition().toPoint();
}

QMouseEvent* CopyOf(const QMouseEvent* event)
{
  return event->clone();
}
#endif

bool IsOver(const QWidget* widget, const QMouseEvent* event)
{
  return widget->rect().contains(widget->mapFromGlobal(PlaceOf(event)));
}

bool IsOverView(const QMouseEvent* event)
{
  for (pqView* view : pqApplicationCore::instance()->getServerManagerModel()->findItems<pqView*>())
  {
    const QWidget* widget = view->widget();
    if (widget && widget->isVisible() && IsOver(widget, event))
    {
      return true;
    }
  }
  return false;
}
}

//------------------------------------------------------------------------------
pqChainMailAbortBehavior::pqChainMailAbortBehavior(QObject* parent)
  : Superclass(parent)
{
#if PARAVIEW_VERSION_NUMBER < PARAVIEW_VERSION_CHECK(6, 2, 0)
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  QObject::connect(model, &pqServerManagerModel::sourceAdded, this, &pqChainMailAbortBehavior::watch);
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    this->watch(source);
  }
  pqProgressManager* progress = pqApplicationCore::instance()->getProgressManager();
  QObject::connect(progress, QOverload<bool>::of(&pqProgressManager::enableProgress), this,
    [this](bool busy)
    {
      this->IsParaViewBusy = busy;
      if (!busy && !this->IsUpdating && this->PutOff.empty())
      {
        qApp->removeEventFilter(this);
      }
      QTimer::singleShot(0, this, &pqChainMailAbortBehavior::catchUp);
    });
  // ParaView 6.1 is about to handle events, also while something else than a deformation is updated.
  QObject::connect(progress, &pqProgressManager::progress, this,
    [this]
    {
      if (this->IsParaViewBusy)
      {
        qApp->installEventFilter(this);
      }
    });
#endif
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::watch(pqPipelineSource* source)
{
  vtkSMProxy* proxy = source->getServer()->isRemote() ? nullptr : source->getProxy();
  auto* deformation = vtkChainMailDeformation::SafeDownCast(proxy ? proxy->GetClientSideObject() : nullptr);
  if (deformation)
  {
    pqCoreUtilities::connect(deformation, vtkCommand::StartEvent, this, SLOT(begin()));
    pqCoreUtilities::connect(deformation, vtkCommand::ProgressEvent, this, SLOT(listen(vtkObject*)));
    pqCoreUtilities::connect(deformation, vtkCommand::EndEvent, this, SLOT(end()));
  }
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::begin()
{
  if (this->Button == nullptr)
  {
    QWidget* window = pqCoreUtilities::mainWidget();
    auto* progress = window ? window->findChild<pqProgressWidget*>() : nullptr;
    this->Button = progress ? progress->abortButton() : nullptr;
  }
  this->Clock.start();
  // The button of the mouse that is held goes up where it went down, and a dialog such as that of an animation handles
  // events itself.
  this->MayListen =
    this->Button && QApplication::mouseButtons() == Qt::NoButton && QApplication::activeModalWidget() == nullptr;
  if (this->MayListen)
  {
    this->IsUpdating = true;
    // The last filter is the first to see an event: before ParaView's own, which drops clicks.
    qApp->installEventFilter(this);
  }
}

void pqChainMailAbortBehavior::end()
{
  this->enable(false);
  this->IsUpdating = false;
  if (this->PutOff.empty())
  {
    qApp->removeEventFilter(this);
  }
  for (QWidget* view : this->Undrawn)
  {
    view->update();
  }
  this->Undrawn.clear();
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::listen(vtkObject* deformation)
{
  if (this->MayListen && !this->IsListening && !this->IsStopped &&
      this->Clock.hasExpired(this->IsEnabled ? MillisecondsBetween : MillisecondsBefore))
  {
    this->enable(true);
    this->handleEvents();
    this->Clock.start();
  }
  if (this->IsStopped)
  {
    this->stop(static_cast<vtkAlgorithm*>(deformation));
  }
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::enable(bool enabled)
{
  if (this->Button && enabled != this->IsEnabled)
  {
    pqApplicationCore::instance()->getProgressManager()->setEnableAbort(enabled);
    this->IsEnabled = enabled;
  }
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::handleEvents()
{
  this->IsListening = true;
  // All that have come: in a time that is given, few are handled where the machine is busy. Timers may never end, so
  // they are counted.
  int left = 100;
  while (QAbstractEventDispatcher::instance()->processEvents(QEventLoop::ExcludeSocketNotifiers) && --left > 0)
  {
  }
  this->IsListening = false;
}

//------------------------------------------------------------------------------
bool pqChainMailAbortBehavior::eventFilter(QObject* receiver, QEvent* event)
{
  switch (event->type())
  {
  case QEvent::MouseButtonPress:
  case QEvent::MouseButtonDblClick:
    if (IsOverView(static_cast<QMouseEvent*>(event)))
    {
      this->putOff(receiver, static_cast<QMouseEvent*>(event));
      return true;
    }
    if (this->IsUpdating && this->Button && this->Button->isEnabled() &&
        IsOver(this->Button, static_cast<QMouseEvent*>(event)))
    {
      this->IsStopped = true;
      this->enable(false);
    }
    return this->IsUpdating;
  case QEvent::MouseButtonRelease:
  case QEvent::MouseMove:
    if (!this->PutOff.empty())
    {
      this->putOff(receiver, static_cast<QMouseEvent*>(event));
      return true;
    }
    return this->IsUpdating;
  default:
    return this->IsUpdating && this->takesAway(receiver, event);
  }
}

bool pqChainMailAbortBehavior::takesAway(QObject* receiver, QEvent* event)
{
  switch (event->type())
  {
  case QEvent::Close:
    event->ignore();
    return true;
  case QEvent::ShortcutOverride:
    event->accept(); // else it is looked for among the shortcuts
    return true;
  case QEvent::Shortcut:
  case QEvent::KeyPress:
  case QEvent::KeyRelease:
  case QEvent::InputMethod:
  case QEvent::Wheel:
  case QEvent::ContextMenu:
  case QEvent::TabletPress:
  case QEvent::TabletMove:
  case QEvent::TabletRelease:
  case QEvent::TouchBegin:
  case QEvent::TouchUpdate:
  case QEvent::TouchEnd:
  case QEvent::NativeGesture:
  case QEvent::DragEnter:
  case QEvent::DragMove:
  case QEvent::Drop:
    return true;
  case QEvent::Timer:
    return true; // it comes again, also one that would have come once
  case QEvent::Paint:
    if (receiver->inherits("QOpenGLWidget"))
    {
      // A view of another size would update its pipelines, and this one is being updated.
      this->Undrawn.insert(static_cast<QWidget*>(receiver));
      return true;
    }
    return false;
  default:
    return false;
  }
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::stop(vtkAlgorithm* deformation)
{
  if (!deformation->GetAbortExecute())
  {
    // Until ParaView has done with what made it update, which may ask for several updates, also of other deformations.
    deformation->SetAbortExecute(1);
    if (this->Stopped.empty())
    {
      QTimer::singleShot(MillisecondsAfter, this, &pqChainMailAbortBehavior::release);
    }
    this->Stopped.emplace_back(deformation);
  }
  // The last event comes when the deformation has delivered what it shows instead. The pipeline would empty that.
  deformation->SetAbortOutput(false);
}

void pqChainMailAbortBehavior::release()
{
  for (const auto& deformation : this->Stopped)
  {
    if (deformation)
    {
      deformation->SetAbortExecute(0);
    }
  }
  this->Stopped.clear();
  this->IsStopped = false;
  this->catchUp();
}

//------------------------------------------------------------------------------
void pqChainMailAbortBehavior::putOff(QObject* receiver, const QMouseEvent* event)
{
  // Of the way of the mouse, the last place is what counts.
  if (event->type() == QEvent::MouseMove && this->PutOff.back().second->type() == QEvent::MouseMove)
  {
    this->PutOff.pop_back();
  }
  this->PutOff.emplace_back(receiver, CopyOf(event));
}

void pqChainMailAbortBehavior::catchUp()
{
  if (this->PutOff.empty() || this->IsParaViewBusy || !this->Stopped.empty())
  {
    return;
  }
  qApp->removeEventFilter(this);
  const auto events = std::exchange(this->PutOff, {});
  for (const auto& event : events)
  {
    if (event.first)
    {
      QCoreApplication::sendEvent(event.first, event.second.get());
    }
  }
}
