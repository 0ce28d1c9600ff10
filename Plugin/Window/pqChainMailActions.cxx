// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailActions.h"

#include "ChainMailPresets.h"
#include "Probes.h"
#include "pqChainMailAbortBehavior.h"
#include "pqChainMailDrag.h"
#include "pqChainMailLook.h"
#include "pqChainMailPipeline.h"
#include "pqChainMailTurnBone.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqDeleteReaction.h"
#include "pqOutputPort.h"
#include "pqPipelineBrowserWidget.h"
#include "pqPipelineSource.h"
#include "pqPresetGroupsManager.h"
#include "pqPropertiesPanel.h"
#include "pqProxySelection.h"
#include "pqRenderView.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqUndoStack.h"

#include "vtkChainMailDeformation.h"
#include "vtkNew.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMInputProperty.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxySelectionModel.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSettings.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTrace.h"
#include "vtkSmartPointer.h"

#include <QDockWidget>
#include <QKeyEvent>
#include <QMainWindow>
#include <QMenu>
#include <QMenuBar>
#include <QScrollArea>
#include <QSet>

#include <array>
#include <cstring>
#include <string>
#include <vector>

using namespace pqChainMailPipeline;

namespace
{
/// Makes the pull of a new probe one that tissue follows, as a change that traces tell of.
void FitPull(vtkSMSourceProxy* probe, vtkSMProxy* deformation, const vtkChainMail::ViewRay& sight)
{
  SM_SCOPED_TRACE(PropertiesModified).arg("proxy", probe);
  vtkChainMail::FitPull(probe, vtkSMSourceProxy::SafeDownCast(deformation), sight);
}

/// The inputs of deformations that a source is a probe, blade or drill for.
std::vector<vtkSMProperty*> UsesOf(vtkSMProxy* source)
{
  std::vector<vtkSMProperty*> uses;
  for (unsigned int n = 0; n < source->GetNumberOfConsumers(); ++n)
  {
    vtkSMProxy* consumer = source->GetConsumerProxy(n);
    vtkSMProperty* input = source->GetConsumerProperty(n);
    if (vtkChainMail::DeformationOf(consumer) == consumer && input && std::strcmp(input->GetXMLName(), "Input") != 0)
    {
      uses.push_back(input);
    }
  }
  return uses;
}

/// What is selected, where all of it is in use as probe, blade or drill; else nothing.
QSet<pqProxy*> SelectedTools()
{
  QSet<pqProxy*> tools;
  // Of the server manager: pqActiveObjects goes on naming for a while what was deleted.
  vtkSMProxySelectionModel* selected = pqActiveObjects::instance().activeSourcesSelectionModel();
  pqProxySelection selection;
  if (selected)
  {
    pqProxySelectionUtilities::copy(selected, selection);
  }
  for (pqServerManagerModelItem* item : selection)
  {
    auto* port = qobject_cast<pqOutputPort*>(item);
    pqPipelineSource* source = port ? port->getSource() : qobject_cast<pqPipelineSource*>(item);
    if (source == nullptr || UsesOf(source->getProxy()).empty())
    {
      return {};
    }
    tools.insert(source);
  }
  return tools;
}

/// Turns a view that is still as ParaView opens it, along z, to the patient's front: from above one sees the crown. The
/// front is where y is least or, where the image cuts off more tissue there, the other side. A stack of few slices,
/// which is thin from there, is left as it is.
void LookFromTheFront(pqRenderView* view, const vtkChainMail::ViewRay& sight)
{
  const std::array<double, 6>& bounds = sight.GetBounds();
  const bool isThin = bounds[5] - bounds[4] < 0.3 * (bounds[3] - bounds[2]);
  const bool isAsOpened = sight.ToWorld({ { 0, 0, 1 } }) == vtkChainMail::Place{ { 0, 0, 1 } } &&
                          sight.ToWorld({ { 0, 1, 0 } }) == vtkChainMail::Place{ { 0, 1, 0 } };
  if (isAsOpened && !isThin)
  {
    const std::array<double, 6> cutOff = sight.GetSharesCutOff();
    view->resetViewDirection(0, cutOff[2] > cutOff[3] ? -1 : 1, 0, 0, 0, 1);
  }
}

/// ParaView's chooser shows the presets of the group Default at first. It would save with the user's settings who is in
/// it.
void AddPresetsToDefaultGroup()
{
  auto* groups = qobject_cast<pqPresetGroupsManager*>(pqApplicationCore::instance()->manager("PRESET_GROUP_MANAGER"));
  auto* settings = vtkSMSettings::GetInstance();
  const char* const key = "TransferFunctionPresets.Groups";
  const std::string ofTheUser = settings->GetSettingAsString(key, "");
  for (const std::string& name : ChainMailPresetNames())
  {
    if (groups)
    {
      groups->addToGroup("Default", QString::fromStdString(name));
    }
  }
  settings->SetSetting(key, ofTheUser);
}
}

//------------------------------------------------------------------------------
pqChainMailActions::pqChainMailActions(QObject* parent)
  : Superclass(parent)
{
  this->setExclusive(false);
  vtkChainMailDeformation::SetGlobalProbeWarnings(false); // the panel says as much, and the view shows it
  new pqChainMailAbortBehavior(this);
  this->Grab = this->addAction("GrabTissue", tr("Grab Tissue"),
    tr("Grab the tissue of the selected scan with a probe and pull it a little. Then drag the ends of the probe's "
       "line."));
  QObject::connect(this->Grab, &QAction::triggered, this, &pqChainMailActions::grab);

  QAction* probe = this->addAction("AddProbe", tr("Add Probe"), tr("Grab the tissue at another place."));
  QObject::connect(probe, &QAction::triggered, this, [this] { this->addTo("Probes", "ChainMailProbe", 0.0); });
  QAction* blade = this->addAction(
    "AddBlade", tr("Add Blade"), tr("Cut the tissue with a blade. Then drag the ends of the incision over the skin."));
  QObject::connect(blade, &QAction::triggered, this, [this] { this->addTo("Cuts", "ChainMailBlade", 0.4); });
  QAction* drill =
    this->addAction("AddDrill", tr("Add Drill"), tr("Carve a ball out of the tissue. Then drag the ball."));
  QObject::connect(drill, &QAction::triggered, this, [this] { this->addTo("Carves", "ChainMailDrill", 0.3); });
  this->TurnBone = this->addAction("TurnBone", tr("Turn Bone"),
    tr("Hold the bone in the middle of the view. Then drag a face of its box to turn it, or the ball in the middle to "
       "move it. Bones are told apart by a label image that fits the scan, if there is one."));
  QObject::connect(this->TurnBone, &QAction::triggered, this, [] { pqChainMailTurnBone(); });
  this->Additions = { probe, blade, drill };
  this->Remove = this->addAction("RemoveFromTissue", tr("Remove"),
    tr("Disconnect the selected probe, blade or drill, and delete it. The key Delete in the Pipeline Browser does the "
       "same."));
  QObject::connect(this->Remove, &QAction::triggered, this, &pqChainMailActions::remove);
  QAction* follow = this->addAction(
    "Follow", tr("Follow"), tr("Deform the tissue while a probe, blade or drill is dragged. Off: deform it at Apply."));
  follow->setCheckable(true);
  follow->setChecked(pqChainMailDrag::IsOn);
  QObject::connect(follow, &QAction::toggled, this, [](bool on) { pqChainMailDrag::IsOn = on; });

  // Later than the signals: when a source becomes the active one, its state is not set yet.
  this->Later.setSingleShot(true);
  QObject::connect(&this->Later, &QTimer::timeout, this, &pqChainMailActions::updateEnableState);
  QObject::connect(&pqActiveObjects::instance(), SIGNAL(portChanged(pqOutputPort*)), &this->Later, SLOT(start()));
  QObject::connect(&pqActiveObjects::instance(), SIGNAL(dataUpdated()), &this->Later, SLOT(start()));
  QObject::connect(
    &pqActiveObjects::instance(), SIGNAL(selectionChanged(const pqProxySelection&)), &this->Later, SLOT(start()));
  QObject::connect(pqApplicationCore::instance(), SIGNAL(forceFilterMenuRefresh()), &this->Later, SLOT(start()));
  this->updateEnableState();
  this->Resized.setSingleShot(true);
  QObject::connect(&this->Resized, &QTimer::timeout, this, &pqChainMailActions::makeRoom);
  this->Drawn.setSingleShot(true);
  QObject::connect(&this->Drawn, &QTimer::timeout, this, &pqChainMailActions::widenPanel);
  QTimer::singleShot(0, this,
    [this]
    {
      this->addMenu(); // the window may not be there yet
      this->addToPipelineBrowser();
      AddPresetsToDefaultGroup();
    });
}

//------------------------------------------------------------------------------
QAction* pqChainMailActions::addAction(const QString& name, const QString& text, const QString& help)
{
  auto* action = new QAction(text, this);
  action->setObjectName("action" + name);
  action->setToolTip(help);
  action->setStatusTip(help);
  return this->Superclass::addAction(action);
}

//------------------------------------------------------------------------------
void pqChainMailActions::addMenu()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (window == nullptr)
  {
    return;
  }
  auto* menu = new QMenu(tr("T&issue"), window->menuBar());
  menu->setObjectName("menuTissue");
  menu->addActions(this->actions());
  menu->addSeparator();
  QMenu* looks = pqChainMailLook::MakeMenu();
  looks->setParent(menu, looks->windowFlags());
  menu->addMenu(looks);
  QAction* example = menu->addAction(tr("Open Example"), this, &pqChainMailActions::openExample);
  example->setObjectName("actionOpenExample");
  example->setStatusTip(tr("Make a forearm phantom with CT numbers, and grab its tissue."));
  const QList<QAction*> menus = window->menuBar()->actions();
  window->menuBar()->insertMenu(menus.isEmpty() ? nullptr : menus.last(), menu); // before Help
}

//------------------------------------------------------------------------------
void pqChainMailActions::makeRoom()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (this->Bar == nullptr && window)
  {
    for (QToolBar* bar : window->findChildren<QToolBar*>())
    {
      this->Bar = bar->actions().contains(this->Grab) ? bar : this->Bar.data();
    }
    if (this->Bar)
    {
      this->Bar->installEventFilter(this); // whenever its size changes
    }
  }
  // ParaView adds the bar before its own, in a line that is full; what does not fit in is hidden behind an arrow.
  if (this->Bar == nullptr || !this->Bar->isVisible() || this->Bar->isFloating() ||
      this->Bar->width() >= this->Bar->sizeHint().width())
  {
    return;
  }
  if (this->Moves == 0)
  {
    window->removeToolBar(this->Bar);
    window->addToolBar(this->Bar);
    this->Bar->show();
  }
  else if (this->Moves == 1)
  {
    window->insertToolBarBreak(this->Bar);
  }
  ++this->Moves; // then it stays where the user puts it
}

//------------------------------------------------------------------------------
void pqChainMailActions::widenPanel()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  auto* panel = window ? window->findChild<pqPropertiesPanel*>() : nullptr;
  auto* area = panel ? panel->findChild<QScrollArea*>() : nullptr;
  QWidget* dock = panel;
  while (dock && !qobject_cast<QDockWidget*>(dock))
  {
    dock = dock->parentWidget();
  }
  if (area == nullptr || area->widget() == nullptr || dock == nullptr)
  {
    return;
  }
  const int needed = area->widget()->minimumSizeHint().width();
  const int missing = needed - area->viewport()->width();
  if (missing > 0 && needed > this->WidestPanel)
  {
    this->WidestPanel = needed; // who makes it narrower again gets it narrower
    window->resizeDocks({ static_cast<QDockWidget*>(dock) }, { dock->width() + missing }, Qt::Horizontal);
  }
}

//------------------------------------------------------------------------------
void pqChainMailActions::addToPipelineBrowser()
{
  QWidget* window = pqCoreUtilities::mainWidget();
  auto* browser = window ? window->findChild<pqPipelineBrowserWidget*>() : nullptr;
  if (browser == nullptr)
  {
    return;
  }
  auto* remove = new QAction(tr("Remove from Tissue"), browser);
  remove->setObjectName("actionPBRemoveFromTissue");
  QObject::connect(remove, &QAction::triggered, this, &pqChainMailActions::remove);
  QObject::connect(
    browser->contextMenu(), &QMenu::aboutToShow, remove, [remove] { remove->setVisible(!SelectedTools().isEmpty()); });
  browser->contextMenu()->insertAction(browser->findChild<QAction*>("actionPBDelete"), remove);
  browser->installEventFilter(this);
}

//------------------------------------------------------------------------------
bool pqChainMailActions::eventFilter(QObject* watched, QEvent* event)
{
  if (watched == this->Bar)
  {
    if (event->type() == QEvent::Resize)
    {
      this->Resized.start();
    }
    return this->Superclass::eventFilter(watched, event);
  }
  const int key = event->type() == QEvent::KeyPress ? static_cast<QKeyEvent*>(event)->key() : 0;
  if ((key == Qt::Key_Delete || key == Qt::Key_Backspace) && !SelectedTools().isEmpty())
  {
    this->remove();
    return true;
  }
  return this->Superclass::eventFilter(watched, event);
}

//------------------------------------------------------------------------------
void pqChainMailActions::updateEnableState()
{
  pqOutputPort* port = pqActiveObjects::instance().activePort();
  pqPipelineSource* source = port ? port->getSource() : nullptr;
  const bool unapplied = source && source->modifiedState() == pqProxy::UNINITIALIZED;
  const bool deformed = source && !unapplied && vtkChainMail::DeformationOf(source->getProxy()) != nullptr;
  this->Grab->setEnabled(source && (unapplied || isImage(port)));
  this->TurnBone->setEnabled(deformed || this->Grab->isEnabled());
  this->Remove->setEnabled(!SelectedTools().isEmpty());
  this->makeRoom();
  pqView* view = pqActiveObjects::instance().activeView();
  if (deformed && view)
  {
    QObject::connect(view, SIGNAL(endRender()), &this->Drawn, SLOT(start()), Qt::UniqueConnection);
  }
  for (QAction* addition : this->Additions)
  {
    addition->setEnabled(deformed);
  }
}

//------------------------------------------------------------------------------
void pqChainMailActions::grab()
{
  pqActiveObjects& active = pqActiveObjects::instance();
  pqOutputPort* port = active.activePort();
  auto* view = qobject_cast<pqRenderView*>(active.activeView());
  if (port == nullptr || view == nullptr)
  {
    return;
  }
  pqPipelineSource* scan = port->getSource();
  vtkSMViewProxy* viewProxy = view->getViewProxy();
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  BEGIN_UNDO_SET(tr("Grab Tissue"));

  // A scan that was only just opened is taken as it is, without Apply.
  scan->getSourceProxy()->UpdatePipeline();
  applied(scan->getProxy());
  if (!isImage(port))
  {
    qCritical("Grab Tissue needs an image with scalars. Select a scan in the Pipeline Browser.");
    END_UNDO_SET();
    return;
  }
  if (port->getDataInformation()->GetPointDataInformation()->GetNumberOfArrays() == 0)
  {
    // The window shows its messages for critical ones alone.
    qCritical("This image has no point data, but tissue is made from point data. If it has cell data, choose Filters > "
              "Alphabetical > Cell Data to Point Data, then Grab Tissue. Or open the file with a reader that gives "
              "points: for TIFF, the TIFF Series Reader.");
    END_UNDO_SET();
    return;
  }
  const bool isFirst = view->getNumberOfVisibleDataRepresentations() == 0;
  vtkSMProxy* look = lookOf(port);
  if (isFirst)
  {
    controller->Show(scan->getSourceProxy(), port->getPortNumber(), viewProxy);
    view->resetCamera();
  }
  vtkSMSessionProxyManager* manager = scan->getServer()->proxyManager();
  vtkChainMail::ViewRay sight(manager);
  if (!look && view->getNumberOfVisibleDataRepresentations() == 1)
  {
    LookFromTheFront(view, sight);
    sight = vtkChainMail::ViewRay(manager);
  }
  if (!sight.FindSpot())
  {
    qCritical(
      "There is no tissue in this scan: all its voxels are air. Check that the active scalars are those of the scan.");
    END_UNDO_SET();
    return;
  }
  if (sight.HasTurned())
  {
    const vtkChainMail::Place toward = sight.ToWorld({ { 0, 0, 1 } });
    const vtkChainMail::Place up = sight.ToWorld({ { 0, 1, 0 } });
    view->resetViewDirection(-toward[0], -toward[1], -toward[2], up[0], up[1], up[2]);
    sight = vtkChainMail::ViewRay(manager); // as the probe will find the view, to the last digit
    sight.FindSpot();
  }

  const auto probe = create(manager, "sources", "ChainMailProbe");
  controller->InitializeProxy(probe);
  controller->RegisterPipelineProxy(probe);
  applied(probe);

  const auto deformation = deform(port, probe);
  FitPull(probe, deformation, sight);
  show(deformation, port, look, "CT skin");
  active.setActiveSource(applied(probe));
  END_UNDO_SET();
  view->render();
}

//------------------------------------------------------------------------------
void pqChainMailActions::addTo(const char* input, const char* name, double opacity)
{
  pqActiveObjects& active = pqActiveObjects::instance();
  pqPipelineSource* selected = active.activeSource();
  vtkSMProxy* deformation = selected ? vtkChainMail::DeformationOf(selected->getProxy()) : nullptr;
  if (deformation == nullptr)
  {
    return;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  BEGIN_UNDO_SET(tr("Add to Tissue"));
  // Before the source is there, which is to be away from the others.
  vtkChainMail::ViewRay sight(deformation->GetSessionProxyManager());
  const bool isProbe = std::strcmp(input, "Probes") == 0;
  if (isProbe)
  {
    sight.Avoid("Probes");
    sight.Avoid("Carves");
    sight.FindSpot();
  }
  const auto source = create(deformation->GetSessionProxyManager(), "sources", name);
  controller->InitializeProxy(source);
  controller->RegisterPipelineProxy(source);
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", deformation);
    vtkSMPropertyHelper(deformation, input).Add(source, 0);
    deformation->UpdateVTKObjects();
  }
  if (isProbe)
  {
    FitPull(source, deformation, sight);
  }
  pqView* view = active.activeView();
  if (opacity > 0.0 && view)
  {
    vtkSMProxy* shown = controller->Show(source, 0, view->getViewProxy());
    if (shown)
    {
      vtkSMPropertyHelper(shown, "Opacity", true).Set(opacity);
      shown->UpdateVTKObjects();
    }
  }
  active.setActiveSource(applied(source));
  END_UNDO_SET();
  pqApplicationCore::instance()->render();
}

//------------------------------------------------------------------------------
void pqChainMailActions::remove()
{
  const QSet<pqProxy*> tools = SelectedTools();
  vtkSMProxy* deformation = nullptr;
  BEGIN_UNDO_SET(tr("Remove from Tissue"));
  for (pqProxy* tool : tools)
  {
    for (vtkSMProperty* input : UsesOf(tool->getProxy()))
    {
      deformation = input->GetParent();
      SM_SCOPED_TRACE(PropertiesModified).arg("proxy", deformation);
      vtkSMPropertyHelper(input).Remove(tool->getProxy());
      deformation->UpdateVTKObjects();
    }
  }
  if (deformation)
  {
    auto* model = pqApplicationCore::instance()->getServerManagerModel();
    pqActiveObjects::instance().setActiveSource(model->findItem<pqPipelineSource*>(deformation));
  }
  pqDeleteReaction::deleteSources(tools); // but not what is in use elsewhere
  END_UNDO_SET();
}

//------------------------------------------------------------------------------
void pqChainMailActions::openExample()
{
  pqServer* server = pqActiveObjects::instance().activeServer();
  if (server == nullptr)
  {
    return;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  BEGIN_UNDO_SET(tr("Open Example"));
  const auto forearm = create(server->proxyManager(), "sources", "ChainMailForearm");
  controller->InitializeProxy(forearm);
  controller->RegisterPipelineProxy(forearm);
  pqActiveObjects::instance().setActiveSource(applied(forearm));
  this->grab();
  END_UNDO_SET();
}
