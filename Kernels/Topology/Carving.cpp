#include "Carving.h"

#include "Error.h"
#include "Measurement.h"
#include "Words.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace chainmail
{

namespace
{

constexpr std::int64_t voxel = static_cast<std::int64_t>(unitsPerVoxel);

/// Gives for every point the first point at the same place.
std::vector<int> merged(const std::vector<Fixed3>& points)
{
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(
    order.begin(), order.end(), [&](int a, int b) { return points[a] != points[b] ? points[a] < points[b] : a < b; });
  std::vector<int> first(points.size());
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    const bool same = n > 0 && points[order[n]] == points[order[n - 1]];
    first[order[n]] = same ? first[order[n - 1]] : order[n];
  }
  return first;
}

void checkClosed(const Surface& surface, const std::vector<Fixed3>& points)
{
  const std::vector<int> first = merged(points);
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const std::array<int, 3>& ids : surface.triangles)
  {
    for (int e = 0; e < 3; ++e)
    {
      const int a = first[ids[e]];
      const int b = first[ids[(e + 1) % 3]];
      if (a != b)
      {
        edges.push_back({ std::min(a, b), std::max(a, b) });
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  std::array<int, 2> example{};
  for (std::size_t n = 0; n < edges.size();)
  {
    std::size_t end = n;
    while (end < edges.size() && edges[end] == edges[n])
    {
      ++end;
    }
    if ((end - n) % 2 != 0)
    {
      example = open == 0 ? edges[n] : example;
      ++open;
    }
    n = end;
  }
  if (open == 0)
  {
    return;
  }
  Vector3 middle;
  for (int a = 0; a < 3; ++a)
  {
    middle[a] = 0.5 * (surface.points[example[0]][a] + surface.points[example[1]][a]);
  }
  throw InputError("The surface to carve with is not closed, so it has no inside: " + std::to_string(open) +
                   " of its " + "edges have no second triangle, one of them near " + written(middle) +
                   " mm along the image's axes. Fill its holes; merge points that are meant to be one but lie apart " +
                   "(Clean to Grid); or cut with it instead.");
}

/// The inside of a closed surface. Its triangles are sorted into columns along x, so that a ray along x meets few of
/// them.
class Solid
{
public:
  Solid(const ClosedSurface& surface, const Fixed3& low, const Fixed3& high);

  /// The part of the box [low, high] that the surface reaches.
  const Fixed3& low() const { return this->low_; }
  const Fixed3& high() const { return this->high_; }
  bool empty() const { return this->low_[0] > this->high_[0] || this->triangles_.empty(); }

  /// Whether a place [voxels] is inside.
  bool contains(const Vector3& place) const;

  /// The same for a row of `count` places from `first` on, one voxel apart along x; their y and z must lie within
  /// [low(), high()].
  void row(const Fixed3& first, int count, char* inside) const;

private:
  /// Calls f(column) for every column in which a ray may meet the triangle.
  template <typename F> void forColumns(const ExactTriangle& triangle, F&& f) const;

  /// Index of the column at a y (axis 1) or z (axis 2). It may lie outside the columns that there are.
  std::int64_t columnOf(double at, int axis) const
  {
    return static_cast<std::int64_t>(
      std::floor((at - static_cast<double>(this->low_[axis])) / static_cast<double>(this->width_[axis])));
  }

  Fixed3 low_;
  Fixed3 high_;
  Fixed3 width_;  ///< of one column
  Fixed3 counts_; ///< number of columns
  std::vector<ExactTriangle> triangles_;
  std::vector<std::uint32_t> ends_; ///< where each column's triangles begin in inColumn_
  std::vector<std::uint32_t> inColumn_;
};

Solid::Solid(const ClosedSurface& surface, const Fixed3& low, const Fixed3& high)
{
  constexpr std::int64_t none = std::int64_t(1) << 62;
  Fixed3 first{ none, none, none };
  Fixed3 last{ -none, -none, -none };
  for (const std::array<int, 3>& ids : surface.triangles)
  {
    const ExactTriangle triangle({ surface.points[ids[0]], surface.points[ids[1]], surface.points[ids[2]] });
    for (const Fixed3& corner : triangle.corner)
    {
      for (int a = 0; a < 3; ++a)
      {
        first[a] = std::min(first[a], corner[a]);
        last[a] = std::max(last[a], corner[a]);
      }
    }
    // A ray along x meets no triangle that is parallel to it, not even when all tissue is shifted (ExactGeometry.h).
    if (triangle.normal[0] != 0)
    {
      this->triangles_.push_back(triangle);
    }
  }
  constexpr std::int64_t mostColumns = 1024;
  for (int a = 0; a < 3; ++a)
  {
    this->low_[a] = std::max(low[a], first[a]);
    this->high_[a] = std::min(high[a], last[a]);
    if (this->low_[a] > this->high_[a])
    {
      this->triangles_.clear();
      return;
    }
    const std::int64_t extent = this->high_[a] - this->low_[a] + 1;
    this->width_[a] = std::max(voxel, (extent + mostColumns - 1) / mostColumns);
    this->counts_[a] = (extent + this->width_[a] - 1) / this->width_[a];
  }

  this->ends_.assign(static_cast<std::size_t>(this->counts_[1] * this->counts_[2]) + 1, 0);
  for (const ExactTriangle& triangle : this->triangles_)
  {
    this->forColumns(triangle, [&](std::size_t column) { ++this->ends_[column]; });
  }
  std::partial_sum(this->ends_.begin(), this->ends_.end(), this->ends_.begin());
  this->inColumn_.resize(this->ends_.back());
  // Filling from behind turns the ends into begins.
  for (std::size_t n = 0; n < this->triangles_.size(); ++n)
  {
    this->forColumns(this->triangles_[n],
      [&](std::size_t column) { this->inColumn_[--this->ends_[column]] = static_cast<std::uint32_t>(n); });
  }
}

template <typename F> void Solid::forColumns(const ExactTriangle& triangle, F&& f) const
{
  // Double is rounded, so each range is one unit wider than the exact one on every side.
  const auto range = std::minmax({ triangle.corner[0][2], triangle.corner[1][2], triangle.corner[2][2] });
  const std::int64_t firstZ = std::max<std::int64_t>(this->columnOf(static_cast<double>(range.first) - 1.0, 2), 0);
  const std::int64_t lastZ = std::min(this->columnOf(static_cast<double>(range.second) + 1.0, 2), this->counts_[2] - 1);
  for (std::int64_t z = firstZ; z <= lastZ; ++z)
  {
    const double from = static_cast<double>(this->low_[2] + z * this->width_[2]) - 1.0;
    const double to = from + static_cast<double>(this->width_[2]) + 2.0;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (int e = 0; e < 3; ++e)
    {
      const double ay = static_cast<double>(triangle.corner[e][1]);
      const double az = static_cast<double>(triangle.corner[e][2]);
      const double by = static_cast<double>(triangle.corner[(e + 1) % 3][1]);
      const double bz = static_cast<double>(triangle.corner[(e + 1) % 3][2]);
      if (std::max(az, bz) < from || std::min(az, bz) > to)
      {
        continue;
      }
      for (const double limit : { from, to })
      {
        const double t = az == bz ? (limit == from ? 0.0 : 1.0) : std::clamp((limit - az) / (bz - az), 0.0, 1.0);
        lowest = std::min(lowest, ay + t * (by - ay));
        highest = std::max(highest, ay + t * (by - ay));
      }
    }
    const std::int64_t firstY = std::max<std::int64_t>(this->columnOf(lowest - 1.0, 1), 0);
    const std::int64_t lastY = std::min(this->columnOf(highest + 1.0, 1), this->counts_[1] - 1);
    for (std::int64_t y = firstY; lowest <= highest && y <= lastY; ++y)
    {
      f(static_cast<std::size_t>(y + this->counts_[1] * z));
    }
  }
}

/// Whether all corners are on one side of a place along an axis: a quick test that excludes most triangles of a column.
bool beside(const ExactTriangle& triangle, const Fixed3& place, int axis)
{
  const std::int64_t at = place[axis];
  const bool below = triangle.corner[0][axis] < at && triangle.corner[1][axis] < at && triangle.corner[2][axis] < at;
  const bool above = triangle.corner[0][axis] > at && triangle.corner[1][axis] > at && triangle.corner[2][axis] > at;
  return below || above;
}

bool Solid::contains(const Vector3& place) const
{
  for (int a = 0; a < 3; ++a)
  {
    // This also stops places that are too far away to be rounded to an integer.
    const double rounded = std::round(place[a] * unitsPerVoxel);
    if (!(rounded >= static_cast<double>(this->low_[a]) && rounded <= static_cast<double>(this->high_[a])))
    {
      return false;
    }
  }
  char result = 0;
  this->row(fixed(place), 1, &result);
  return result != 0;
}

void Solid::row(const Fixed3& first, int count, char* inside) const
{
  std::fill(inside, inside + count, 0);
  const std::size_t column = static_cast<std::size_t>(
    (first[1] - this->low_[1]) / this->width_[1] + this->counts_[1] * ((first[2] - this->low_[2]) / this->width_[2]));
  for (std::uint32_t n = this->ends_[column]; n < this->ends_[column + 1]; ++n)
  {
    const ExactTriangle& triangle = this->triangles_[this->inColumn_[n]];
    if (beside(triangle, first, 1) || beside(triangle, first, 2) || !triangle.meetsLine(first, { 1, 0, 0 }))
    {
      continue;
    }
    // A place has the triangle ahead of it if it is not on the same side as the far end of the row. Such places come
    // first.
    const int beyond = triangle.normal[0] > 0 ? 1 : -1;
    int before = 0;
    for (int after = count; before < after;)
    {
      const int middle = (before + after) / 2;
      const bool ahead = triangle.side({ first[0] + middle * voxel, first[1], first[2] }) != beyond;
      before = ahead ? middle + 1 : before;
      after = ahead ? after : middle;
    }
    for (int i = 0; i < before; ++i)
    {
      inside[i] = inside[i] == 0;
    }
  }
}

/// The first and last whole voxel of [low, high] that lie within [least, most]; first > last where there is none.
std::pair<int, int> wholeVoxels(std::int64_t low, std::int64_t high, int least, int most)
{
  const auto floorOf = [](std::int64_t n) { return n >= 0 ? n / voxel : -((voxel - 1 - n) / voxel); };
  const std::int64_t first = std::max<std::int64_t>(-floorOf(-low), least);
  const std::int64_t last = std::min<std::int64_t>(floorOf(high), most);
  return first > last ? std::make_pair(least, least - 1)
                      : std::make_pair(static_cast<int>(first), static_cast<int>(last));
}

/// Adds the elements inside, among the voxels `first` to `last` of a brick at rest.
void atRest(
  const Bricks& bricks, const Solid& solid, const Index3& first, const Index3& last, std::vector<std::size_t>& found)
{
  const Grid& grid = bricks.model().grid();
  const std::size_t axes = bricks.model().axes();
  const int count = last[0] - first[0] + 1;
  std::vector<char> inside(count);
  std::vector<float> row(axes * count);
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      solid.row({ first[0] * voxel, j * voxel, k * voxel }, count, inside.data());
      if (std::find(inside.begin(), inside.end(), 1) == inside.end())
      {
        continue;
      }
      bricks.row(first[0], j, k, count, row.data());
      for (int i = 0; i < count; ++i)
      {
        if (inside[i] != 0 && !std::isinf(row[axes * i]))
        {
          found.push_back(grid.at(first[0] + i, j, k));
        }
      }
    }
  }
}

/// Adds the elements inside, among the voxels `first` to `last` of a displaced brick; `u` is what Bricks::readSlot()
/// gave.
void displaced(const Bricks& bricks, const Solid& solid, const Index3& first, const Index3& last,
  const std::vector<float>& u, std::vector<std::size_t>& found)
{
  const Grid& grid = bricks.model().grid();
  const std::size_t axes = bricks.model().axes();
  const int count = last[0] - first[0] + 1;
  std::vector<float> row(axes * count);
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      bricks.row(first[0], j, k, count, row.data());
      for (int i = 0; i < count; ++i)
      {
        const Vector3 place = bricks.place(first[0] + i, j, k, u);
        if (!std::isinf(row[axes * i]) && solid.contains(place))
        {
          found.push_back(grid.at(first[0] + i, j, k));
        }
      }
    }
  }
}

/// A box that contains the current places of all elements [voxels].
void reach(const Grid& grid, const std::vector<BrickFigures>& figures, Vector3& first, Vector3& last)
{
  first = {};
  last = { grid.size[0] - 1.0, grid.size[1] - 1.0, grid.size[2] - 1.0 };
  for (const BrickFigures& brick : figures)
  {
    for (int a = 0; a < 3; ++a)
    {
      first[a] = std::min(first[a], static_cast<double>(brick.low[a]));
      last[a] = std::max(last[a], grid.size[a] - 1.0 + brick.high[a]);
    }
  }
  // No surface reaches beyond this, and integers do.
  for (int a = 0; a < 3; ++a)
  {
    first[a] = std::max(first[a], -1e8);
    last[a] = std::min(last[a], 1e8);
  }
}

/// The last voxel of the brick that begins at `origin`.
Index3 lastOf(const Bricks& bricks, const Index3& origin)
{
  const Index3 size = bricks.size();
  const Grid& grid = bricks.model().grid();
  return { std::min(origin[0] + size[0], grid.size[0]) - 1, std::min(origin[1] + size[1], grid.size[1]) - 1,
    std::min(origin[2] + size[2], grid.size[2]) - 1 };
}

bool isDisplaced(const std::vector<BrickFigures>& figures, int slot)
{
  return slot > 0 && figures[slot - 1].displaced > 0.0f;
}

/// Adds the elements of all displaced bricks that are inside.
void allDisplaced(
  Bricks& bricks, const Solid& solid, const std::vector<BrickFigures>& figures, std::vector<std::size_t>& found)
{
  std::vector<float> values;
  for (int slot = 1; slot < bricks.slots(); ++slot)
  {
    const Index3 origin = bricks.origin(bricks.brick(slot));
    const Index3 end = lastOf(bricks, origin);
    bool apart = !isDisplaced(figures, slot);
    for (int a = 0; a < 3; ++a)
    {
      const BrickFigures& brick = figures[slot - 1];
      // One voxel more covers the rounding of the figures.
      apart = apart || (origin[a] + double(brick.low[a]) - 1.0) * unitsPerVoxel > double(solid.high()[a]) ||
              (end[a] + double(brick.high[a]) + 1.0) * unitsPerVoxel < double(solid.low()[a]);
    }
    if (!apart)
    {
      bricks.readSlot(slot, values);
      displaced(bricks, solid, origin, end, values, found);
    }
  }
}

/// Adds the elements of all other bricks that are inside.
void allAtRest(
  const Bricks& bricks, const Solid& solid, const std::vector<BrickFigures>& figures, std::vector<std::size_t>& found)
{
  const Index3 size = bricks.size();
  std::array<std::pair<int, int>, 3> range;
  for (int a = 0; a < 3; ++a)
  {
    range[a] = wholeVoxels(solid.low()[a], solid.high()[a], 0, bricks.model().grid().size[a] - 1);
    if (range[a].first > range[a].second)
    {
      return;
    }
  }
  for (int k = range[2].first / size[2]; k * size[2] <= range[2].second; ++k)
  {
    for (int j = range[1].first / size[1]; j * size[1] <= range[1].second; ++j)
    {
      for (int i = range[0].first / size[0]; i * size[0] <= range[0].second; ++i)
      {
        Index3 from{ i * size[0], j * size[1], k * size[2] };
        if (isDisplaced(figures, bricks.slot(bricks.brickAt(from[0], from[1], from[2]))))
        {
          continue;
        }
        Index3 to = lastOf(bricks, from);
        for (int a = 0; a < 3; ++a)
        {
          from[a] = std::max(from[a], range[a].first);
          to[a] = std::min(to[a], range[a].second);
        }
        atRest(bricks, solid, from, to, found);
      }
    }
  }
}

}

ClosedSurface::ClosedSurface(const Surface& surface, const Grid& grid)
  : points(fixedPoints(surface, grid, "carve"))
  , triangles(surface.triangles)
{
  checkClosed(surface, this->points);
}

std::vector<std::size_t> carveElements(Bricks& bricks, const ClosedSurface& surface)
{
  // Elements are at rest unless the figures of their brick say how far they may be displaced.
  const std::vector<BrickFigures> figures = measureBricks(bricks);
  Vector3 first{};
  Vector3 last{};
  reach(bricks.model().grid(), figures, first, last);
  const Solid solid(surface, fixed(first), fixed(last));
  if (solid.empty())
  {
    return {};
  }
  std::vector<std::size_t> found;
  allDisplaced(bricks, solid, figures, found);
  allAtRest(bricks, solid, figures, found);
  std::sort(found.begin(), found.end());
  bricks.removeElements(found);
  return found;
}

}
