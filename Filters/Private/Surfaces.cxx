// SPDX-License-Identifier: BSD-3-Clause
#include "Surfaces.h"

#include "Text.h"

#include "Error.h"

#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkCleanPolyData.h"
#include "vtkFeatureEdges.h"
#include "vtkIdList.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkTriangleFilter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace vtkChainMail
{

namespace
{

/// Whether there is no boundary edge after merging coincident points.
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
  to.Flaw = to.Flaw.empty() ? part.Flaw : to.Flaw;
  if (to.Triangles.points.size() + part.Triangles.points.size() > std::numeric_limits<int>::max())
  {
    throw chainmail::InputError(
      to.Name + " has more than 2147483647 points. Simplify the surface, for example with Decimate.");
  }
  const int before = static_cast<int>(to.Triangles.points.size());
  to.Triangles.points.insert(to.Triangles.points.end(), part.Triangles.points.begin(), part.Triangles.points.end());
  for (const std::array<int, 3>& corners : part.Triangles.triangles)
  {
    to.Triangles.triangles.push_back({ corners[0] + before, corners[1] + before, corners[2] + before });
  }
}

/// Whether edges of a polygon cross, projected along the normal of its plane. Such a polygon cannot be triangulated.
bool CrossesItself(vtkPolyData* surface, vtkIdList* polygon)
{
  const vtkIdType count = polygon->GetNumberOfIds();
  constexpr vtkIdType most = 4096; // limit, since all pairs of edges are compared
  if (count < 4 || count > most)
  {
    return false;
  }
  std::vector<std::array<double, 3>> points(static_cast<std::size_t>(count));
  for (vtkIdType n = 0; n < count; ++n)
  {
    surface->GetPoint(polygon->GetId(n), points[n].data());
  }
  // The plane through three points that are far apart, because the area of a polygon that crosses itself may be 0.
  std::array<double, 3> along{};
  std::array<double, 3> normal{};
  const auto take = [&](auto&& candidate, std::array<double, 3>& best)
  {
    for (const std::array<double, 3>& point : points)
    {
      std::array<double, 3> one;
      std::array<double, 3> way;
      vtkMath::Subtract(point.data(), points[0].data(), way.data());
      candidate(way, one);
      best = vtkMath::Norm(one.data()) > vtkMath::Norm(best.data()) ? one : best;
    }
  };
  take([](const auto& way, auto& one) { one = way; }, along);
  take([&](const auto& way, auto& one) { vtkMath::Cross(along.data(), way.data(), one.data()); }, normal);
  int axis = 0;
  for (int a = 1; a < 3; ++a)
  {
    axis = std::fabs(normal[a]) > std::fabs(normal[axis]) ? a : axis;
  }
  const int x = (axis + 1) % 3;
  const int y = (axis + 2) % 3;
  const auto side = [&](const std::array<double, 3>& a, const std::array<double, 3>& b, const std::array<double, 3>& c)
  { return (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]); };
  for (vtkIdType n = 0; n < count; ++n)
  {
    const auto& a = points[n];
    const auto& b = points[(n + 1) % count];
    for (vtkIdType m = n + 2; m < count; ++m)
    {
      const auto& c = points[m];
      const auto& d = points[(m + 1) % count];
      if (side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0)
      {
        return true;
      }
    }
  }
  return false;
}

InputSurface ReadSurface(const InputDataset& leaf, const Frame& space)
{
  vtkPolyData* surface = leaf.Data;
  const std::string where = leaf.ToString();

  // Checks before the triangulation. That moves no points, but it might drop broken polygons, and it reads three
  // corners of every strip, even if a strip has fewer.
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkCellArray> strips;
  vtkNew<vtkIdList> cell;
  std::string flaw;
  vtkIdType number = 0;
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
          throw chainmail::InputError(where + ", point " + std::to_string(cell->GetId(n)) + " at " + ToString(point) +
                                      ": the position has to be finite. Correct or remove the point.");
        }
      }
      if (cell->GetNumberOfIds() >= 3)
      {
        to->InsertNextCell(cell);
      }
      if (to == polys.Get() && flaw.empty() && CrossesItself(surface, cell))
      {
        flaw = "polygon " + std::to_string(number) +
               " crosses itself, so triangles may cover only parts of it. Give its points in their order around the "
               "polygon, or give triangles.";
      }
      ++number;
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
    throw chainmail::InputError(
      where + " has more than 2147483647 points. Simplify the surface, for example with Decimate.");
  }

  InputSurface read{ where, {}, flaw };
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
  for (const InputDataset& leaf : inputs.Leaves)
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
  std::map<int, InputSurface> open; // all open datasets of an input, joined
  for (const InputDataset& leaf : inputs.Leaves)
  {
    if (leaf.Port != CARVES)
    {
      continue;
    }
    InputSurface surface = ReadSurface(leaf, space);
    const auto ofSameInput = [&](const InputDataset& other)
    { return other.Port == CARVES && other.Input == leaf.Input; };
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
    surfaces.push_back(std::move(surface)); // the engine throws an error if it is still open
  }
  return surfaces;
}

}
