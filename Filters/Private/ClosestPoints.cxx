// SPDX-License-Identifier: BSD-3-Clause
#include "ClosestPoints.h"

#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkGenericCell.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPoints.h"
#include "vtkSMPTools.h"
#include "vtkStaticCellLocator.h"
#include "vtkTriangle.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace vtkChainMail
{

namespace
{

using Vector = std::array<double, 3>;

/// The closest point of a surface, by the corners of its triangle and their weights (barycentric: 0 to 1, with sum 1).
struct Foot
{
  Vector Place;
  std::array<vtkIdType, 3> Corners;
  Vector Weights;
};

/// Clamps the weights to [0, 1] and normalises their sum, since they are off by rounding. Nearly degenerate triangles
/// give arbitrary weights or none; the nearest corner then gets the weight 1.
void MakeConvex(Foot& foot, vtkPolyData* surface)
{
  double sum = 0.0;
  bool isInside = true;
  for (double& weight : foot.Weights)
  {
    isInside = isInside && weight > -1e-3 && weight < 1.0 + 1e-3; // false for NaN
    weight = std::max(weight, 0.0);
    sum += weight;
  }
  if (isInside && sum > 0.5)
  {
    for (double& weight : foot.Weights)
    {
      weight /= sum;
    }
    return;
  }
  std::array<double, 3> distances;
  for (std::size_t c = 0; c < 3; ++c)
  {
    double corner[3];
    surface->GetPoint(foot.Corners[c], corner);
    distances[c] = vtkMath::Distance2BetweenPoints(corner, foot.Place.data());
  }
  foot.Weights = { { 0.0, 0.0, 0.0 } };
  foot.Weights[static_cast<std::size_t>(std::min_element(distances.begin(), distances.end()) - distances.begin())] =
    1.0;
}

/// The closest points of a surface for each of `points`.
std::vector<Foot> FeetOf(vtkPoints* points, vtkPolyData* surface)
{
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(surface);
  locator->BuildLocator();
  surface->BuildCells(); // here, because threads would do it concurrently
  std::vector<Foot> feet(static_cast<std::size_t>(points->GetNumberOfPoints()));
  vtkSMPTools::For(0, points->GetNumberOfPoints(),
    [&](vtkIdType begin, vtkIdType end)
    {
      vtkNew<vtkGenericCell> cell;
      for (vtkIdType n = begin; n < end; ++n)
      {
        double place[3];
        points->GetPoint(n, place);
        Foot& foot = feet[static_cast<std::size_t>(n)];
        vtkIdType id = -1;
        int part = 0;
        double squared = 0.0;
        locator->FindClosestPoint(place, foot.Place.data(), cell, id, part, squared);
        surface->GetCell(id, cell);
        foot.Weights.fill(vtkMath::Nan()); // a triangle without area leaves them unset
        double parametric[3];
        double closest[3];
        cell->EvaluatePosition(foot.Place.data(), closest, part, parametric, squared, foot.Weights.data());
        for (int c = 0; c < 3; ++c)
        {
          foot.Corners[c] = cell->GetPointId(c);
        }
        MakeConvex(foot, surface);
      }
    });
  return feet;
}

/// Whether a surface is closed: each edge belongs to two triangles, once in each direction. Decimation leaves slits, so
/// up to 2 % of the edges may be open.
bool IsClosed(vtkPolyData* surface)
{
  std::vector<std::pair<vtkIdType, vtkIdType>> there;
  std::vector<std::pair<vtkIdType, vtkIdType>> back;
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  vtkCellArray* triangles = surface->GetPolys();
  for (triangles->InitTraversal(); triangles->GetNextCell(size, corners);)
  {
    for (vtkIdType c = 0; c < size; ++c)
    {
      const vtkIdType next = corners[(c + 1) % size];
      there.emplace_back(corners[c], next);
      back.emplace_back(next, corners[c]);
    }
  }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  std::vector<std::pair<vtkIdType, vtkIdType>> open;
  std::set_difference(there.begin(), there.end(), back.begin(), back.end(), std::back_inserter(open));
  return open.size() <= there.size() / 50;
}

/// The centroid: of volume for closed surfaces, else of area. The latter is worse because folds of a surface attract
/// it.
Vector CentreOf(vtkPolyData* surface, bool isClosed)
{
  Vector centre = { { 0.0, 0.0, 0.0 } };
  double whole = 0.0;
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  double middle[3]; // apex of all tetrahedra, to reduce rounding errors
  surface->GetCenter(middle);
  vtkCellArray* triangles = surface->GetPolys();
  for (triangles->InitTraversal(); triangles->GetNextCell(size, corners);)
  {
    double p[3][3];
    for (int c = 0; c < 3; ++c)
    {
      surface->GetPoint(corners[c], p[c]);
      vtkMath::Subtract(p[c], middle, p[c]);
    }
    // The area of the triangle, or the volume of the tetrahedron between it and the middle.
    const double part =
      isClosed ? vtkMath::Determinant3x3(p[0], p[1], p[2]) / 6.0 : vtkTriangle::TriangleArea(p[0], p[1], p[2]);
    whole += part;
    for (int a = 0; a < 3; ++a)
    {
      centre[a] += part * (p[0][a] + p[1][a] + p[2][a]) / (isClosed ? 4.0 : 3.0);
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    centre[a] = middle[a] + (whole != 0.0 ? centre[a] / whole : 0.0);
  }
  return centre;
}

}

//------------------------------------------------------------------------------
ClosestPoints::ClosestPoints(vtkPolyData* before, vtkPolyData* after, vtkDataArray* start)
  : Before(before)
  , After(after)
  , Moved(vtkSmartPointer<vtkPolyData>::New())
  , Displacements(static_cast<std::size_t>(before->GetNumberOfPoints()))
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(before->GetNumberOfPoints());
  this->Moved->SetPoints(points);
  this->Moved->SetPolys(before->GetPolys());

  std::vector<std::set<vtkIdType>> neighbours(this->Displacements.size());
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  vtkCellArray* triangles = before->GetPolys();
  for (triangles->InitTraversal(); triangles->GetNextCell(size, corners);)
  {
    for (int c = 0; c < 3; ++c)
    {
      for (const int other : { (c + 1) % 3, (c + 2) % 3 })
      {
        neighbours[static_cast<std::size_t>(corners[c])].insert(corners[other]);
      }
    }
  }
  this->FirstNeighbour.push_back(0);
  for (const std::set<vtkIdType>& of : neighbours)
  {
    this->Neighbours.insert(this->Neighbours.end(), of.begin(), of.end());
    this->FirstNeighbour.push_back(static_cast<vtkIdType>(this->Neighbours.size()));
  }

  if (start)
  {
    for (std::size_t n = 0; n < this->Displacements.size(); ++n)
    {
      start->GetTuple(static_cast<vtkIdType>(n), this->Displacements[n].data());
    }
    this->Move();
    return;
  }
  const bool areClosed = IsClosed(before) && IsClosed(after);
  const Vector from = CentreOf(before, areClosed);
  const Vector to = CentreOf(after, areClosed);
  const Vector shift = { { to[0] - from[0], to[1] - from[1], to[2] - from[2] } };
  std::fill(this->Displacements.begin(), this->Displacements.end(), shift);
  this->Move();
}

//------------------------------------------------------------------------------
void ClosestPoints::Match(int iterations, int smoothing, const std::function<bool(double)>& progress)
{
  for (int n = 0; n < iterations && progress(static_cast<double>(n) / iterations); ++n)
  {
    this->Look();
    for (int pass = 0; pass < smoothing * (iterations - n); ++pass)
    {
      this->Smooth();
    }
    this->Move();
  }
}

//------------------------------------------------------------------------------
double ClosestPoints::GetDistance()
{
  const std::vector<Foot> feet = FeetOf(this->Moved->GetPoints(), this->After);
  double sum = 0.0;
  for (std::size_t n = 0; n < feet.size(); ++n)
  {
    double place[3];
    this->Moved->GetPoint(static_cast<vtkIdType>(n), place);
    sum += std::sqrt(vtkMath::Distance2BetweenPoints(place, feet[n].Place.data()));
  }
  return feet.empty() ? 0.0 : sum / static_cast<double>(feet.size());
}

//------------------------------------------------------------------------------
void ClosestPoints::Look()
{
  const std::vector<Foot> there = FeetOf(this->Moved->GetPoints(), this->After);
  const std::vector<Foot> back = FeetOf(this->After->GetPoints(), this->Moved);
  // For each point: the weighted sum of the targets from the second surface, and the sum of the weights.
  std::vector<std::array<double, 4>> asked(this->Displacements.size());
  for (std::size_t n = 0; n < back.size(); ++n)
  {
    double goal[3];
    this->After->GetPoint(static_cast<vtkIdType>(n), goal);
    for (int c = 0; c < 3; ++c)
    {
      double corner[3];
      this->Before->GetPoint(back[n].Corners[c], corner);
      vtkMath::MultiplyScalar(corner, back[n].Weights[c]);
      vtkMath::Subtract(goal, corner, goal);
    }
    for (int c = 0; c < 3; ++c)
    {
      const double weight = back[n].Weights[c];
      std::array<double, 4>& sum = asked[static_cast<std::size_t>(back[n].Corners[c])];
      sum[3] += weight;
      for (int a = 0; a < 3; ++a)
      {
        sum[a] += weight * goal[a];
      }
    }
  }
  for (std::size_t n = 0; n < this->Displacements.size(); ++n)
  {
    double rest[3];
    this->Before->GetPoint(static_cast<vtkIdType>(n), rest);
    for (int a = 0; a < 3; ++a)
    {
      const double own = there[n].Place[a] - rest[a];
      this->Displacements[n][a] = asked[n][3] > 1e-6 ? 0.5 * (own + asked[n][a] / asked[n][3]) : own;
    }
  }
}

//------------------------------------------------------------------------------
void ClosestPoints::Smooth()
{
  const std::vector<Vector> old = this->Displacements;
  vtkSMPTools::For(0, static_cast<vtkIdType>(old.size()),
    [&](vtkIdType begin, vtkIdType end)
    {
      for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n)
      {
        const vtkIdType first = this->FirstNeighbour[n];
        const vtkIdType count = this->FirstNeighbour[n + 1] - first;
        for (int a = 0; a < 3 && count > 0; ++a)
        {
          double sum = 0.0;
          for (vtkIdType k = first; k < first + count; ++k)
          {
            sum += old[static_cast<std::size_t>(this->Neighbours[static_cast<std::size_t>(k)])][a];
          }
          this->Displacements[n][a] = 0.5 * (old[n][a] + sum / static_cast<double>(count));
        }
      }
    });
}

//------------------------------------------------------------------------------
void ClosestPoints::Move()
{
  vtkPoints* points = this->Moved->GetPoints();
  for (std::size_t n = 0; n < this->Displacements.size(); ++n)
  {
    double place[3];
    this->Before->GetPoint(static_cast<vtkIdType>(n), place);
    vtkMath::Add(place, this->Displacements[n].data(), place);
    points->SetPoint(static_cast<vtkIdType>(n), place);
  }
  points->Modified();
  this->Moved->Modified();
}

}
