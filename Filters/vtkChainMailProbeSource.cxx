// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailProbeSource.h"

#include "vtkCellArray.h"
#include "vtkDoubleArray.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkUnsignedCharArray.h"

vtkStandardNewMacro(vtkChainMailProbeSource);

//------------------------------------------------------------------------------
vtkChainMailProbeSource::vtkChainMailProbeSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkChainMailProbeSource::RequestData(vtkInformation* vtkNotUsed(request),
  vtkInformationVector** vtkNotUsed(inputVector), vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);

  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->InsertNextPoint(this->Position);
  output->SetPoints(points);

  vtkNew<vtkCellArray> vertices;
  vertices->InsertNextCell({ 0 });
  output->SetVerts(vertices);

  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("Displacement");
  displacement->SetNumberOfComponents(3);
  displacement->InsertNextTuple3(
    this->Target[0] - this->Position[0], this->Target[1] - this->Position[1], this->Target[2] - this->Position[2]);
  output->GetPointData()->SetVectors(displacement);

  vtkNew<vtkDoubleArray> radius;
  radius->SetName("Radius");
  radius->InsertNextValue(this->Radius);
  output->GetPointData()->AddArray(radius);

  vtkNew<vtkUnsignedCharArray> anchor;
  anchor->SetName("Anchor");
  anchor->InsertNextValue(this->Anchor ? 1 : 0);
  output->GetPointData()->AddArray(anchor);

  vtkNew<vtkDoubleArray> tolerance;
  tolerance->SetName("Tolerance");
  tolerance->InsertNextValue(this->Tolerance);
  output->GetPointData()->AddArray(tolerance);

  if (this->Turns)
  {
    vtkNew<vtkDoubleArray> rotation;
    rotation->SetName("Rotation");
    rotation->SetNumberOfComponents(3);
    rotation->InsertNextTuple(this->Rotation);
    output->GetPointData()->AddArray(rotation);
  }
  if (this->Body != -1)
  {
    vtkNew<vtkIdTypeArray> body;
    body->SetName("Body");
    body->InsertNextValue(this->Body);
    output->GetPointData()->AddArray(body);
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailProbeSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Position: " << this->Position[0] << " " << this->Position[1] << " " << this->Position[2] << "\n";
  os << indent << "Target: " << this->Target[0] << " " << this->Target[1] << " " << this->Target[2] << "\n";
  os << indent << "Radius: " << this->Radius << "\n";
  os << indent << "Anchor: " << (this->Anchor ? "On" : "Off") << "\n";
  os << indent << "Turns: " << (this->Turns ? "On" : "Off") << "\n";
  os << indent << "Rotation: " << this->Rotation[0] << " " << this->Rotation[1] << " " << this->Rotation[2] << "\n";
  os << indent << "Body: " << this->Body << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
}
