// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailRangeDomain.h"

#include "vtkChainMailDeformation.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVXMLElement.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <cstring>
#include <vector>

vtkStandardNewMacro(vtkSMChainMailRangeDomain);

//------------------------------------------------------------------------------
bool vtkSMChainMailRangeDomain::FindRange(vtkSMDomain* domain, double range[2])
{
  vtkSMProperty* selection = domain->GetRequiredProperty("ArraySelection");
  vtkPVDataInformation* data = domain->GetInputDataInformation("Input");
  if (selection == nullptr || data == nullptr)
  {
    return false;
  }
  // As for SetInputArrayToProcess: index, port, connection, association, name.
  vtkSMUncheckedPropertyHelper helper(selection);
  const char* name = helper.GetNumberOfElements() == 5 ? helper.GetAsString(4) : nullptr;
  vtkPVArrayInformation* array = name && *name ? data->GetArrayInformation(name, helper.GetAsInt(3)) : nullptr;
  if (array == nullptr)
  {
    return false;
  }
  const double* finite = array->GetComponentFiniteRange(0);
  if (finite[0] > finite[1])
  {
    return false;
  }
  range[0] = finite[0];
  range[1] = finite[1];
  return true;
}

//------------------------------------------------------------------------------
void vtkSMChainMailRangeDomain::EnsureData(vtkSMDomain* domain)
{
  vtkPVDataInformation* data = domain->GetInputDataInformation("Input");
  if (data && data->GetNumberOfPoints() == 0)
  {
    vtkSMUncheckedPropertyHelper input(domain->GetRequiredProperty("Input"));
    vtkSMSourceProxy::SafeDownCast(input.GetAsProxy())->UpdatePipeline();
  }
}

//------------------------------------------------------------------------------
int vtkSMChainMailRangeDomain::ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element)
{
  const char* fit = element->GetAttribute("fit");
  this->FitsTissueThreshold = fit && std::strcmp(fit, "tissue") == 0;
  return this->Superclass::ReadXMLAttributes(property, element);
}

//------------------------------------------------------------------------------
void vtkSMChainMailRangeDomain::Update(vtkSMProperty*)
{
  double range[2];
  std::vector<vtkEntry> entries;
  if (vtkSMChainMailRangeDomain::FindRange(this, range))
  {
    entries.emplace_back(range[0], range[1]);
  }
  this->SetEntries(entries);
}

//------------------------------------------------------------------------------
int vtkSMChainMailRangeDomain::SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values)
{
  vtkSMChainMailRangeDomain::EnsureData(this);
  if (!this->FitsTissueThreshold || this->GetNumberOfEntries() == 0)
  {
    return this->Superclass::SetDefaultValues(property, use_unchecked_values);
  }
  const double range[2] = { this->GetMinimum(0), this->GetMaximum(0) };
  double threshold = 0.0;
  vtkChainMailDeformation::FitMaterial(range, threshold, nullptr);

  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(use_unchecked_values);
  helper.Set(threshold);
  return 1;
}
