// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailPlacementDomain.h"

#include "ViewRay.h"

#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPVDataInformation.h"
#include "vtkPVXMLElement.h"
#include "vtkSMOutputPort.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxySelectionModel.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"

#include <vtksys/SystemTools.hxx>

vtkStandardNewMacro(vtkSMChainMailPlacementDomain);

namespace
{
/// The data of the source that is selected in the pipeline browser (or was last made, in a script). Only what is
/// already there: nothing is computed for a default.
vtkPVDataInformation* ActiveData(vtkSMProperty* property)
{
  vtkSMProxy* parent = property->GetParent();
  vtkSMSessionProxyManager* manager = parent ? parent->GetSessionProxyManager() : nullptr;
  vtkSMProxySelectionModel* active = manager ? manager->GetSelectionModel("ActiveSources") : nullptr;
  vtkSMProxy* current = active ? active->GetCurrentProxy() : nullptr;
  if (auto* port = vtkSMOutputPort::SafeDownCast(current))
  {
    return port->GetDataInformation();
  }
  auto* source = vtkSMSourceProxy::SafeDownCast(current);
  return source && source->GetOutputPortsCreated() ? source->GetDataInformation() : nullptr;
}
}

//------------------------------------------------------------------------------
int vtkSMChainMailPlacementDomain::ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element)
{
  if (element->GetVectorAttribute("vector", 3, this->Shares))
  {
    this->Kind = VECTOR;
  }
  else if (element->GetScalarAttribute("size", &this->Size))
  {
    this->Kind = SIZE;
  }
  else
  {
    element->GetVectorAttribute("offset", 3, this->Shares);
  }
  if (const char* avoided = element->GetAttribute("avoid"))
  {
    vtksys::SystemTools::Split(avoided, this->Avoided, ' ');
  }
  int onTissue = 0;
  element->GetScalarAttribute("on_tissue", &onTissue);
  this->OnTissue = onTissue != 0;
  this->NeedsView = element->GetAttribute("at") != nullptr;
  this->HasAt = element->GetVectorAttribute("at", 3, this->At) == 3;
  return this->Superclass::ReadXMLAttributes(property, element);
}

//------------------------------------------------------------------------------
int vtkSMChainMailPlacementDomain::SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values)
{
  vtkSMProxy* parent = property->GetParent();
  vtkChainMail::ViewRay sight(parent ? parent->GetSessionProxyManager() : nullptr);
  for (const std::string& input : this->Avoided)
  {
    sight.Avoid(input);
  }
  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(use_unchecked_values);
  if ((sight.HasView() || !this->NeedsView) && sight.FindSpot())
  {
    const vtkChainMail::Place shares{ { this->Shares[0], this->Shares[1], this->Shares[2] } };
    switch (this->Kind)
    {
    case PLACE:
      helper.Set(sight.GetPlace(shares, this->OnTissue).data(), 3);
      break;
    case VECTOR:
      helper.Set(sight.ToWorld(shares).data(), 3);
      break;
    case SIZE:
      helper.Set(this->Size * sight.GetDiagonal());
      break;
    }
    return 1;
  }

  double bounds[6];
  vtkMath::UninitializeBounds(bounds);
  vtkPVDataInformation* data = this->HasAt ? ActiveData(property) : nullptr;
  if (data)
  {
    data->GetBounds(bounds);
  }
  if (!vtkMath::AreBoundsInitialized(bounds))
  {
    return this->Superclass::SetDefaultValues(property, use_unchecked_values);
  }
  double place[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    place[axis] = (1.0 - this->At[axis]) * bounds[2 * axis] + this->At[axis] * bounds[2 * axis + 1];
  }
  helper.Set(place, 3);
  return 1;
}
