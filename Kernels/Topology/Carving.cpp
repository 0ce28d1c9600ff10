#include "Carving.h"

#include "Measurement.h"
#include "Rays.h"
#include "SurfaceDistance.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

constexpr std::int64_t voxel = static_cast<std::int64_t>(unitsPerVoxel);

/// The first and last whole voxel of [low, high] (in units of Fixed3) that lie within [least, most]; first > last where
/// there is none.
std::pair<int, int> wholeVoxels(std::int64_t low, std::int64_t high, int least, int most)
{
  const auto floorOf = [](std::int64_t n) { return n >= 0 ? n / voxel : -((voxel - 1 - n) / voxel); };
  const std::int64_t first = std::max<std::int64_t>(-floorOf(-low), least);
  const std::int64_t last = std::min<std::int64_t>(floorOf(high), most);
  return first > last ? std::make_pair(least, least - 1)
                      : std::make_pair(static_cast<int>(first), static_cast<int>(last));
}

/// Adds the elements inside the solid, among the voxels `first` to `last` of a brick at rest.
void atRest(
  const Bricks& bricks, const Rays& solid, const Index3& first, const Index3& last, std::vector<std::size_t>& found)
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

/// Adds the elements inside the solid, among the voxels `first` to `last` of a displaced brick. `u` is the result of
/// Bricks::readSlot().
void displaced(const Bricks& bricks, const Rays& solid, const Index3& first, const Index3& last,
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

/// A box that contains the current positions of all elements [voxels].
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
  // Clamps to a range that no surface exceeds and that integers can hold.
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

/// Whether all elements of a displaced brick are farther from the solid's box than `margin` voxels.
bool isApart(const Bricks& bricks, const Rays& solid, const BrickFigures& figures, int slot, double margin)
{
  const Index3 origin = bricks.origin(bricks.brick(slot));
  const Index3 end = lastOf(bricks, origin);
  bool apart = false;
  for (int a = 0; a < 3; ++a)
  {
    apart = apart || (origin[a] + double(figures.low[a]) - margin) * unitsPerVoxel > double(solid.high()[a]) ||
            (end[a] + double(figures.high[a]) + margin) * unitsPerVoxel < double(solid.low()[a]);
  }
  return apart;
}

/// The displaced bricks that may have grid points near the surface.
std::vector<int> nearbyBricks(const Bricks& bricks, const Rays& solid, const std::vector<BrickFigures>& figures)
{
  std::vector<int> found;
  for (int slot = 1; slot < bricks.slots(); ++slot)
  {
    if (isDisplaced(figures, slot) && !isApart(bricks, solid, figures[slot - 1], slot, CutDistances::farthest + 1.0))
    {
      found.push_back(slot);
    }
  }
  return found;
}

/// Adds the elements of all displaced bricks that are inside the solid.
void allDisplaced(
  Bricks& bricks, const Rays& solid, const std::vector<BrickFigures>& figures, std::vector<std::size_t>& found)
{
  std::vector<float> values;
  for (int slot = 1; slot < bricks.slots(); ++slot)
  {
    // The margin of one voxel covers the rounding of the figures.
    if (isDisplaced(figures, slot) && !isApart(bricks, solid, figures[slot - 1], slot, 1.0))
    {
      const Index3 origin = bricks.origin(bricks.brick(slot));
      bricks.readSlot(slot, values);
      displaced(bricks, solid, origin, lastOf(bricks, origin), values, found);
    }
  }
}

/// Adds the elements of all other bricks that are inside the solid.
void allAtRest(
  const Bricks& bricks, const Rays& solid, const std::vector<BrickFigures>& figures, std::vector<std::size_t>& found)
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

std::vector<std::size_t> carveElements(Bricks& bricks, const ClosedSurface& surface)
{
  // Elements are at rest, except in bricks whose figures give bounds of displacements.
  const std::vector<BrickFigures> figures = measureBricks(bricks);
  Vector3 first{};
  Vector3 last{};
  reach(bricks.model().grid(), figures, first, last);
  const Rays solid(surface, fixed(first), fixed(last));
  if (solid.empty())
  {
    return {};
  }
  std::vector<std::size_t> found;
  allDisplaced(bricks, solid, figures, found);
  allAtRest(bricks, solid, figures, found);
  std::sort(found.begin(), found.end());
  if (!found.empty())
  {
    // Before the removal, because the distances depend on the current positions of the removed elements.
    addSurfaceDistances(
      bricks, Places::of(bricks, nearbyBricks(bricks, solid, figures)), surface.points, surface.triangles);
  }
  bricks.removeElements(found);
  return found;
}

}
