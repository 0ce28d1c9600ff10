#pragma once

#include "BrickTable.h"

#include <algorithm>
#include <vector>

namespace chainmail
{

/// A set of bricks of a grid of this size.
class BrickSet
{
public:
  BrickSet(const BrickTable& bricks, const Index3& grid)
    : bricks_(bricks)
    , grid_(grid)
    , has_(bricks.numbers(), 0)
  {
  }

  void add(int brick) { this->has_[brick] = 1; }
  bool has(int brick) const { return this->has_[brick] != 0; }
  std::vector<int> all() const
  {
    std::vector<int> all;
    for (std::size_t brick = 0; brick < this->has_.size(); ++brick)
    {
      if (this->has_[brick] != 0)
      {
        all.push_back(static_cast<int>(brick));
      }
    }
    return all;
  }
  /// These bricks and all that are up to `voxels` away from one of them.
  BrickSet widened(const Index3& voxels) const
  {
    const Index3 size = this->bricks_.size();
    BrickSet wider(this->bricks_, this->grid_);
    for (const int brick : this->all())
    {
      const Index3 origin = this->bricks_.origin(brick);
      Index3 low;
      Index3 high;
      for (int a = 0; a < 3; ++a)
      {
        low[a] = std::max(origin[a] - voxels[a], 0);
        high[a] = std::min(origin[a] + size[a] - 1 + voxels[a], this->grid_[a] - 1);
      }
      for (int k = low[2] / size[2] * size[2]; k <= high[2]; k += size[2])
      {
        for (int j = low[1] / size[1] * size[1]; j <= high[1]; j += size[1])
        {
          for (int i = low[0] / size[0] * size[0]; i <= high[0]; i += size[0])
          {
            wider.add(this->bricks_.brickAt(i, j, k));
          }
        }
      }
    }
    return wider;
  }

private:
  const BrickTable& bricks_;
  Index3 grid_;
  std::vector<char> has_;
};

}
