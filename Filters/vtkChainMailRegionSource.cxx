// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailRegionSource.h"

#include "vtkCellArray.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

vtkStandardNewMacro(vtkChainMailRegionSource);

//------------------------------------------------------------------------------
vtkChainMailRegionSource::vtkChainMailRegionSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkChainMailRegionSource::RequestData(vtkInformation* vtkNotUsed(request),
  vtkInformationVector** vtkNotUsed(inputVector), vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);

  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->InsertNextPoint(this->Center);
  output->SetPoints(points);

  vtkNew<vtkCellArray> vertices;
  vertices->InsertNextCell({ 0 });
  output->SetVerts(vertices);

  vtkNew<vtkDoubleArray> radius;
  radius->SetName("Radius");
  radius->InsertNextValue(this->Radius);
  output->GetPointData()->AddArray(radius);

  vtkNew<vtkDoubleArray> constraint;
  constraint->SetName("Constraint");
  constraint->InsertNextValue(this->Constraint);
  output->GetPointData()->AddArray(constraint);
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailRegionSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Center: " << this->Center[0] << " " << this->Center[1] << " " << this->Center[2] << "\n";
  os << indent << "Radius: " << this->Radius << "\n";
  os << indent << "Constraint: " << this->Constraint << "\n";
}
