#include "SurfaceDistance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

Vector3 minus(const Vector3& a, const Vector3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

double dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The normalised cross product.
Vector3 normalOf(const Vector3& a, const Vector3& b)
{
  const Vector3 n{ a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
  const double length = std::sqrt(dot(n, n));
  return { n[0] / length, n[1] / length, n[2] / length };
}

/// A triangle in double precision [voxels].
struct Triangle
{
  explicit Triangle(const std::array<Fixed3, 3>& corners)
    : exact(corners)
  {
    for (int n = 0; n < 3; ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        this->corner[n][a] = static_cast<double>(corners[n][a]) / unitsPerVoxel;
      }
    }
    this->normal = normalOf(minus(this->corner[1], this->corner[0]), minus(this->corner[2], this->corner[0]));
    for (int n = 0; n < 3; ++n)
    {
      this->edge[n] = minus(this->corner[(n + 1) % 3], this->corner[n]);
      this->outward[n] = normalOf(this->edge[n], this->normal);
    }
  }

  /// The signed distance from the triangle's plane.
  double signedDistance(const Vector3& place) const { return dot(this->normal, minus(place, this->corner[0])); }

  /// The squared distance from the triangle itself.
  double squaredDistance(const Vector3& place) const
  {
    const double height = this->signedDistance(place);
    double nearest = std::numeric_limits<double>::infinity();
    bool isOver = true;
    for (int n = 0; n < 3; ++n)
    {
      const Vector3 from = minus(place, this->corner[n]);
      isOver = isOver && dot(this->outward[n], from) <= 0.0;
      const double share = dot(from, this->edge[n]) / dot(this->edge[n], this->edge[n]);
      const double along = std::min(1.0, std::max(0.0, share));
      const Vector3 off{ from[0] - along * this->edge[n][0], from[1] - along * this->edge[n][1],
        from[2] - along * this->edge[n][2] };
      nearest = std::min(nearest, dot(off, off));
    }
    return isOver ? height * height : nearest;
  }

  ExactTriangle exact;
  std::array<Vector3, 3> corner;
  std::array<Vector3, 3> edge;
  Vector3 normal;
  std::array<Vector3, 3> outward;
};

/// Calls f(first voxel) for the bricks that meet a box of voxels.
template <typename F> void forBricks(const Index3& first, const Index3& last, const Index3& size, const F& f)
{
  for (int k = first[2] / size[2]; k * size[2] <= last[2]; ++k)
  {
    for (int j = first[1] / size[1]; j * size[1] <= last[1]; ++j)
    {
      for (int i = first[0] / size[0]; i * size[0] <= last[0]; ++i)
      {
        f(Index3{ i * size[0], j * size[1], k * size[2] });
      }
    }
  }
}

Index3 whole(const Vector3& v)
{
  return { static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]) };
}

/// The current position of a grid point. Air has the mean displacement of the elements among its face neighbours, or
/// none without such elements.
Vector3 placeOf(const Bricks& bricks, const Places& places, const Index3& at)
{
  if (!places.anyMoved() || bricks.isElement(at))
  {
    return places.at(at[0], at[1], at[2]);
  }
  Vector3 sum{};
  int count = 0;
  for (int d = 0; d < 6; ++d)
  {
    Index3 next = at;
    next[d / 2] += d % 2 == 0 ? -1 : 1;
    if (bricks.model().grid().contains(next[0], next[1], next[2]) && bricks.isElement(next))
    {
      const Vector3 place = places.at(next[0], next[1], next[2]);
      for (int a = 0; a < 3; ++a)
      {
        sum[a] += place[a] - next[a];
      }
      ++count;
    }
  }
  Vector3 place{ double(at[0]), double(at[1]), double(at[2]) };
  for (int a = 0; a < 3 && count > 0; ++a)
  {
    place[a] += sum[a] / count;
  }
  return place;
}

}

void addSurfaceDistances(Bricks& bricks, const Places& places, const std::vector<Fixed3>& points,
  const std::vector<std::array<int, 3>>& triangles)
{
  constexpr double farthest = CutDistances::farthest;
  constexpr double certain = 1e-3; // exceeds the rounding of positions, so beyond it the sign equals the exact one
  const Grid& grid = bricks.model().grid();
  const Index3 size = bricks.size();
  const Places::Bounds widest = places.widest();
  for (const std::array<int, 3>& ids : triangles)
  {
    const Triangle triangle({ points[ids[0]], points[ids[1]], points[ids[2]] });
    if (triangle.exact.degenerate())
    {
      continue;
    }
    const auto low = [&](int a, const Places::Bounds& moved)
    {
      const double least = std::min({ triangle.corner[0][a], triangle.corner[1][a], triangle.corner[2][a] });
      return std::ceil(std::max(0.0, least - farthest - moved.high[a]));
    };
    const auto high = [&](int a, const Places::Bounds& moved)
    {
      const double most = std::max({ triangle.corner[0][a], triangle.corner[1][a], triangle.corner[2][a] });
      return std::floor(std::min(grid.size[a] - 1.0, most + farthest - moved.low[a]));
    };
    const auto isEmpty = [](const Vector3& first, const Vector3& last)
    { return first[0] > last[0] || first[1] > last[1] || first[2] > last[2]; };
    const Vector3 first{ low(0, widest), low(1, widest), low(2, widest) };
    const Vector3 last{ high(0, widest), high(1, widest), high(2, widest) };
    if (isEmpty(first, last))
    {
      continue;
    }
    forBricks(whole(first), whole(last), size,
      [&](const Index3& origin)
      {
        const int brick = bricks.brickAt(origin[0], origin[1], origin[2]);
        const Places::Bounds moved = places.bounds(brick);
        double least = triangle.signedDistance({ double(origin[0]), double(origin[1]), double(origin[2]) });
        double most = least;
        Vector3 from;
        Vector3 to;
        for (int a = 0; a < 3; ++a)
        {
          from[a] = std::max<double>(origin[a], low(a, moved));
          to[a] = std::min<double>(origin[a] + size[a] - 1, high(a, moved));
          const double range[4] = { triangle.normal[a] * moved.low[a], triangle.normal[a] * moved.high[a],
            triangle.normal[a] * (size[a] - 1 + moved.low[a]), triangle.normal[a] * (size[a] - 1 + moved.high[a]) };
          least += *std::min_element(range, range + 4);
          most += *std::max_element(range, range + 4);
        }
        if (isEmpty(from, to) || least > farthest || most < -farthest)
        {
          return;
        }
        CutDistances::Brick& distances = bricks.cutDistances().at(brick);
        const Index3 begin = whole(from);
        const Index3 end = whole(to);
        Index3 at;
        for (at[2] = begin[2]; at[2] <= end[2]; ++at[2])
        {
          for (at[1] = begin[1]; at[1] <= end[1]; ++at[1])
          {
            for (at[0] = begin[0]; at[0] <= end[0]; ++at[0])
            {
              const Vector3 place = placeOf(bricks, places, at);
              const double distance = triangle.signedDistance(place);
              const double squared = triangle.squaredDistance(place);
              if (squared <= farthest * farthest)
              {
                const bool isSure = std::fabs(distance) > certain;
                const int side = isSure ? 1 : triangle.exact.side(fixed(place));
                distances.add(bricks.local(at[0], at[1], at[2]), squared,
                  isSure ? distance : side * std::max(std::fabs(distance), 1e-9));
              }
            }
          }
        }
      });
  }
}

}
