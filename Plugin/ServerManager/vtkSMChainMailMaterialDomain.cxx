// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMChainMailMaterialDomain.h"

#include "vtkChainMailDeformation.h"
#include "vtkChainMailScanStatistics.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVChainMailScanInformation.h"
#include "vtkPiecewiseFunction.h"
#include "vtkSMChainMailRangeDomain.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <vector>

vtkStandardNewMacro(vtkSMChainMailMaterialDomain);

//------------------------------------------------------------------------------
int vtkSMChainMailMaterialDomain::ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element)
{
  this->AddProxy("piecewise_functions", "PiecewiseFunction");
  return this->Superclass::ReadXMLAttributes(property, element);
}

//------------------------------------------------------------------------------
void vtkSMChainMailMaterialDomain::Update(vtkSMProperty*)
{
  double range[2] = { 1.0, 0.0 };
  vtkSMChainMailRangeDomain::FindRange(this, range);
  if (range[0] != this->Range[0] || range[1] != this->Range[1])
  {
    this->Range[0] = range[0];
    this->Range[1] = range[1];
    this->DomainModified();
  }
}

//------------------------------------------------------------------------------
int vtkSMChainMailMaterialDomain::SetDefaultValues(vtkSMProperty* property, bool use_unchecked_values)
{
  vtkSMChainMailRangeDomain::EnsureData(this);

  // First the superclass: it connects the property with this domain's function, whose points are then replaced.
  const int done = this->Superclass::SetDefaultValues(property, use_unchecked_values);
  vtkSMProxy* proxy = this->GetNumberOfProxies() > 0 ? this->GetProxy(0) : nullptr;
  vtkNew<vtkPVChainMailScanInformation> asked;
  if (proxy == nullptr)
  {
    return done;
  }
  double threshold = 0.0;
  vtkNew<vtkPiecewiseFunction> function;
  if (vtkSMChainMailRangeDomain::FindStatistics(this, asked))
  {
    asked->GetStatistics()->GetMaterial(vtkChainMailDeformation::MATERIAL_FUNCTION, threshold, function);
  }
  else
  {
    // Without scalars to fit it to. ParaView's function goes up to 1, which is no constraint: the filter would complain
    // of the material instead of the image.
    function->AddPoint(0.0, 0.25);
  }

  // A point is x, y, midpoint, sharpness.
  std::vector<double> points(4 * static_cast<std::size_t>(function->GetSize()));
  for (int i = 0; i < function->GetSize(); ++i)
  {
    function->GetNodeValue(i, points.data() + 4 * i);
  }
  vtkSMPropertyHelper(proxy, "Points").Set(points.data(), static_cast<unsigned int>(points.size()));
  proxy->UpdateVTKObjects();
  return 1;
}
