#include "BrickExtents.h"

#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

/// The distance [voxels] up to which a displaced element moves cells: the cells that it is a corner of and, because
/// border air follows tissue, those next to them.
constexpr int margin = 2;

/// Rounds down, also below zero.
int floorDiv(int n, int divisor)
{
  return n >= 0 ? n / divisor : -((divisor - 1 - n) / divisor);
}

}

OutputFrame::OutputFrame(const Grid& grid, const Index3& padding, const Index3& brickSize)
  : brickSize(brickSize)
{
  for (int a = 0; a < 3; ++a)
  {
    this->low[a] = -padding[a];
    this->high[a] = grid.size[a] - 1 + padding[a];
    this->firstBrick[a] = floorDiv(this->low[a], brickSize[a]);
    this->bricks.size[a] = floorDiv(this->high[a], brickSize[a]) - this->firstBrick[a] + 1;
  }
}

Index3 OutputFrame::origin(std::size_t n) const
{
  Index3 origin = this->bricks.indexOf(n);
  for (int a = 0; a < 3; ++a)
  {
    origin[a] = (origin[a] + this->firstBrick[a]) * this->brickSize[a];
  }
  return origin;
}

std::size_t OutputFrame::at(const Index3& origin) const
{
  return this->bricks.at(floorDiv(origin[0], this->brickSize[0]) - this->firstBrick[0],
    floorDiv(origin[1], this->brickSize[1]) - this->firstBrick[1],
    floorDiv(origin[2], this->brickSize[2]) - this->firstBrick[2]);
}

BrickBox OutputFrame::between(const Vector3& from, const Vector3& to, const Index3& least, const Index3& most) const
{
  BrickBox box;
  for (int a = 0; a < 3; ++a)
  {
    if (from[a] > most[a] || to[a] < least[a])
    {
      return {};
    }
    // Clamps before the conversion to integers, since a displacement may be far larger than any image.
    const int first = static_cast<int>(std::max<double>(from[a], least[a]));
    const int last = static_cast<int>(std::min<double>(to[a], most[a]));
    box.first[a] = floorDiv(first, this->brickSize[a]) - this->firstBrick[a];
    box.last[a] = floorDiv(last, this->brickSize[a]) - this->firstBrick[a];
  }
  return box;
}

Ranges::Ranges(const Bricks& bricks)
  : bricks_(&bricks)
  , numbers_(bricks.numbers(), 0)
  , ranges_(1)
{
}

Ranges::Ranges(const Bricks& bricks, const ChangeTracker& survey)
  : Ranges(bricks)
{
  for (std::size_t n = 0; n < survey.displaced().size(); ++n)
  {
    const BrickExtent& extent = survey.extents()[n];
    Range& range = this->of(survey.displaced()[n]);
    std::copy_n(extent.low, 3, range.low.begin());
    std::copy_n(extent.high, 3, range.high.begin());
    std::copy_n(extent.first, 3, range.first.begin());
    std::copy_n(extent.last, 3, range.last.begin());
  }
  for (const auto& [brick, bits] : bricks.links().all())
  {
    this->of(brick).cut = true;
  }
}

Ranges::Range& Ranges::of(int brick)
{
  if (this->numbers_[brick] == 0)
  {
    this->numbers_[brick] = static_cast<int>(this->ranges_.size());
    this->ranges_.emplace_back();
  }
  return this->ranges_[this->numbers_[brick]];
}

Ranges::Shown Ranges::shown(int brick, const OutputFrame& frame, bool whole, int beyond) const
{
  // Corners in air follow the elements around them, so the elements that move a cell lie at most one voxel further. A
  // deformed cell lies in the box of its displaced corners.
  constexpr int around = margin + 1;
  const Index3& grid = this->bricks_->model().grid().size;
  const Index3 size = this->bricks_->size();
  const Index3 origin = this->bricks_->origin(brick);
  const Range& own = this->ranges_[this->numbers_[brick]];
  Vector3 first;
  Vector3 last;
  Index3 low;
  Index3 high;
  for (int a = 0; a < 3; ++a)
  {
    first[a] = origin[a] + (whole ? 0.0 : own.first[a]);
    last[a] = origin[a] + (whole ? size[a] - 1.0 : own.last[a]);
    if (last[a] < first[a])
    {
      return {};
    }
    low[a] = std::max(static_cast<int>(first[a]) - around, 0) / size[a] * size[a];
    high[a] = std::min(static_cast<int>(last[a]) + around, grid[a] - 1);
  }
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::array<float, 3> least{ { infinity, infinity, infinity } };
  std::array<float, 3> most{ { -infinity, -infinity, -infinity } };
  for (int k = low[2]; k <= high[2]; k += size[2])
  {
    for (int j = low[1]; j <= high[1]; j += size[1])
    {
      for (int i = low[0]; i <= high[0]; i += size[0])
      {
        const Range& range = this->ranges_[this->numbers_[this->bricks_->brickAt(i, j, k)]];
        for (int a = 0; a < 3; ++a)
        {
          least[a] = std::min(least[a], range.low[a]);
          most[a] = std::max(most[a], range.high[a]);
        }
      }
    }
  }
  // Without displacements no cell moves. Carved elements then affect only their own voxels and those up to `beyond`.
  const bool moves = least != Range().low || most != Range().high;
  Vector3 firstReached;
  Vector3 lastReached;
  for (int a = 0; a < 3; ++a)
  {
    first[a] -= std::max(beyond, moves ? margin : 0);
    last[a] += std::max(beyond, moves ? margin : 0);
    firstReached[a] = first[a] + std::floor(least[a]);
    lastReached[a] = last[a] + std::ceil(most[a]);
  }
  return { frame.between(firstReached, lastReached, frame.low, frame.high),
    frame.between(first, last, frame.low, frame.high) };
}

BrickBox Ranges::cells(int brick, const OutputFrame& frame) const
{
  const Index3& grid = this->bricks_->model().grid().size;
  const Index3 origin = this->bricks_->origin(brick);
  const Range& own = this->ranges_[this->numbers_[brick]];
  Vector3 first;
  Vector3 last;
  for (int a = 0; a < 3; ++a)
  {
    first[a] = origin[a] + own.first[a] - margin;
    last[a] = origin[a] + own.last[a] + margin;
  }
  return frame.between(first, last, { 0, 0, 0 }, { grid[0] - 1, grid[1] - 1, grid[2] - 1 });
}

std::vector<BrickExtents> findReaches(
  const Bricks& bricks, const OutputFrame& frame, const ChangeTracker& survey, const Ranges& ranges, CutSurfaces cuts)
{
  const Index3& size = bricks.model().grid().size;
  std::vector<BrickExtents> reaches;
  for (const int brick : survey.displaced())
  {
    const BrickBox cells = ranges.cells(brick, frame);
    const Ranges::Shown shown = ranges.shown(brick, frame, false);
    if (shown.both().bricks() <= shown.reached.bricks() + shown.left.bricks())
    {
      reaches.push_back({ cells, shown.both() });
    }
    else // what lies between them is not affected
    {
      reaches.push_back({ cells, shown.reached });
      reaches.push_back({ cells, shown.left });
    }
  }
  for (const int brick : bricks.links().carvedBricks())
  {
    // A carved element empties its voxel. With smooth cut surfaces the voxels around it also change in part.
    const int beyond = cuts == CutSurfaces::Smooth ? reachOfCarves : 0;
    const Index3 origin = bricks.origin(brick);
    Vector3 first;
    Vector3 last;
    for (int a = 0; a < 3; ++a)
    {
      first[a] = origin[a] - beyond;
      last[a] = origin[a] + bricks.size()[a] - 1 + beyond;
    }
    const BrickBox own = frame.between(first, last, { 0, 0, 0 }, { size[0] - 1, size[1] - 1, size[2] - 1 });
    reaches.push_back({ own, own });
  }
  return reaches;
}

}
