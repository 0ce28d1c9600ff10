// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailLook.h"

#include "ChainMailPresets.h"
#include "ViewRay.h"
#include "pqChainMailPipeline.h"

#include "pqActiveObjects.h"
#include "pqOutputPort.h"
#include "pqUndoStack.h"
#include "pqView.h"

#include "vtkChainMailDeformation.h"
#include "vtkChainMailScanStatistics.h"
#include "vtkDataObject.h"
#include "vtkNew.h"
#include "vtkPVChainMailScanInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkPiecewiseFunction.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTransferFunctionManager.h"
#include "vtkSMTransferFunctionPresets.h"
#include "vtkSMTransferFunctionProxy.h"
#include "vtkSMViewProxy.h"

#include <QAction>
#include <QMenu>

#include <string>
#include <vector>

namespace
{

const char* const OfAnyScale = "MR T1";

bool IsThere(const std::string& preset)
{
  auto* presets = vtkSMTransferFunctionPresets::GetInstance();
  bool isThere = false;
  for (unsigned int n = 0; n < presets->GetNumberOfPresets(); ++n)
  {
    isThere = isThere || presets->GetPresetName(n) == preset;
  }
  return isThere;
}

/// The array that colours a representation; empty where none does.
std::string ColouringArray(vtkSMProxy* representation)
{
  vtkSMPropertyHelper coloured(representation, "ColorArrayName", true);
  const char* name = coloured.GetNumberOfElements() == 5 ? coloured.GetAsString(4) : nullptr;
  return name ? name : "";
}

vtkSMProxy* FunctionOf(vtkSMProxy* representation, const char* name)
{
  vtkSMPropertyHelper function(representation, name, true);
  return function.GetNumberOfElements() > 0 ? function.GetAsProxy() : nullptr;
}

/// Opaque but for 0, which is air.
void ShowLabels(vtkSMProxy* opacity)
{
  double range[2];
  if (vtkSMTransferFunctionProxy::GetRange(opacity, range) && range[1] > 1.0)
  {
    const std::vector<double> points = { 0.0, 0.0, 0.5, 0.0, 0.5, 0.0, 0.5, 0.0, 1.0, 0.8, 0.5, 0.0, range[1], 0.8, 0.5,
      0.0 }; // value, opacity, and two of the curve's shape
    vtkSMPropertyHelper(opacity, "Points").Set(points.data(), static_cast<unsigned int>(points.size()));
    opacity->UpdateVTKObjects();
  }
}

/// What is selected, if it is an image and there is a view to show it in; else null.
pqOutputPort* SelectedImage()
{
  pqOutputPort* port = pqActiveObjects::instance().activePort();
  return pqActiveObjects::instance().activeView() && pqChainMailPipeline::isImage(port) ? port : nullptr;
}

/// Shows what is selected as a volume with the look of a preset.
void Choose(const std::string& preset)
{
  pqOutputPort* port = SelectedImage();
  if (port == nullptr)
  {
    return;
  }
  BEGIN_UNDO_SET(QObject::tr("Choose Look"));
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  pqView* view = pqActiveObjects::instance().activeView();
  vtkSMProxy* shown = controller->Show(port->getSourceProxy(), port->getPortNumber(), view->getViewProxy());
  if (shown)
  {
    vtkSMRepresentationProxy::SetRepresentationType(shown, "Volume");
    pqChainMailLook::Give(shown, port, preset);
  }
  END_UNDO_SET();
  view->render();
}

}

//------------------------------------------------------------------------------
void pqChainMailLook::Give(vtkSMProxy* representation, pqOutputPort* image, const std::string& preset)
{
  const std::string scalars = vtkChainMail::Unsmoothed(ColouringArray(representation));
  if (scalars.empty() || !IsThere(preset) || !IsThere(OfAnyScale))
  {
    return;
  }
  vtkNew<vtkPVChainMailScanInformation> asked;
  asked->Gather(image->getSourceProxy(), image->getPortNumber(), scalars);
  vtkChainMailScanStatistics* statistics = asked->GetStatistics();
  const int kind = statistics->GetKind();
  vtkSMProxy* colours = FunctionOf(representation, "LookupTable");
  vtkSMProxy* opacity = FunctionOf(representation, "ScalarOpacityFunction");
  if (kind == vtkChainMailScanStatistics::KIND_LABELS)
  {
    ShowLabels(opacity);
  }
  else
  {
    const bool inUnits = kind == vtkChainMailScanStatistics::KIND_CT && ChainMailPresetIsInHounsfieldUnits(preset);
    double threshold = 0.0;
    vtkNew<vtkPiecewiseFunction> material; // its last point is at the brightest voxels
    statistics->GetMaterial(vtkChainMailDeformation::MATERIAL_MR, threshold, material);
    const double air = statistics->GetBackgroundValue();
    const double* range = material->GetRange();
    const char* name = inUnits || !ChainMailPresetIsInHounsfieldUnits(preset) ? preset.c_str() : OfAnyScale;
    for (vtkSMProxy* function : { colours, opacity })
    {
      if (function)
      {
        vtkSMTransferFunctionProxy::ApplyPreset(function, name, false);
        if (!inUnits && range[1] > air)
        {
          vtkSMTransferFunctionProxy::RescaleTransferFunction(function, air, range[1]);
        }
      }
    }
    if (colours && !inUnits)
    {
      // ParaView would stretch it over what few voxels reach.
      vtkSMPropertyHelper(colours, "AutomaticRescaleRangeMode", true).Set(vtkSMTransferFunctionManager::NEVER);
      colours->UpdateVTKObjects();
    }
  }
  vtkSMPropertyHelper(representation, "Shade", true).Set(1);
  representation->UpdateVTKObjects();
}

//------------------------------------------------------------------------------
void pqChainMailLook::ColourBySmoothed(vtkSMProxy* representation, vtkSMSourceProxy* deformation)
{
  const std::string scalars = ColouringArray(representation);
  const std::string smoothed = vtkChainMail::Smoothed(scalars);
  const char* kind = vtkSMPropertyHelper(representation, "Representation", true).GetAsString();
  vtkPVDataSetAttributesInformation* arrays = deformation->GetDataInformation(0)->GetPointDataInformation();
  if (scalars.empty() || kind == nullptr || std::string(kind) != "Volume" ||
      arrays->GetArrayInformation(smoothed.c_str()) == nullptr)
  {
    return;
  }
  // Functions of its own, which ParaView finds again when somebody chooses another array and comes back.
  vtkNew<vtkSMTransferFunctionManager> functions;
  vtkSMSessionProxyManager* manager = representation->GetSessionProxyManager();
  vtkSMProxy* colours = functions->GetColorTransferFunction(smoothed.c_str(), manager);
  vtkSMProxy* opacity = functions->GetOpacityTransferFunction(smoothed.c_str(), manager);
  const auto take = [&](const char* name, vtkSMProxy* own)
  {
    vtkSMProxy* given = FunctionOf(representation, name);
    if (given && given != own)
    {
      own->Copy(given, "vtkSMProxyProperty");
      own->UpdateVTKObjects();
    }
    vtkSMPropertyHelper(representation, name).Set(own);
  };
  take("LookupTable", colours);
  take("ScalarOpacityFunction", opacity);
  vtkSMPropertyHelper(representation, "ColorArrayName")
    .SetInputArrayToProcess(vtkDataObject::FIELD_ASSOCIATION_POINTS, smoothed.c_str());
  representation->UpdateVTKObjects();
}

//------------------------------------------------------------------------------
QMenu* pqChainMailLook::MakeMenu()
{
  auto* menu = new QMenu(QObject::tr("Look"));
  menu->setObjectName("menuLook");
  for (const std::string& preset : ChainMailPresetNames())
  {
    QAction* action = menu->addAction(QString::fromStdString(preset), [preset] { Choose(preset); });
    action->setStatusTip(
      QObject::tr("Show the selected image as a volume, in the colours and opacities of this preset."));
  }
  QObject::connect(menu, &QMenu::aboutToShow, menu,
    [menu]
    {
      pqOutputPort* port = SelectedImage();
      bool isCT = false;
      if (port)
      {
        vtkNew<vtkPVChainMailScanInformation> asked;
        asked->Gather(port->getSourceProxy(), port->getPortNumber(), "");
        isCT = asked->GetStatistics()->GetKind() == vtkChainMailScanStatistics::KIND_CT;
      }
      for (QAction* action : menu->actions())
      {
        action->setEnabled(port && (isCT || !ChainMailPresetIsInHounsfieldUnits(action->text().toStdString())));
      }
    });
  return menu;
}
