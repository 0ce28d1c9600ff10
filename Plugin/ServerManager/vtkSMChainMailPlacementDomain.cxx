// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailPlacementDomain.h"

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
  element->GetVectorAttribute("at", 3, this->At);
  return this->Superclass::ReadXMLAttributes(property, element);
}

//------------------------------------------------------------------------------
int vtkSMChainMailPlacementDomain::SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values)
{
  double bounds[6];
  vtkMath::UninitializeBounds(bounds);
  if (vtkPVDataInformation* data = ActiveData(property))
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
  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(use_unchecked_values);
  helper.Set(place, 3);
  return 1;
}
