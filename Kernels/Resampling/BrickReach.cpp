#include "BrickReach.h"

#include <cmath>

namespace chainmail
{

namespace
{

/// How far [voxels] an element moves the tissue around it: the cells that it is a corner of and, since the border
/// follows tissue, those next to them.
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

BrickBox OutputFrame::between(
  const Vector3& from, const Vector3& to, const Index3& least, const Index3& most) const
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

Ranges::Ranges(const Bricks& bricks, const Survey& survey)
  : Ranges(bricks)
{
  for (std::size_t n = 0; n < survey.displaced().size(); ++n)
  {
    const BrickExtent& extent = survey.extents()[n];
    Range range;
    std::copy_n(extent.low, 3, range.low.begin());
    std::copy_n(extent.high, 3, range.high.begin());
    this->numbers_[survey.displaced()[n]] = static_cast<int>(this->ranges_.size());
    this->ranges_.push_back(range);
  }
}

void Ranges::widen(int brick, Vector3& first, Vector3& last) const
{
  // The air of a cell follows the elements around it, so all that moves the cell lies one voxel further at most. A cell
  // lies between the places of its corners.
  constexpr int around = margin + 1;
  const Index3& whole = this->bricks_->model().grid().size;
  const Index3 size = this->bricks_->size();
  const Index3 origin = this->bricks_->origin(brick);
  Index3 low;
  Index3 high;
  for (int a = 0; a < 3; ++a)
  {
    low[a] = std::max(origin[a] - around, 0) / size[a] * size[a];
    high[a] = std::min(origin[a] + size[a] - 1 + around, whole[a] - 1);
  }
  Range all;
  for (int k = low[2]; k <= high[2]; k += size[2])
  {
    for (int j = low[1]; j <= high[1]; j += size[1])
    {
      for (int i = low[0]; i <= high[0]; i += size[0])
      {
        const Range& range = this->ranges_[this->numbers_[this->bricks_->brickAt(i, j, k)]];
        for (int a = 0; a < 3; ++a)
        {
          all.low[a] = std::min(all.low[a], range.low[a]);
          all.high[a] = std::max(all.high[a], range.high[a]);
        }
      }
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    first[a] += std::floor(all.low[a]) - margin;
    last[a] += std::ceil(all.high[a]) + margin;
  }
}

std::vector<BrickReach> findReaches(
  const Bricks& bricks, const OutputFrame& frame, const Survey& survey, const Ranges& ranges)
{
  const Index3& whole = bricks.model().grid().size;
  const Index3 size = bricks.size();
  std::vector<BrickReach> reaches;
  for (std::size_t n = 0; n < survey.displaced().size(); ++n)
  {
    const BrickExtent& extent = survey.extents()[n];
    const int brick = survey.displaced()[n];
    const Index3 origin = bricks.origin(brick);
    Vector3 first;
    Vector3 last;
    Vector3 firstCell;
    Vector3 lastCell;
    for (int a = 0; a < 3; ++a)
    {
      first[a] = origin[a] + (a == 0 ? 0.0 : extent.firstRow[a - 1]);
      last[a] = origin[a] + (a == 0 ? size[0] - 1.0 : extent.lastRow[a - 1]);
      firstCell[a] = first[a] - margin;
      lastCell[a] = last[a] + margin;
    }
    BrickReach reach;
    reach.cells = frame.between(firstCell, lastCell, { 0, 0, 0 }, { whole[0] - 1, whole[1] - 1, whole[2] - 1 });
    ranges.widen(brick, first, last);
    reach.voxels = frame.between(first, last, frame.low, frame.high);
    reaches.push_back(reach);
  }
  for (const int brick : bricks.links().carvedBricks())
  {
    // A carved element leaves its voxel.
    BrickReach reach;
    reach.cells.include(frame.bricks.indexOf(frame.at(bricks.origin(brick))));
    reach.voxels = reach.cells;
    reaches.push_back(reach);
  }
  return reaches;
}

}
