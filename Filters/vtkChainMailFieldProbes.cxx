// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailFieldProbes.h"

#include "Error.h"
#include "Private/ProbeSet.h"
#include "Private/Text.h"
#include "Private/Thinning.h"

#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPointSet.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cstring>
#include <functional>

vtkStandardNewMacro(vtkChainMailFieldProbes);

namespace
{

using chainmail::InputError;

/// The mask, or everything where there is none.
class Mask
{
public:
  Mask(vtkImageData* image, const std::string& name, double minimum)
    : Image(image)
    , Minimum(minimum)
  {
    if (!image)
    {
      return;
    }
    vtkPointData* arrays = image->GetPointData();
    this->Values = name.empty() ? arrays->GetScalars() : arrays->GetArray(name.c_str());
    if (image->GetNumberOfPoints() == 0 || !this->Values || this->Values->GetNumberOfComponents() != 1)
    {
      throw InputError(
        (name.empty() ? std::string("MaskArray is empty, but the mask has no active point array of one component. ")
                      : "MaskArray is \"" + name + "\", but the mask has no such point array of one component. ") +
        vtkChainMail::ListArrays(arrays));
    }
    image->GetExtent(this->Extent);
  }

  bool Holds(const double place[3]) const
  {
    if (!this->Image)
    {
      return true;
    }
    double index[3];
    this->Image->TransformPhysicalPointToContinuousIndex(place, index);
    int voxel[3];
    for (int a = 0; a < 3; ++a)
    {
      const double rounded = std::floor(index[a] + 0.5);
      if (!(rounded >= this->Extent[2 * a] && rounded <= this->Extent[2 * a + 1]))
      {
        return false;
      }
      voxel[a] = static_cast<int>(rounded);
    }
    return this->Values->GetComponent(this->Image->ComputePointId(voxel), 0) >= this->Minimum; // false for NaN
  }

private:
  vtkImageData* Image;
  vtkDataArray* Values = nullptr;
  double Minimum;
  int Extent[6] = { 0, -1, 0, -1, 0, -1 };
};

/// Visits every n-th voxel of an image along each axis. Counting starts at index 0, so all pieces choose alike. Voxels
/// that two pieces have in common are visited once.
void VisitVoxels(vtkImageData* image, vtkInformation* info, double spacing, const std::function<void(vtkIdType)>& visit)
{
  int extent[6];
  int whole[6];
  image->GetExtent(extent);
  std::memcpy(whole, extent, sizeof(whole));
  if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
  {
    info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
  }
  int step[3];
  int first[3];
  int last[3];
  for (int a = 0; a < 3; ++a)
  {
    const double steps = std::floor(spacing / image->GetSpacing()[a] + 0.5);
    step[a] = static_cast<int>(std::min(std::max(steps, 1.0), 1e6));
    const int beyond = extent[2 * a] % step[a];
    first[a] = extent[2 * a] + (beyond == 0 ? 0 : beyond > 0 ? step[a] - beyond : -beyond);
    last[a] = extent[2 * a + 1] < whole[2 * a + 1] ? extent[2 * a + 1] - 1 : extent[2 * a + 1];
  }
  int ijk[3];
  for (ijk[2] = first[2]; ijk[2] <= last[2]; ijk[2] += step[2])
  {
    for (ijk[1] = first[1]; ijk[1] <= last[1]; ijk[1] += step[1])
    {
      for (ijk[0] = first[0]; ijk[0] <= last[0]; ijk[0] += step[0])
      {
        visit(image->ComputePointId(ijk));
      }
    }
  }
}

}

//------------------------------------------------------------------------------
vtkChainMailFieldProbes::vtkChainMailFieldProbes()
{
  this->SetNumberOfInputPorts(2);
}

//------------------------------------------------------------------------------
int vtkChainMailFieldProbes::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  if (port == 0)
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPointSet");
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), port == 1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailFieldProbes::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Superclass::RequestUpdateExtent(request, inputVector, outputVector);
  inputVector[0]->GetInformationObject(0)->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  if (vtkInformation* mask = inputVector[1]->GetInformationObject(0))
  {
    if (mask->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      int whole[6];
      mask->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
      mask->Set(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), whole, 6);
    }
    mask->Set(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER(), 0);
    mask->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES(), 1);
    mask->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailFieldProbes::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  vtkDataSet* input = vtkDataSet::GetData(inputVector[0], 0);
  this->Report.clear();
  try
  {
    vtkPointData* arrays = input->GetPointData();
    vtkDataArray* field = arrays->GetArray(this->Field.empty() ? "Displacement" : this->Field.c_str());
    field = !field && this->Field.empty() ? arrays->GetVectors() : field;
    if (input->GetNumberOfPoints() > 0 && (!field || field->GetNumberOfComponents() != 3))
    {
      throw InputError((this->Field.empty() ? std::string("Field is empty, but the input has neither a point array "
                                                          "Displacement nor active vectors of 3 components. ")
                                            : "Field is \"" + this->Field +
                                                "\", but the input has no such point array of 3 components. ") +
                       vtkChainMail::ListArrays(arrays));
    }
    const Mask mask(vtkImageData::GetData(inputVector[1], 0), this->MaskArray, this->MaskMinimum);
    auto* image = vtkImageData::SafeDownCast(input);
    vtkUnsignedCharArray* ghosts = input->GetPointGhostArray();
    vtkChainMail::Thinning thinning(image ? 0.0 : this->Spacing);
    std::vector<vtkIdType> chosen;
    vtkIdType outside = 0;
    vtkIdType nowhere = 0;
    double most = 0.0;
    const auto visit = [&](vtkIdType n)
    {
      double place[3];
      double way[3];
      input->GetPoint(n, place);
      field->GetTuple(n, way);
      if (ghosts && ghosts->GetValue(n) != 0)
      {
        return;
      }
      if (!vtkChainMail::IsFinite(place) || !vtkChainMail::IsFinite(way))
      {
        ++nowhere;
      }
      else if (!mask.Holds(place))
      {
        ++outside;
      }
      else if (thinning.Takes(place))
      {
        chosen.push_back(n);
        most = std::max(most, vtkMath::Norm(way));
      }
    };
    if (image && input->GetNumberOfPoints() > 0)
    {
      VisitVoxels(image, inputVector[0]->GetInformationObject(0), this->Spacing, visit);
    }
    for (vtkIdType n = 0; !image && n < input->GetNumberOfPoints(); ++n)
    {
      visit(n);
    }

    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(static_cast<vtkIdType>(chosen.size()));
    for (std::size_t n = 0; n < chosen.size(); ++n)
    {
      points->SetPoint(static_cast<vtkIdType>(n), input->GetPoint(chosen[n]));
    }
    vtkChainMail::SetProbePoints(output, points);
    const auto displacement = vtkChainMail::AddProbeArray(output, "Displacement", 3);
    for (std::size_t n = 0; n < chosen.size(); ++n)
    {
      displacement->SetTuple(static_cast<vtkIdType>(n), field->GetTuple(chosen[n]));
    }
    output->GetPointData()->SetActiveVectors("Displacement");
    vtkChainMail::SetGrip(output, this->Radius, this->Tolerance);
    this->Report = std::to_string(chosen.size()) + " probes with displacements up to " + chainmail::toString(most, 4) +
                   " mm. Left out: " + std::to_string(outside) + " places outside the mask, " +
                   std::to_string(nowhere) + " without a finite displacement.\n";
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailFieldProbes::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Field: " << this->Field << "\n";
  os << indent << "MaskArray: " << this->MaskArray << "\n";
  os << indent << "MaskMinimum: " << this->MaskMinimum << "\n";
  os << indent << "Spacing: " << this->Spacing << "\n";
  os << indent << "Radius: " << this->Radius << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
