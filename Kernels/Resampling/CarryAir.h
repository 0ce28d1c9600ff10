#pragma once

#include "CarryCells.h"

#include <vector>

namespace chainmail
{

/// Extends displacements smoothly from tissue into the air around it (a pull-push pyramid). Blocks of 2 x 2 x 2 voxels
/// with tissue have the mean over their elements. Other blocks take their value from blocks twice as large, and so on,
/// by trilinear interpolation between the centres of blocks.
class CarryAir
{
public:
  explicit CarryAir(const RestModel& model);

  /// At a voxel of the grid.
  Vector3 at(const Index3& voxel) const { return interpolate(this->finest_, voxel); }

private:
  struct Level
  {
    Index3 size{};
    std::vector<float> values; ///< 3 a block
    std::vector<char> known;

    std::size_t at(int i, int j, int k) const
    {
      return static_cast<std::size_t>(i) +
             static_cast<std::size_t>(this->size[0]) *
               (static_cast<std::size_t>(j) + static_cast<std::size_t>(this->size[1]) * k);
    }
  };

  /// The means over blocks of twice the size. `get(at, sum)` adds the value of a block, or voxel, to `sum` if it has
  /// one, and returns whether it has.
  template <typename Get> static Level coarser(const Index3& size, const Get& get);
  static Vector3 interpolate(const Level& coarse, const Index3& fine);

  Level finest_;
};

}
