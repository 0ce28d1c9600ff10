// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPipeline.h"

#include "pqChainMailLook.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqOutputPort.h"
#include "pqPipelineSource.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqView.h"

#include "vtkNew.h"
#include "vtkPVDataInformation.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxyClipboard.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMViewProxy.h"

#include <cstring>
#include <string>

namespace
{
// The standard deviation of ScalarSmoothing [voxels]; and up to how many voxels, as it takes 8 bytes for each.
constexpr double SkinWithoutGrain = 0.75;
constexpr double MostSmoothed = 150e6;

vtkSMViewProxy* activeView()
{
  pqView* view = pqActiveObjects::instance().activeView();
  return view ? view->getViewProxy() : nullptr;
}
}

namespace pqChainMailPipeline
{

vtkSmartPointer<vtkSMSourceProxy> create(vtkSMSessionProxyManager* manager, const char* group, const char* name)
{
  vtkSmartPointer<vtkSMProxy> proxy;
  proxy.TakeReference(manager->NewProxy(group, name));
  return vtkSMSourceProxy::SafeDownCast(proxy);
}

pqPipelineSource* applied(vtkSMProxy* proxy)
{
  auto* source = pqApplicationCore::instance()->getServerManagerModel()->findItem<pqPipelineSource*>(proxy);
  if (source)
  {
    source->setModifiedState(pqProxy::UNMODIFIED);
  }
  return source;
}

bool isImage(pqOutputPort* port)
{
  vtkPVDataInformation* data = port ? port->getDataInformation() : nullptr;
  return data && data->DataSetTypeIsA("vtkImageData") && data->GetNumberOfPoints() > 0;
}

//------------------------------------------------------------------------------
vtkSmartPointer<vtkSMSourceProxy> deform(pqOutputPort* scan, vtkSMProxy* probe)
{
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  auto deformation = create(scan->getServer()->proxyManager(), "filters", "ChainMailDeformation");
  controller->PreInitializeProxy(deformation);
  vtkSMPropertyHelper(deformation, "Input")
    .Set(scan->getSource()->getProxy(), static_cast<unsigned int>(scan->getPortNumber()));
  if (probe)
  {
    vtkSMPropertyHelper(deformation, "Probes").Set(probe, 0);
  }
  if (static_cast<double>(scan->getDataInformation()->GetNumberOfPoints()) <= MostSmoothed)
  {
    vtkSMPropertyHelper(deformation, "ScalarSmoothing").Set(SkinWithoutGrain);
  }
  controller->PostInitializeProxy(deformation);
  controller->RegisterPipelineProxy(deformation);
  applied(deformation);
  return deformation;
}

//------------------------------------------------------------------------------
vtkSMProxy* lookOf(pqOutputPort* scan)
{
  vtkSMViewProxy* view = activeView();
  vtkSMProxy* shown =
    view ? view->FindRepresentation(scan->getSourceProxy(), static_cast<unsigned int>(scan->getPortNumber())) : nullptr;
  const char* kind = shown ? vtkSMPropertyHelper(shown, "Representation", true).GetAsString() : nullptr;
  return kind && (std::strcmp(kind, "Volume") == 0 || std::strcmp(kind, "Slice") == 0) ? shown : nullptr;
}

//------------------------------------------------------------------------------
void show(vtkSMSourceProxy* deformation, pqOutputPort* scan, vtkSMProxy* look, const std::string& preset)
{
  vtkSMViewProxy* view = activeView();
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  vtkSMProxy* shown = controller->Show(deformation, 0, view);
  if (look && shown)
  {
    vtkNew<vtkSMProxyClipboard> clipboard;
    clipboard->Copy(look);
    clipboard->Paste(shown);
    shown->UpdateVTKObjects();
  }
  else if (shown)
  {
    pqChainMailLook::Give(shown, scan, preset);
  }
  if (shown)
  {
    pqChainMailLook::ColourBySmoothed(shown, deformation);
  }
  controller->Hide(scan->getSourceProxy(), scan->getPortNumber(), view);
}

}
