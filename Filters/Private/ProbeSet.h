// SPDX-License-Identifier: BSD-3-Clause
// Point sets for the Probes of vtkChainMailDeformation, as filters and readers make them.

#ifndef ProbeSet_h
#define ProbeSet_h

#include "vtkCellArray.h"
#include "vtkDoubleArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

namespace vtkChainMail
{

/// Adds an array that the deformation reads, with uninitialised values.
inline vtkSmartPointer<vtkDoubleArray> AddProbeArray(vtkPolyData* probes, const char* name, int components)
{
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(probes->GetNumberOfPoints());
  probes->GetPointData()->AddArray(array);
  return array;
}

/// Sets the points of `probes`, which are to be in double precision, and adds a vertex to each, so they are visible.
inline void SetProbePoints(vtkPolyData* probes, vtkPoints* points)
{
  probes->SetPoints(points);
  vtkNew<vtkCellArray> vertices;
  vertices->AllocateEstimate(points->GetNumberOfPoints(), 1);
  for (vtkIdType n = 0; n < points->GetNumberOfPoints(); ++n)
  {
    vertices->InsertNextCell(1, &n);
  }
  probes->SetVerts(vertices);
}

/// Adds the arrays Radius and Tolerance, with the same value for all probes.
inline void SetGrip(vtkPolyData* probes, double radius, double tolerance)
{
  AddProbeArray(probes, "Radius", 1)->Fill(radius);
  AddProbeArray(probes, "Tolerance", 1)->Fill(tolerance);
}

}

#endif
