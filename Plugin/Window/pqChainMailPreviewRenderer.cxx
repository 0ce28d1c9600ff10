// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPreviewRenderer.h"

#include "vtkImageData.h"
#include "vtkImageVolumeRepresentation.h"
#include "vtkMultiBlockVolumeMapper.h"
#include "vtkPVRenderView.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMViewProxy.h"

#include <cstring>

namespace
{
/// Leads to the mapper, which ParaView shows to derived classes alone.
struct Volume : public vtkImageVolumeRepresentation
{
  static vtkSmartPointer<vtkVolumeMapper>& MapperOf(vtkImageVolumeRepresentation* representation)
  {
    return representation->*(&Volume::VolumeMapper);
  }
};

int NumberOf(vtkSMProxy* proxy, const char* property)
{
  return vtkSMPropertyHelper(proxy, property, true).GetAsInt();
}

/// The volume that a view shows, where the quick mapper draws it as ParaView's does.
vtkImageVolumeRepresentation* VolumeOf(vtkSMProxy* source, vtkSMViewProxy* view)
{
  vtkSMProxy* shown = view->FindRepresentation(vtkSMSourceProxy::SafeDownCast(source), 0);
  const char* kind = shown ? vtkSMPropertyHelper(shown, "Representation", true).GetAsString() : nullptr;
  vtkSMProperty* blend = kind && std::strcmp(kind, "Volume") == 0 ? shown->GetProperty("BlendMode") : nullptr;
  // 0 to 2 are vtkSmartVolumeMapper's own ways to draw. Where a server has the data, it draws them.
  if (blend == nullptr || source->GetClientSideObject() == nullptr || NumberOf(shown, "Visibility") == 0 ||
      NumberOf(shown, "VolumeRenderingMode") > 2 || NumberOf(shown, "UseTransfer2D") != 0 ||
      NumberOf(shown, "UseSeparateOpacityArray") != 0 || NumberOf(view, "EnableRayTracing") != 0)
  {
    return nullptr;
  }
  return vtkImageVolumeRepresentation::SafeDownCast(blend->GetParent()->GetClientSideObject());
}
}

//------------------------------------------------------------------------------
bool pqChainMailPreviewRenderer::open(vtkSMProxy* source, vtkSMViewProxy* view)
{
  this->close();
  vtkImageVolumeRepresentation* volume = VolumeOf(source, view);
  auto* paraviews = volume ? vtkMultiBlockVolumeMapper::SafeDownCast(Volume::MapperOf(volume)) : nullptr;
  if (paraviews == nullptr)
  {
    return false;
  }
  this->View = view;
  this->Representation = volume;
  this->Kept = paraviews;
  // What the representation does not tell its mapper before each frame.
  vtkSMProxy* shown = view->FindRepresentation(vtkSMSourceProxy::SafeDownCast(source), 0);
  this->Mapper = vtkSmartPointer<vtkChainMailQuickMapper>::New();
  this->Mapper->SetStep(this->Step);
  this->Mapper->SetRequestedRenderMode(NumberOf(shown, "VolumeRenderingMode"));
  this->Mapper->SetBlendMode(paraviews->GetBlendMode());
  this->Mapper->SetCropping(paraviews->GetCropping());
  this->Mapper->SetCroppingRegionFlags(paraviews->GetCroppingRegionFlags());
  this->Mapper->SetClippingPlanes(paraviews->GetClippingPlanes());
  this->Mapper->SetGlobalIlluminationReach(paraviews->GetGlobalIlluminationReach());
  this->Mapper->SetVolumetricScatteringBlending(paraviews->GetVolumetricScatteringBlending());
  this->Mapper->SetComputeNormalFromOpacity(paraviews->GetComputeNormalFromOpacity());
  Volume::MapperOf(volume) = this->Mapper;
  this->setSmoothing(false);
  return true;
}

//------------------------------------------------------------------------------
void pqChainMailPreviewRenderer::close()
{
  if (this->Representation)
  {
    Volume::MapperOf(this->Representation) = this->Kept;
    this->setSmoothing(true);
    this->Representation = nullptr;
    this->Kept = nullptr;
    this->Step = this->Mapper->GetStep();
    this->Mapper = nullptr;
  }
}

//------------------------------------------------------------------------------
void pqChainMailPreviewRenderer::setSmoothing(bool smooth)
{
  // A pass over all pixels, for edges that a volume does not have. Where a processor draws it takes as long as the
  // volume.
  if (auto* client = this->View ? vtkPVRenderView::SafeDownCast(this->View->GetClientSideObject()) : nullptr)
  {
    client->SetUseFXAA(smooth && NumberOf(this->View, "UseFXAA") != 0);
  }
}

//------------------------------------------------------------------------------
void pqChainMailPreviewRenderer::draw(vtkImageData* image, bool fine)
{
  this->Mapper->SetImage(image);
  this->redraw(fine);
}

void pqChainMailPreviewRenderer::redraw(bool fine)
{
  if (this->View)
  {
    this->Mapper->SetFine(fine);
    this->View->InteractiveRender();
  }
}
