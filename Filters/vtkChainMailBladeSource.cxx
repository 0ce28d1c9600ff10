// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailBladeSource.h"

#include "vtkCellArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

vtkStandardNewMacro(vtkChainMailBladeSource);

//------------------------------------------------------------------------------
vtkChainMailBladeSource::vtkChainMailBladeSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkChainMailBladeSource::RequestData(vtkInformation* vtkNotUsed(request),
  vtkInformationVector** vtkNotUsed(inputVector), vtkInformationVector* outputVector)
{
  double into[3] = { this->Direction[0], this->Direction[1], this->Direction[2] };
  if (vtkMath::Normalize(into) == 0.0)
  {
    vtkErrorMacro(
      "Direction is (0, 0, 0). Set it to a vector that points into the tissue; its length does not matter.");
    return 0;
  }
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  const auto add = [&](const double end[3], double depth)
  { points->InsertNextPoint(end[0] + depth * into[0], end[1] + depth * into[1], end[2] + depth * into[2]); };
  add(this->Start, -this->Height);
  add(this->End, -this->Height);
  add(this->End, this->Depth);
  add(this->Start, this->Depth);
  output->SetPoints(points);

  vtkNew<vtkCellArray> polygons;
  polygons->InsertNextCell({ 0, 1, 2, 3 });
  output->SetPolys(polygons);
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailBladeSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Start: " << this->Start[0] << " " << this->Start[1] << " " << this->Start[2] << "\n";
  os << indent << "End: " << this->End[0] << " " << this->End[1] << " " << this->End[2] << "\n";
  os << indent << "Direction: " << this->Direction[0] << " " << this->Direction[1] << " " << this->Direction[2] << "\n";
  os << indent << "Depth: " << this->Depth << "\n";
  os << indent << "Height: " << this->Height << "\n";
}
