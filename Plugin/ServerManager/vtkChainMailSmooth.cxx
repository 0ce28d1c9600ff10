// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailSmooth.h"

#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkImageCast.h"
#include "vtkImageData.h"
#include "vtkImageGaussianSmooth.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cmath>

vtkStandardNewMacro(vtkChainMailSmooth);

namespace
{
constexpr double Reach = 3.0; // of the Gaussian, in standard deviations
}

//------------------------------------------------------------------------------
vtkChainMailSmooth::vtkChainMailSmooth() = default;

//------------------------------------------------------------------------------
void vtkChainMailSmooth::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "StandardDeviation: " << this->StandardDeviation << "\n";
}

//------------------------------------------------------------------------------
int vtkChainMailSmooth::GetRadius() const
{
  return static_cast<int>(std::ceil(Reach * this->StandardDeviation));
}

//------------------------------------------------------------------------------
int vtkChainMailSmooth::RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputs)
{
  vtkDataObject::SetPointDataActiveScalarInfo(outputs->GetInformationObject(0), VTK_FLOAT, -1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailSmooth::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs)
{
  int extent[6];
  int whole[6];
  vtkInformation* input = inputs[0]->GetInformationObject(0);
  outputs->GetInformationObject(0)->Get(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent);
  input->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
  if (extent[0] <= extent[1] && extent[2] <= extent[3] && extent[4] <= extent[5])
  {
    for (int a = 0; a < 3; ++a)
    {
      extent[2 * a] = std::max(extent[2 * a] - this->GetRadius(), whole[2 * a]);
      extent[2 * a + 1] = std::min(extent[2 * a + 1] + this->GetRadius(), whole[2 * a + 1]);
    }
  }
  input->Set(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent, 6);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailSmooth::RequestData(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs)
{
  vtkImageData* image = vtkImageData::GetData(inputs[0]);
  vtkImageData* output = vtkImageData::GetData(outputs);
  int extent[6];
  outputs->GetInformationObject(0)->Get(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent);
  if (extent[0] > extent[1] || extent[2] > extent[3] || extent[4] > extent[5])
  {
    return 1;
  }
  vtkPointData* points = image->GetPointData();
  vtkDataArray* array = points->GetScalars() ? points->GetScalars() : points->GetArray(0);
  if (array == nullptr)
  {
    vtkErrorMacro("The image has no point array of numbers to smooth.");
    return 0;
  }
  vtkNew<vtkImageData> scalars;
  scalars->CopyStructure(image);
  scalars->GetPointData()->SetScalars(array);
  vtkNew<vtkImageCast> cast;
  cast->SetInputData(scalars);
  cast->SetOutputScalarTypeToFloat();
  vtkNew<vtkImageGaussianSmooth> smooth;
  smooth->SetInputConnection(cast->GetOutputPort());
  smooth->SetStandardDeviation(this->StandardDeviation);
  smooth->SetRadiusFactor(Reach);
  smooth->UpdateExtent(extent);
  output->ShallowCopy(smooth->GetOutput());
  output->GetPointData()->GetScalars()->SetName(array->GetName());
  return 1;
}
