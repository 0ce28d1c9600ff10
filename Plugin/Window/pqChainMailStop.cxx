// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailStop.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqPipelineSource.h"
#include "pqProgressManager.h"
#include "pqProgressWidget.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"

#include "vtkChainMailDeformation.h"
#include "vtkCommand.h"
#include "vtkPVVersion.h"
#include "vtkSMProxy.h"

#include <QAbstractEventDispatcher>
#include <QApplication>
#include <QMouseEvent>
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

bool IsOver(const QWidget* widget, const QMouseEvent* event)
{
#if QT_VERSION < QT_VERSION_CHECK(6, 0, 0)
  const QPoint place = event->globalPos();
#else
  const QPoint place = event->globalPosition().toPoint();
#endif
  return widget->rect().contains(widget->mapFromGlobal(place));
}
}

//------------------------------------------------------------------------------
pqChainMailStop::pqChainMailStop(QObject* parent)
  : Superclass(parent)
{
#if PARAVIEW_VERSION_NUMBER < PARAVIEW_VERSION_CHECK(6, 1, 0)
  pqApplicationCore* core = pqApplicationCore::instance();
  pqServerManagerModel* model = core->getServerManagerModel();
  QObject::connect(model, &pqServerManagerModel::sourceAdded, this, &pqChainMailStop::watch);
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    this->watch(source);
  }
  QObject::connect(
    core->getProgressManager(), &pqProgressManager::abort, this, [this] { this->IsStopped = this->IsListening; });
#endif
}

//------------------------------------------------------------------------------
void pqChainMailStop::watch(pqPipelineSource* source)
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
void pqChainMailStop::begin()
{
  this->Clock.start();
  // The button of the mouse that is held goes up where it went down, and a dialog such as that of an animation handles
  // events itself.
  this->MayListen = QApplication::mouseButtons() == Qt::NoButton && QApplication::activeModalWidget() == nullptr;
}

void pqChainMailStop::end()
{
  this->enable(false);
}

//------------------------------------------------------------------------------
void pqChainMailStop::listen(vtkObject* deformation)
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
void pqChainMailStop::enable(bool enabled)
{
  if (this->Button == nullptr)
  {
    QWidget* window = pqCoreUtilities::mainWidget();
    auto* progress = window ? window->findChild<pqProgressWidget*>() : nullptr;
    this->Button = progress ? progress->abortButton() : nullptr;
  }
  if (this->Button && enabled != this->IsEnabled)
  {
    pqApplicationCore::instance()->getProgressManager()->setEnableAbort(enabled);
    this->IsEnabled = enabled;
  }
}

//------------------------------------------------------------------------------
void pqChainMailStop::handleEvents()
{
  if (this->Button == nullptr)
  {
    return;
  }
  pqProgressManager* manager = pqApplicationCore::instance()->getProgressManager();
  this->IsListening = true;
  // ParaView's own filter would take away every click before the window has found out whose it is.
  const bool before = manager->unblockEvents(true);
  qApp->installEventFilter(this);
  // All that have come: in a time that is given, few are handled where the machine is busy. Timers may never end, so
  // they are counted.
  int left = 100;
  while (QAbstractEventDispatcher::instance()->processEvents(QEventLoop::ExcludeSocketNotifiers) && --left > 0)
  {
  }
  qApp->removeEventFilter(this);
  manager->unblockEvents(before);
  this->IsListening = false;
  for (QWidget* view : this->Undrawn)
  {
    view->update();
  }
  this->Undrawn.clear();
}

//------------------------------------------------------------------------------
bool pqChainMailStop::eventFilter(QObject* receiver, QEvent* event)
{
  switch (event->type())
  {
  case QEvent::MouseButtonPress:
  case QEvent::MouseButtonDblClick:
  case QEvent::MouseButtonRelease:
  case QEvent::MouseMove:
    return !this->Button || !(this->Button->isDown() || IsOver(this->Button, static_cast<QMouseEvent*>(event)));
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
    break;
  default:
    break;
  }
  return this->Superclass::eventFilter(receiver, event);
}

//------------------------------------------------------------------------------
void pqChainMailStop::stop(vtkAlgorithm* deformation)
{
  if (!deformation->GetAbortExecute())
  {
    // Until ParaView has done with what made it update, which may ask for several updates, also of other deformations.
    deformation->SetAbortExecute(1);
    if (this->Stopped.empty())
    {
      QTimer::singleShot(MillisecondsAfter, this, &pqChainMailStop::release);
    }
    this->Stopped.emplace_back(deformation);
  }
  // The last event comes when the deformation has delivered what it shows instead. The pipeline would empty that.
  deformation->SetAbortOutput(false);
}

void pqChainMailStop::release()
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
}
