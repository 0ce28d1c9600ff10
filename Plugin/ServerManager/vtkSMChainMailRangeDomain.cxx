// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailRangeDomain.h"

#include "vtkChainMailDeformation.h"
#include "vtkChainMailScanStatistics.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVChainMailScanInformation.h"
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
bool vtkSMChainMailRangeDomain::FindStatistics(vtkSMDomain* domain, vtkPVChainMailScanInformation* answer)
{
  double range[2];
  if (!vtkSMChainMailRangeDomain::FindRange(domain, range))
  {
    return false;
  }
  vtkSMUncheckedPropertyHelper input(domain->GetRequiredProperty("Input"));
  vtkSMUncheckedPropertyHelper selection(domain->GetRequiredProperty("ArraySelection"));
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy());
  if (source == nullptr || selection.GetAsInt(3) != vtkDataObject::POINT)
  {
    return false;
  }
  answer->Gather(source, static_cast<int>(input.GetOutputPort()), selection.GetAsString(4));
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
  this->Fit = fit && std::strcmp(fit, "tissue") == 0 ? TISSUE : fit && std::strcmp(fit, "air") == 0 ? AIR : NOTHING;
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
  vtkNew<vtkPVChainMailScanInformation> asked;
  if (this->Fit == NOTHING || this->GetNumberOfEntries() == 0 ||
      !vtkSMChainMailRangeDomain::FindStatistics(this, asked))
  {
    return this->Superclass::SetDefaultValues(property, use_unchecked_values);
  }
  double fitting = asked->GetStatistics()->GetBackgroundValue();
  if (this->Fit == TISSUE)
  {
    asked->GetStatistics()->GetMaterial(vtkChainMailDeformation::MATERIAL_FUNCTION, fitting, nullptr);
  }
  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(use_unchecked_values);
  helper.Set(fitting);
  return 1;
}
