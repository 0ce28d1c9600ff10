#include "Cutting.h"

#include "ExactGeometry.h"
#include "Places.h"
#include "SurfaceDistance.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// A triangle with a filter in double precision, which decides most links. Only the others need the exact predicate.
struct Triangle : ExactTriangle
{
  Vector3 low; ///< bounding box [voxels]
  Vector3 high;
  Vector3 gradient; ///< of roughSide(), per voxel
  double offset;
  double margin; ///< of roughSide(): bound on its error by rounding

  explicit Triangle(const std::array<Fixed3, 3>& corners)
    : ExactTriangle(corners)
  {
    double length = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const auto range = std::minmax({ corners[0][a], corners[1][a], corners[2][a] });
      this->low[a] = static_cast<double>(range.first) / unitsPerVoxel;
      this->high[a] = static_cast<double>(range.second) / unitsPerVoxel;
      length = std::max(length, std::fabs(static_cast<double>(this->normal[a])));
    }
    this->offset = 0.0;
    double magnitude = 1.0;
    for (int a = 0; a < 3 && length > 0.0; ++a)
    {
      this->gradient[a] = static_cast<double>(this->normal[a]) / length;
      const double origin = static_cast<double>(corners[0][a]) / unitsPerVoxel;
      this->offset -= this->gradient[a] * origin;
      magnitude += std::fabs(origin);
    }
    // Rounding moves a position by at most 1/8192 voxel along each axis; the rest allows for the arithmetic in double.
    this->margin = 1e-3 + 1e-12 * magnitude;
  }

  /// About the signed distance of a position from the plane, times |gradient| (1 to sqrt(3)). Beyond the margin the
  /// sign is certain.
  double roughSide(const Vector3& voxel) const
  {
    return this->gradient[0] * voxel[0] + this->gradient[1] * voxel[1] + this->gradient[2] * voxel[2] + this->offset;
  }
};

/// The elements whose links to the next ones may cross a triangle, from bounds on their displacement.
struct Range
{
  Index3 first;
  Index3 last;

  Range(const Triangle& triangle, const Places::Bounds& moved, const Index3& floor, const Index3& ceiling)
  {
    for (int a = 0; a < 3; ++a)
    {
      const double low = std::max(triangle.low[a] - moved.high[a] - 1.01, static_cast<double>(floor[a]));
      const double high = std::min(triangle.high[a] - moved.low[a] + 0.01, static_cast<double>(ceiling[a]));
      this->first[a] = low > high ? ceiling[a] + 1 : static_cast<int>(std::floor(low));
      this->first[a] = std::max(this->first[a], floor[a]);
      this->last[a] = low > high ? ceiling[a] : static_cast<int>(std::floor(high));
    }
  }
  bool empty() const
  {
    return this->first[0] > this->last[0] || this->first[1] > this->last[1] || this->first[2] > this->last[2];
  }
};

/// Whether the plane of the triangle certainly misses all links of a brick.
bool misses(const Triangle& triangle, const Range& range, const Places::Bounds& moved)
{
  double least = triangle.offset;
  double most = triangle.offset;
  for (int a = 0; a < 3; ++a)
  {
    const double g = triangle.gradient[a];
    const double low = g * (range.first[a] + moved.low[a]);
    const double high = g * (range.last[a] + 1.0 + moved.high[a]);
    least += std::min(low, high);
    most += std::max(low, high);
  }
  return least > triangle.margin || most < -triangle.margin;
}

}

std::size_t cutLinks(Bricks& bricks, const Surface& surface)
{
  const Grid& grid = bricks.model().grid();
  const std::vector<Fixed3> points = fixedPoints(surface, grid, "cut");
  const Places places(bricks);
  const Places::Bounds widest = places.widest();
  const Index3 last{ grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1 };
  const Index3 size = bricks.size();
  std::size_t removed = 0;
  for (const std::array<int, 3>& ids : surface.triangles)
  {
    const Triangle triangle({ points[ids[0]], points[ids[1]], points[ids[2]] });
    const Range whole(triangle, widest, { 0, 0, 0 }, last);
    if (triangle.degenerate() || whole.empty())
    {
      continue;
    }
    for (int bz = whole.first[2] / size[2]; bz <= whole.last[2] / size[2]; ++bz)
    {
      for (int by = whole.first[1] / size[1]; by <= whole.last[1] / size[1]; ++by)
      {
        for (int bx = whole.first[0] / size[0]; bx <= whole.last[0] / size[0]; ++bx)
        {
          const Index3 floor{ bx * size[0], by * size[1], bz * size[2] };
          const Index3 ceiling{ std::min(floor[0] + size[0] - 1, last[0]), std::min(floor[1] + size[1] - 1, last[1]),
            std::min(floor[2] + size[2] - 1, last[2]) };
          const Places::Bounds moved = places.bounds(bricks.brickAt(floor[0], floor[1], floor[2]));
          const Range range(triangle, moved, floor, ceiling);
          if (range.empty() || misses(triangle, range, moved))
          {
            continue;
          }
          for (int k = range.first[2]; k <= range.last[2]; ++k)
          {
            for (int j = range.first[1]; j <= range.last[1]; ++j)
            {
              for (int i = range.first[0]; i <= range.last[0]; ++i)
              {
                const Vector3 p = places.at(i, j, k);
                const double sideP = triangle.roughSide(p);
                for (int a = 0; a < 3; ++a)
                {
                  const Index3 next{ i + (a == 0), j + (a == 1), k + (a == 2) };
                  if (next[a] > last[a])
                  {
                    continue;
                  }
                  const Vector3 q = places.at(next[0], next[1], next[2]);
                  const double sideQ = triangle.roughSide(q);
                  if (std::min(sideP, sideQ) > triangle.margin || std::max(sideP, sideQ) < -triangle.margin)
                  {
                    continue;
                  }
                  if (triangle.crosses(fixed(p), fixed(q)) && bricks.isElement({ i, j, k }) && bricks.isElement(next))
                  {
                    removed += bricks.removeLink(i, j, k, 2 * a + 1);
                  }
                }
              }
            }
          }
        }
      }
    }
  }
  bricks.uploadCuts();
  addSurfaceDistances(bricks, places, points, surface.triangles);
  return removed;
}

}
