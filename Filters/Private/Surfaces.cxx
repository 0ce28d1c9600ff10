// SPDX-License-Identifier: BSD-3-Clause
#include "Surfaces.h"

#include "Text.h"

#include "Error.h"

#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkCleanPolyData.h"
#include "vtkFeatureEdges.h"
#include "vtkIdList.h"
#include "vtkNew.h"
#include "vtkTriangleFilter.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace vtkChainMail
{

namespace
{

/// Whether no edge is a boundary, once points at the same place are merged.
bool IsClosed(vtkPolyData* surface)
{
  vtkNew<vtkCleanPolyData> mergePoints;
  mergePoints->SetInputData(surface);
  mergePoints->ToleranceIsAbsoluteOn();
  mergePoints->SetAbsoluteTolerance(0.0);
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputConnection(mergePoints->GetOutputPort());
  edges->BoundaryEdgesOn();
  edges->FeatureEdgesOff();
  edges->ManifoldEdgesOff();
  edges->NonManifoldEdgesOff();
  edges->Update();
  return edges->GetOutput()->GetNumberOfCells() == 0;
}

/// Adds the triangles of one surface to another.
void Append(const InputSurface& part, InputSurface& to)
{
  to.Name = to.Name.empty() ? part.Name : to.Name;
  const int before = static_cast<int>(to.Triangles.points.size());
  to.Triangles.points.insert(to.Triangles.points.end(), part.Triangles.points.begin(), part.Triangles.points.end());
  for (const std::array<int, 3>& corners : part.Triangles.triangles)
  {
    to.Triangles.triangles.push_back({ corners[0] + before, corners[1] + before, corners[2] + before });
  }
}

InputSurface ReadSurface(const Leaf& leaf, const Frame& space)
{
  vtkPolyData* surface = leaf.Data;
  const std::string where = leaf.ToString();

  // Checks before the triangulation. That moves no point, but it might drop broken polygons, and it reads three corners
  // of every strip.
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkCellArray> strips;
  vtkNew<vtkIdList> cell;
  const std::pair<vtkCellArray*, vtkCellArray*> lists[] = { { surface->GetPolys(), polys },
    { surface->GetStrips(), strips } };
  for (const auto& [from, to] : lists)
  {
    const auto iterator = vtk::TakeSmartPointer(from->NewIterator());
    for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
    {
      iterator->GetCurrentCell(cell);
      for (vtkIdType n = 0; n < cell->GetNumberOfIds(); ++n)
      {
        double point[3];
        surface->GetPoint(cell->GetId(n), point);
        if (!IsFinite(point))
        {
          throw chainmail::InputError(
            where + ", point " + std::to_string(cell->GetId(n)) + " at " + ToString(point) +
            ": the position has to be finite. Leave the point out, or put it where it belongs.");
        }
      }
      if (cell->GetNumberOfIds() >= 3)
      {
        to->InsertNextCell(cell);
      }
    }
  }

  vtkNew<vtkPolyData> polygons;
  polygons->SetPoints(surface->GetPoints());
  polygons->SetPolys(polys);
  polygons->SetStrips(strips);
  vtkNew<vtkTriangleFilter> triangulate;
  triangulate->SetInputData(polygons);
  triangulate->PassVertsOff();
  triangulate->PassLinesOff();
  triangulate->Update();
  vtkPolyData* triangles = triangulate->GetOutput();
  if (triangles->GetNumberOfPoints() > std::numeric_limits<int>::max())
  {
    throw chainmail::InputError(where + " has more points than can be handled: simplify it.");
  }

  InputSurface read{ where, {} };
  chainmail::Surface& to = read.Triangles;
  to.points.reserve(static_cast<std::size_t>(triangles->GetNumberOfPoints()));
  for (vtkIdType p = 0; p < triangles->GetNumberOfPoints(); ++p)
  {
    // Points that belong to no polygon may have any coordinates.
    double point[3];
    triangles->GetPoint(p, point);
    to.points.push_back(IsFinite(point) ? space.PointToEngine(point) : Vector3{});
  }
  to.triangles.reserve(static_cast<std::size_t>(triangles->GetNumberOfPolys()));
  const auto iterator = vtk::TakeSmartPointer(triangles->GetPolys()->NewIterator());
  for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
  {
    iterator->GetCurrentCell(cell);
    to.triangles.push_back(
      { static_cast<int>(cell->GetId(0)), static_cast<int>(cell->GetId(1)), static_cast<int>(cell->GetId(2)) });
  }
  return read;
}

}

bool Same(const InputSurface& a, const InputSurface& b)
{
  return a.Triangles.points == b.Triangles.points && a.Triangles.triangles == b.Triangles.triangles;
}

std::vector<InputSurface> ReadCuts(const Inputs& inputs, const Frame& space)
{
  std::vector<InputSurface> surfaces;
  for (const Leaf& leaf : inputs.Leaves)
  {
    if (leaf.Port == CUTS)
    {
      surfaces.push_back(ReadSurface(leaf, space));
    }
  }
  return surfaces;
}

std::vector<InputSurface> ReadCarves(const Inputs& inputs, const Frame& space)
{
  std::vector<InputSurface> surfaces;
  std::map<int, InputSurface> open; // open surfaces, by input
  for (const Leaf& leaf : inputs.Leaves)
  {
    if (leaf.Port != CARVES)
    {
      continue;
    }
    InputSurface surface = ReadSurface(leaf, space);
    const auto ofSameInput = [&](const Leaf& other) { return other.Port == CARVES && other.Input == leaf.Input; };
    const auto& leaves = inputs.Leaves;
    if (std::count_if(leaves.begin(), leaves.end(), ofSameInput) == 1 || IsClosed(leaf.Data))
    {
      surfaces.push_back(std::move(surface));
    }
    else
    {
      Append(surface, open[leaf.Input]);
    }
  }
  for (auto& [input, surface] : open)
  {
    surfaces.push_back(std::move(surface)); // the engine refuses a surface that is still open
  }
  return surfaces;
}

}
