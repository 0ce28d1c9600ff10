#pragma once

#include "CarryCells.h"

#include <vector>

namespace chainmail
{

/// Displacements smoothly on from tissue into the air around it: the mean over blocks of 2 x 2 x 2 voxels that have
/// tissue, elsewhere over blocks twice as large, and so on, with linear interpolation between blocks.
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

  /// The means of blocks of twice the size. `get(at, sum)` adds the values of a block, or voxel, that are known and
  /// returns their number.
  template <typename Get> static Level coarser(const Index3& size, const Get& get);
  static Vector3 interpolate(const Level& coarse, const Index3& fine);

  Level finest_;
};

}
