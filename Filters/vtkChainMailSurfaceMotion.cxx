// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailSurfaceMotion.h"

#include "Error.h"
#include "Private/ClosestPoints.h"
#include "Private/ProbeSet.h"
#include "Private/Text.h"
#include "Private/Thinning.h"

#include "vtkCleanPolyData.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkTriangleFilter.h"

#include <algorithm>

vtkStandardNewMacro(vtkChainMailSurfaceMotion);

namespace
{

using chainmail::InputError;

void CheckFinite(vtkPolyData* surface, const char* name)
{
  for (vtkIdType n = 0; n < surface->GetNumberOfPoints(); ++n)
  {
    double place[3];
    surface->GetPoint(n, place);
    if (!vtkChainMail::IsFinite(place))
    {
      throw InputError("Point " + std::to_string(n) + " of " + name + " is at " + vtkChainMail::ToString(place) +
                       ", which is not finite. Correct or remove the point.");
    }
  }
}

bool HaveEqualCells(vtkCellArray* a, vtkCellArray* b)
{
  vtkIdType sizes[2];
  const vtkIdType* corners[2];
  if (a == b || a->GetNumberOfCells() != b->GetNumberOfCells())
  {
    return a == b; // filters that only move points share the polygons
  }
  a->InitTraversal();
  b->InitTraversal();
  while (a->GetNextCell(sizes[0], corners[0]) && b->GetNextCell(sizes[1], corners[1]))
  {
    if (sizes[0] != sizes[1] || !std::equal(corners[0], corners[0] + sizes[0], corners[1]))
    {
      return false;
    }
  }
  return true;
}

bool AreOneMesh(vtkPolyData* a, vtkPolyData* b)
{
  return a->GetNumberOfPoints() == b->GetNumberOfPoints() && HaveEqualCells(a->GetPolys(), b->GetPolys()) &&
         HaveEqualCells(a->GetStrips(), b->GetStrips());
}

/// The displacements there - rest of two surfaces, matched by the order of points.
vtkSmartPointer<vtkDoubleArray> Subtract(vtkPolyData* there, vtkPolyData* rest, const char* name, const char* remedy)
{
  if (there->GetNumberOfPoints() != rest->GetNumberOfPoints())
  {
    throw InputError("Before has " + std::to_string(rest->GetNumberOfPoints()) + " points and " + name + " has " +
                     std::to_string(there->GetNumberOfPoints()) + ", so they are not the same mesh. " + remedy);
  }
  auto ways = vtkSmartPointer<vtkDoubleArray>::New();
  ways->SetNumberOfComponents(3);
  ways->SetNumberOfTuples(rest->GetNumberOfPoints());
  for (vtkIdType n = 0; n < rest->GetNumberOfPoints(); ++n)
  {
    double from[3];
    double to[3];
    rest->GetPoint(n, from);
    there->GetPoint(n, to);
    vtkMath::Subtract(to, from, to);
    ways->SetTuple(n, to);
  }
  return ways;
}

/// The surface as triangles that share their points, which those of an STL file do not. `array`, a point array, is
/// kept.
vtkSmartPointer<vtkPolyData> Prepare(vtkPolyData* surface, const char* name, vtkDataArray* array = nullptr)
{
  vtkNew<vtkPolyData> bare;
  bare->CopyStructure(surface);
  if (array)
  {
    bare->GetPointData()->AddArray(array);
  }
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(bare);
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  vtkNew<vtkCleanPolyData> clean;
  clean->SetInputConnection(triangles->GetOutputPort());
  clean->ConvertPolysToLinesOff(); // degenerate triangles are left out
  clean->ConvertLinesToPointsOff();
  clean->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  clean->Update();
  auto prepared = vtkSmartPointer<vtkPolyData>::New();
  prepared->SetPoints(clean->GetOutput()->GetPoints());
  prepared->SetPolys(clean->GetOutput()->GetPolys());
  if (array)
  {
    prepared->GetPointData()->AddArray(clean->GetOutput()->GetPointData()->GetArray(0));
  }
  if (prepared->GetNumberOfPolys() == 0)
  {
    throw InputError(std::string(name) + " has no polygons, which closest points need. Give a surface, or as many "
                                         "points in After as in Before to match them by their order.");
  }
  return prepared;
}

}

//------------------------------------------------------------------------------
vtkChainMailSurfaceMotion::vtkChainMailSurfaceMotion()
{
  this->SetNumberOfInputPorts(3);
}

//------------------------------------------------------------------------------
int vtkChainMailSurfaceMotion::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), port == 2);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailSurfaceMotion::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  vtkSmartPointer<vtkPolyData> before = vtkPolyData::GetData(inputVector[0], 0);
  vtkSmartPointer<vtkPolyData> after = vtkPolyData::GetData(inputVector[1], 0);
  vtkPolyData* start = vtkPolyData::GetData(inputVector[2], 0);
  this->Report.clear();
  try
  {
    if (before->GetNumberOfPoints() == 0 && after->GetNumberOfPoints() == 0)
    {
      return 1; // as on server processes that have no piece of either surface
    }
    CheckFinite(before, "Before");
    CheckFinite(after, "After");
    const bool isOneMesh =
      this->Match == MATCH_SAME_POINTS || (this->Match == MATCH_AUTOMATIC && AreOneMesh(before, after));
    std::vector<std::array<double, 3>> ways;
    std::string how = std::string("matched by the order of their points") + (start ? ", without Start" : "");
    if (isOneMesh)
    {
      const auto byOrder = Subtract(after, before, "After", "Set Match to Closest points.");
      ways.resize(static_cast<std::size_t>(before->GetNumberOfPoints()));
      for (std::size_t n = 0; n < ways.size(); ++n)
      {
        byOrder->GetTuple(static_cast<vtkIdType>(n), ways[n].data());
      }
    }
    else
    {
      vtkSmartPointer<vtkDoubleArray> moved;
      if (start)
      {
        CheckFinite(start, "Start");
        moved =
          Subtract(start, before, "Start", "As Start, connect the surface Before as ChainMail Carry has moved it.");
      }
      before = Prepare(before, "Before", moved);
      after = Prepare(after, "After");
      vtkChainMail::ClosestPoints closest(before, after, before->GetPointData()->GetArray(0));
      closest.Match(this->Iterations, this->Smoothing,
        [&](double share)
        {
          this->UpdateProgress(share);
          return !this->GetAbortExecute();
        });
      ways = closest.GetDisplacements();
      how = "matched by closest points, at a distance of " + chainmail::toString(closest.GetDistance(), 3) +
            " mm on average. Sliding along the surface is not detected";
    }

    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkChainMail::Thinning thinning(this->Spacing);
    std::vector<std::size_t> chosen;
    double sum = 0.0;
    double most = 0.0;
    for (std::size_t n = 0; n < ways.size(); ++n)
    {
      double place[3];
      before->GetPoint(static_cast<vtkIdType>(n), place);
      if (thinning.Takes(place))
      {
        chosen.push_back(n);
        points->InsertNextPoint(place);
        const double length = vtkMath::Norm(ways[n].data());
        sum += length;
        most = std::max(most, length);
      }
    }
    vtkChainMail::SetProbePoints(output, points);
    const auto displacement = vtkChainMail::AddProbeArray(output, "Displacement", 3);
    for (std::size_t n = 0; n < chosen.size(); ++n)
    {
      displacement->SetTuple(static_cast<vtkIdType>(n), ways[chosen[n]].data());
    }
    output->GetPointData()->SetActiveVectors("Displacement");
    vtkChainMail::SetGrip(output, this->Radius, this->Tolerance);
    const double count = static_cast<double>(std::max<std::size_t>(chosen.size(), 1));
    this->Report = std::to_string(chosen.size()) + " probes with displacements of " +
                   chainmail::toString(sum / count, 3) + " mm on average, at most " + chainmail::toString(most, 3) +
                   " mm. Surfaces " + how + ".\n";
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailSurfaceMotion::PrintSelf(ostream& os, vtkIndent indent)
{
  const char* const matches[] = { "Automatic", "Same points", "Closest points" };
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Match: " << matches[this->Match] << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "Smoothing: " << this->Smoothing << "\n";
  os << indent << "Spacing: " << this->Spacing << "\n";
  os << indent << "Radius: " << this->Radius << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
