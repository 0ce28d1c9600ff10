// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailMatrices.h"

#include "Error.h"
#include "Private/BodyMiddles.h"
#include "Private/ProbeSet.h"
#include "Private/RigidMotion.h"
#include "Private/Text.h"

#include "vtkDataSet.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTable.h"

#include <cmath>

vtkStandardNewMacro(vtkChainMailMatrices);

namespace
{

using chainmail::InputError;
using vtkChainMail::BodyMotion;

long long ToBody(double label, const std::string& where)
{
  if (!(label >= 0.0 && label < 9e15 && label == std::floor(label)))
  {
    throw InputError("The label of " + where + " is " + vtkChainMail::ToString(label) +
                     "; it must be a whole number, the label of a bone in the image of labels.");
  }
  return static_cast<long long>(label);
}

std::vector<BodyMotion> MotionsOfTable(vtkTable* table)
{
  std::vector<std::pair<vtkDataArray*, int>> numbers; // a column and its component
  for (vtkIdType c = 0; c < table->GetNumberOfColumns(); ++c)
  {
    auto* column = vtkDataArray::SafeDownCast(table->GetColumn(c));
    for (int k = 0; column && k < column->GetNumberOfComponents(); ++k)
    {
      numbers.emplace_back(column, k);
    }
  }
  if (table->GetNumberOfRows() > 0 && numbers.size() != 17)
  {
    throw InputError("The table has " + std::to_string(numbers.size()) +
                     " numbers in each row, but needs 17: a label and a 4 x 4 matrix, row by row. " +
                     vtkChainMail::ListArrays(table->GetRowData()));
  }
  std::vector<BodyMotion> motions;
  for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
  {
    BodyMotion motion;
    motion.Name = "row " + std::to_string(row + 1);
    motion.Body = ToBody(numbers[0].first->GetComponent(row, numbers[0].second), motion.Name);
    for (std::size_t k = 0; k < 16; ++k)
    {
      motion.Matrix[k] = numbers[k + 1].first->GetComponent(row, numbers[k + 1].second);
    }
    motions.push_back(motion);
  }
  return motions;
}

std::vector<BodyMotion> MotionsOfPoints(vtkDataSet* points)
{
  vtkPointData* arrays = points->GetPointData();
  vtkDataArray* body = arrays->GetArray("Body");
  vtkDataArray* matrix = arrays->GetArray("Matrix");
  vtkDataArray* centre = arrays->GetArray("Centre");
  std::vector<BodyMotion> motions;
  if (points->GetNumberOfPoints() == 0)
  {
    return motions;
  }
  if (!body || body->GetNumberOfComponents() != 1 || !matrix || matrix->GetNumberOfComponents() != 16)
  {
    throw InputError("The input has no point arrays Body (a label) and Matrix (16 components, row by row). " +
                     vtkChainMail::ListArrays(arrays));
  }
  for (vtkIdType n = 0; n < points->GetNumberOfPoints(); ++n)
  {
    BodyMotion motion;
    motion.Name = "point " + std::to_string(n);
    const double label = body->GetComponent(n, 0);
    motion.Body = label == -1.0 ? -1 : ToBody(label, motion.Name);
    matrix->GetTuple(n, motion.Matrix.data());
    motion.HasPosition = motion.Body < 0;
    points->GetPoint(n, motion.Position.data());
    motion.HasCentre = centre && centre->GetNumberOfComponents() == 3;
    if (motion.HasCentre)
    {
      centre->GetTuple(n, motion.Centre.data());
    }
    motions.push_back(motion);
  }
  return motions;
}

}

//------------------------------------------------------------------------------
vtkChainMailMatrices::vtkChainMailMatrices()
{
  this->SetNumberOfInputPorts(2);
}

//------------------------------------------------------------------------------
int vtkChainMailMatrices::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  for (const char* const type : { "vtkTable", "vtkDataSet" })
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), port == 1 ? "vtkImageData" : type);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), port == 1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailMatrices::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Superclass::RequestUpdateExtent(request, inputVector, outputVector);
  if (vtkInformation* labels = inputVector[1]->GetInformationObject(0))
  {
    labels->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailMatrices::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using namespace vtkChainMail;
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  this->Report.clear();
  try
  {
    vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
    auto* table = vtkTable::SafeDownCast(input);
    std::string problem;
    std::vector<BodyMotion> motions;
    try
    {
      motions = table ? MotionsOfTable(table) : MotionsOfPoints(vtkDataSet::SafeDownCast(input));
    }
    catch (const InputError& error)
    {
      problem = error.what(); // thrown later: all processes have to call BodyMiddles::Find()
    }
    vtkInformation* labelInfo = inputVector[1]->GetInformationObject(0);
    if (labelInfo)
    {
      BodyMiddles middles;
      problem += middles.Find(vtkImageData::GetData(labelInfo), labelInfo, this->LabelArray, motions);
      for (BodyMotion& motion : motions)
      {
        if (motion.Body >= 0 && problem.empty())
        {
          motion.HasCentre = middles.Get(motion.Body, motion.Centre);
          problem = motion.HasCentre
                      ? ""
                      : "The image of labels has no voxel with the label " + std::to_string(motion.Body) + " of " +
                          motion.Name + ". Correct the label, or choose another LabelArray.";
        }
      }
    }
    if (!problem.empty())
    {
      throw InputError(problem);
    }
    for (BodyMotion& motion : motions)
    {
      CheckRigid(motion);
      motion.Matrix = this->Invert ? Inverted(motion.Matrix) : motion.Matrix;
    }
    MakeProbes(motions, output);
    this->Report = motions.empty() ? "No matrices.\n"
                                   : std::to_string(motions.size()) +
                                       (motions.size() == 1 ? " matrix. " : " matrices. ") + SummaryOf(output) + "\n";
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailMatrices::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "LabelArray: " << this->LabelArray << "\n";
  os << indent << "Invert: " << (this->Invert ? "On" : "Off") << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
