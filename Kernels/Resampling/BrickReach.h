#pragma once

#include "Survey.h"
#include "Types.h"

#include <algorithm>
#include <array>
#include <vector>

namespace chainmail
{

/// Some bricks of the output, from `first` to `last`, counted as in OutputFrame::bricks.
struct BrickBox
{
  Index3 first{ 0, 0, 0 };
  Index3 last{ -1, -1, -1 };

  bool isEmpty() const
  {
    return this->first[0] > this->last[0] || this->first[1] > this->last[1] || this->first[2] > this->last[2];
  }
  bool meets(const BrickBox& other) const
  {
    bool meet = true;
    for (int a = 0; a < 3; ++a)
    {
      meet = meet && this->first[a] <= other.last[a] && other.first[a] <= this->last[a];
    }
    return meet;
  }
  void include(const Index3& brick)
  {
    const bool empty = this->isEmpty();
    for (int a = 0; a < 3; ++a)
    {
      this->first[a] = empty ? brick[a] : std::min(this->first[a], brick[a]);
      this->last[a] = empty ? brick[a] : std::max(this->last[a], brick[a]);
    }
  }
  /// Whether f(number) is true for one of the bricks, numbered as in `bricks`.
  template <typename F> bool any(const Grid& bricks, const F& f) const
  {
    for (int k = this->first[2]; k <= this->last[2]; ++k)
    {
      for (int j = this->first[1]; j <= this->last[1]; ++j)
      {
        for (int i = this->first[0]; i <= this->last[0]; ++i)
        {
          if (f(bricks.at(i, j, k)))
          {
            return true;
          }
        }
      }
    }
    return false;
  }
  template <typename F> void each(const Grid& bricks, const F& f) const
  {
    this->any(bricks,
      [&](std::size_t brick)
      {
        f(brick);
        return false;
      });
  }
};

/// The output, voxels `low` to `high`, and its division into bricks of the grid's brick size.
struct OutputFrame
{
  Index3 brickSize;
  Index3 low;
  Index3 high;
  Index3 firstBrick; ///< the lowest brick of the output, counted in bricks of the grid; may be negative
  Grid bricks;       ///< the bricks of the output, each as one voxel of this grid

  OutputFrame(const Grid& grid, const Index3& padding, const Index3& brickSize);

  /// The first voxel of brick number `n` of `bricks`.
  Index3 origin(std::size_t n) const;
  /// The number, in `bricks`, of the brick that begins at a voxel.
  std::size_t at(const Index3& origin) const;
  /// The bricks that meet the box of voxels from `from` to `to` within the limits `least` and `most`.
  BrickBox between(const Vector3& from, const Vector3& to, const Index3& least, const Index3& most) const;
};

/// Where displaced tissue is in each brick, and how far it is displaced.
class Ranges
{
public:
  /// Of tissue at rest.
  explicit Ranges(const Bricks& bricks);
  /// Of what a look found.
  Ranges(const Bricks& bricks, const Survey& survey);

  /// The output bricks where what is shown depends on the tissue of one brick: where cells may be, or come from, that
  /// its displaced elements move; in `whole` bricks as if they all were displaced. All `beyond` voxels further.
  BrickBox shown(int brick, const OutputFrame& frame, bool whole, int beyond = 0) const;
  /// The bricks whose cells the displaced elements of one brick move.
  BrickBox cells(int brick, const OutputFrame& frame) const;
  /// Whether links or elements of a brick were missing.
  bool isCut(int brick) const { return this->ranges_[this->numbers_[brick]].cut; }

private:
  struct Range
  {
    std::array<float, 3> low{};
    std::array<float, 3> high{};
    std::array<float, 3> first{};
    std::array<float, 3> last{ { -1.0f, -1.0f, -1.0f } };
    bool cut = false;
  };

  Range& of(int brick);

  const Bricks* bricks_;
  std::vector<int> numbers_; ///< for each brick the number of its range; 0 where it is whole and at rest
  std::vector<Range> ranges_;
};

/// What the tissue of one brick makes necessary.
struct BrickReach
{
  BrickBox cells;  ///< bricks whose cells it moves
  BrickBox voxels; ///< bricks of the output where these may arrive or which they may leave
};

/// How far from a carved element [voxels] what is shown depends on it, where cut surfaces are smooth.
constexpr int reachOfCarves = 3;

/// What all displaced tissue makes necessary, and all that was carved away.
std::vector<BrickReach> findReaches(
  const Bricks& bricks, const OutputFrame& frame, const Survey& survey, const Ranges& ranges, CutSurfaces cuts);

}
