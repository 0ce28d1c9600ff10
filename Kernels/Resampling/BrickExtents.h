#pragma once

#include "ChangeTracker.h"
#include "Types.h"

#include <algorithm>
#include <array>
#include <vector>

namespace chainmail
{

/// A box of output bricks, from `first` to `last`, counted as in OutputFrame::bricks.
struct BrickBox
{
  Index3 first{ 0, 0, 0 };
  Index3 last{ -1, -1, -1 };

  bool isEmpty() const
  {
    return this->first[0] > this->last[0] || this->first[1] > this->last[1] || this->first[2] > this->last[2];
  }
  std::size_t bricks() const
  {
    std::size_t count = this->isEmpty() ? 0 : 1;
    for (int a = 0; a < 3 && count > 0; ++a)
    {
      count *= static_cast<std::size_t>(this->last[a] - this->first[a] + 1);
    }
    return count;
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

/// The output (voxels `low` to `high`) and its division into bricks of the grid's brick size.
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

/// For each brick the box of its displaced elements and the bounds of their displacements.
class Ranges
{
public:
  /// For tissue at rest.
  explicit Ranges(const Bricks& bricks);
  /// For the last look of a survey.
  Ranges(const Bricks& bricks, const ChangeTracker& survey);

  /// The output bricks that the moved cells of one brick may reach, and those that they may leave. With `whole` all its
  /// elements count as displaced. The boxes extend at least `beyond` voxels further.
  struct Shown
  {
    BrickBox reached;
    BrickBox left;

    /// A box around both.
    BrickBox both() const
    {
      BrickBox all = this->left;
      if (!this->reached.isEmpty())
      {
        all.include(this->reached.first);
        all.include(this->reached.last);
      }
      return all;
    }
  };
  Shown shown(int brick, const OutputFrame& frame, bool whole, int beyond = 0) const;
  /// The bricks with cells that the displaced elements of one brick move.
  BrickBox cells(int brick, const OutputFrame& frame) const;
  /// Whether links or elements of a brick were missing when the ranges were made.
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
  std::vector<int> numbers_; ///< for each brick the index of its range; index 0 is the range of whole bricks at rest
  std::vector<Range> ranges_;
};

/// What the tissue of one brick affects.
struct BrickExtents
{
  BrickBox cells;  ///< bricks with cells that it moves
  BrickBox voxels; ///< output bricks that these cells may reach, or leave, or both
};

/// The distance [voxels] up to which a carved element affects the output, where cut surfaces are smooth.
constexpr int reachOfCarves = 3;

/// What all displaced tissue and all carved elements affect, one or two entries for each displaced and each carved
/// brick.
std::vector<BrickExtents> findReaches(
  const Bricks& bricks, const OutputFrame& frame, const ChangeTracker& survey, const Ranges& ranges, CutSurfaces cuts);

}
