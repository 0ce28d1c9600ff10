// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailSmooth.h"

#include "vtkCellData.h"
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
void vtkChainMailSmooth::SetStandardDeviation(double voxels)
{
  const double within = voxels > 0.0 ? std::min(voxels, 4.0) : 0.0; // 0 of NaN, too
  if (within != this->StandardDeviation)
  {
    this->StandardDeviation = within;
    this->Modified();
  }
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
  vtkInformation* input = inputs[0]->GetInformationObject(0);
  vtkInformation* output = outputs->GetInformationObject(0);
  // Of an image in pieces, what a piece needs of the others comes as ghost points; else as a larger part.
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  if (output->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()) > 1)
  {
    input->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(),
      output->Get(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS()) + this->GetRadius());
    return 1;
  }
  int extent[6];
  int whole[6];
  output->Get(Pipeline::UPDATE_EXTENT(), extent);
  input->Get(Pipeline::WHOLE_EXTENT(), whole);
  for (int a = 0; a < 3 && extent[2 * a] <= extent[2 * a + 1]; ++a)
  {
    extent[2 * a] = std::max(extent[2 * a] - this->GetRadius(), whole[2 * a]);
    extent[2 * a + 1] = std::min(extent[2 * a + 1] + this->GetRadius(), whole[2 * a + 1]);
  }
  input->Set(Pipeline::UPDATE_EXTENT(), extent, 6);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailSmooth::RequestData(vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* outputs)
{
  vtkImageData* image = vtkImageData::GetData(inputs[0]);
  vtkImageData* output = vtkImageData::GetData(outputs);
  if (image->GetNumberOfPoints() == 0) // a process may have nothing of it
  {
    return 1;
  }
  vtkPointData* points = image->GetPointData();
  vtkDataArray* array = points->GetScalars() ? points->GetScalars() : points->GetArray(0);
  if (array == nullptr)
  {
    vtkErrorMacro("The image has no point array of numbers to smooth. If it has cell data, put Cell Data to Point Data "
                  "before this filter.");
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
  vtkImageAlgorithm* last = cast;
  if (this->StandardDeviation > 0.0)
  {
    last = smooth;
  }
  last->Update();
  output->ShallowCopy(last->GetOutput());
  output->GetPointData()->GetScalars()->SetName(array->GetName());
  // What belongs to other pieces goes on as such.
  const char* ghosts = vtkDataSetAttributes::GhostArrayName();
  if (points->GetArray(ghosts))
  {
    output->GetPointData()->AddArray(points->GetArray(ghosts));
  }
  if (image->GetCellData()->GetArray(ghosts))
  {
    output->GetCellData()->AddArray(image->GetCellData()->GetArray(ghosts));
  }
  return 1;
}
