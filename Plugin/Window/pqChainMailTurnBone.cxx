// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailTurnBone.h"

#include "Bones.h"
#include "pqChainMailPipeline.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqOutputPort.h"
#include "pqPipelineSource.h"
#include "pqRenderView.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqUndoStack.h"

#include "vtkChainMailScanStatistics.h"
#include "vtkNew.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVChainMailScanInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTrace.h"
#include "vtkSMViewProxy.h"

#include <QCoreApplication>
#include <QList>

#include <algorithm>
#include <cmath>
#include <string>

using namespace pqChainMailPipeline;

namespace
{
/// The last array of an image that is taken for labels; empty where there is none.
std::string LabelsOf(pqOutputPort* port)
{
  vtkPVDataSetAttributesInformation* arrays = port->getDataInformation()->GetPointDataInformation();
  for (int n = arrays->GetNumberOfArrays() - 1; n >= 0; --n)
  {
    const char* name = arrays->GetArrayInformation(n)->GetName();
    vtkNew<vtkPVChainMailScanInformation> asked;
    asked->Gather(port->getSourceProxy(), port->getPortNumber(), name ? name : "");
    if (name && asked->GetStatistics()->GetKind() == vtkChainMailScanStatistics::KIND_LABELS)
    {
      return name;
    }
  }
  return {};
}

bool HasOnlyLabels(pqOutputPort* port)
{
  return port->getDataInformation()->GetPointDataInformation()->GetNumberOfArrays() == 1 && !LabelsOf(port).empty();
}

bool HaveOneGrid(pqOutputPort* one, pqOutputPort* other)
{
  vtkPVDataInformation* a = one->getDataInformation();
  vtkPVDataInformation* b = other->getDataInformation();
  const double tolerance = 1e-6 * (1.0 + a->GetBounds()[1] - a->GetBounds()[0]);
  return std::equal(a->GetExtent(), a->GetExtent() + 6, b->GetExtent()) &&
         std::equal(a->GetBounds(), a->GetBounds() + 6, b->GetBounds(),
           [tolerance](double x, double y) { return std::abs(x - y) <= tolerance; });
}

/// Brings a source that was only just opened up to date.
pqOutputPort* Updated(pqOutputPort* port)
{
  port->getSource()->getSourceProxy()->UpdatePipeline();
  applied(port->getSource()->getProxy());
  return port;
}

/// Of an image and another one on its grid that is there, the scan and its labels, the latter null where none are.
struct ScanAndLabels
{
  pqOutputPort* Scan = nullptr;
  pqOutputPort* Labels = nullptr;
};

ScanAndLabels FindScanAndLabels(pqOutputPort* image)
{
  const bool isLabels = HasOnlyLabels(image);
  if (!isLabels && !LabelsOf(image).empty())
  {
    return { image, nullptr }; // it has both
  }
  auto* model = pqApplicationCore::instance()->getServerManagerModel();
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>(image->getServer()))
  {
    pqOutputPort* port = source->getOutputPort(0);
    if (source == image->getSource() || source->getNumberOfOutputPorts() != 1 ||
        vtkChainMail::DeformationOf(source->getProxy()) == source->getProxy())
    {
      continue;
    }
    if (isImage(Updated(port)) && HaveOneGrid(image, port) && HasOnlyLabels(port) != isLabels)
    {
      return isLabels ? ScanAndLabels{ port, image } : ScanAndLabels{ image, port };
    }
  }
  return { image, nullptr };
}

/// A deformation of the image that is selected in which bones turn, each by itself where there are labels.
vtkSMSourceProxy* DeformSelected(pqRenderView* view)
{
  pqOutputPort* selected = pqActiveObjects::instance().activePort();
  if (!isImage(Updated(selected)))
  {
    qCritical("Turn Bone needs an image with scalars. Select a scan in the Pipeline Browser.");
    return nullptr;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  const ScanAndLabels found = FindScanAndLabels(selected);
  const bool isFirst = view->getNumberOfVisibleDataRepresentations() == 0;
  vtkSMProxy* look = lookOf(found.Scan);
  pqOutputPort* input = found.Scan;
  if (found.Labels)
  {
    const auto both = create(selected->getServer()->proxyManager(), "filters", "AppendAttributes");
    controller->PreInitializeProxy(both);
    for (pqOutputPort* port : { found.Scan, found.Labels })
    {
      vtkSMPropertyHelper(both, "Input")
        .Add(port->getSource()->getProxy(), static_cast<unsigned int>(port->getPortNumber()));
      controller->Hide(port->getSourceProxy(), port->getPortNumber(), view->getViewProxy());
    }
    controller->PostInitializeProxy(both);
    controller->RegisterPipelineProxy(both);
    input = Updated(applied(both)->getOutputPort(0));
  }
  const auto deformation = deform(input, nullptr);
  const std::string labels = LabelsOf(input);
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", deformation.Get());
    vtkSMPropertyHelper(deformation, "Rotations").Set(1);
    if (!labels.empty())
    {
      vtkSMPropertyHelper(deformation, "BodyArray").Set(labels.c_str());
      vtkSMPropertyHelper(deformation, "JointConstraint").Set(1.0);
    }
    deformation->UpdateVTKObjects();
  }
  show(deformation, input, look, "CT skin, muscle and bone");
  if (isFirst)
  {
    view->resetCamera();
    view->resetViewDirection(0, 1, 0, 0, 0, 1); // a patient from the front, where bones are beside each other
  }
  return deformation;
}

/// Finds the bone in the middle of the view. Rotations stay on where only that lets the deformation update.
bool FindBoneInView(vtkSMSourceProxy* deformation, vtkChainMail::Bone& bone)
{
  const vtkChainMail::ViewRay sight(deformation->GetSessionProxyManager(), deformation);
  deformation->UpdatePipeline();
  if (!sight.IsValid())
  {
    return false;
  }
  if (vtkChainMail::FindBone(deformation, sight.GetRays(), bone))
  {
    return true;
  }
  vtkSMPropertyHelper rotations(deformation, "Rotations");
  if (rotations.GetAsInt() != 0)
  {
    return false;
  }
  rotations.Set(1); // there may be a pose already
  deformation->UpdateVTKObjects();
  deformation->UpdatePipeline();
  const bool isFound = vtkChainMail::FindBone(deformation, sight.GetRays(), bone);
  if (!isFound)
  {
    rotations.Set(0);
    deformation->UpdateVTKObjects();
  }
  return isFound;
}

void TurnBone(pqRenderView* view, pqPipelineSource* selected)
{
  auto* deformation = vtkSMSourceProxy::SafeDownCast(vtkChainMail::DeformationOf(selected->getProxy()));
  deformation = deformation ? deformation : DeformSelected(view);
  if (deformation == nullptr)
  {
    return;
  }
  vtkChainMail::Bone bone;
  if (!FindBoneInView(deformation, bone))
  {
    qCritical("There is no bone in the middle of the view. Turn the view towards a bone: rigid tissue (constraint 0) "
              "that has a label, if BodyArray is set. If the filter reports an error, correct that first.");
    return;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  const auto pose = create(deformation->GetSessionProxyManager(), "sources", "ChainMailPose");
  controller->InitializeProxy(pose);
  controller->RegisterPipelineProxy(pose);
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", static_cast<vtkSMProxy*>(pose));
    vtkSMPropertyHelper(pose, "Position").Set(bone.Middle.data(), 3);
    vtkSMPropertyHelper(pose, "Target").Set(bone.Middle.data(), 3);
    vtkSMPropertyHelper(pose, "Body").Set(bone.Body);
    pose->UpdateVTKObjects();
  }
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", static_cast<vtkSMProxy*>(deformation));
    vtkSMPropertyHelper(deformation, "Rotations").Set(1);
    vtkSMPropertyHelper(deformation, "Probes").Add(pose, 0);
    deformation->UpdateVTKObjects();
  }
  pqActiveObjects::instance().setActiveSource(applied(pose));
}
}

//------------------------------------------------------------------------------
void pqChainMailTurnBone()
{
  pqActiveObjects& active = pqActiveObjects::instance();
  auto* view = qobject_cast<pqRenderView*>(active.activeView());
  pqPipelineSource* selected = active.activeSource();
  if (view == nullptr || selected == nullptr)
  {
    return;
  }
  BEGIN_UNDO_SET(QCoreApplication::translate("pqChainMailActions", "Turn Bone"));
  TurnBone(view, selected);
  END_UNDO_SET();
  pqApplicationCore::instance()->render();
}
