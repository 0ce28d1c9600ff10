#pragma once

#include "Bricks.h"
#include "DisplacementSource.h"

#include <array>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The bricks of voxels that the elements of a reduced model move, and bounds of the displacements there, from the
/// elements alone: an interpolated displacement lies between theirs (reduce.cl).
class VoxelExtents
{
public:
  /// An element stands for `factor` voxels along each axis.
  VoxelExtents(const Bricks& voxels, Bricks& elements, const Index3& factor);

  /// Finds them for the present displacements. `owners`: voxels that follow another element than the one around them.
  void find(const std::unordered_map<std::size_t, std::size_t>& owners);

  /// Bricks of voxels, ascending.
  const std::vector<int>& bricks() const { return this->bricks_; }
  const std::vector<BrickExtent>& extents() const { return this->extents_; }

private:
  /// Bounds of displacements [voxels].
  struct Bounds
  {
    std::array<float, 3> low{};
    std::array<float, 3> high{};
  };

  Bounds boundsOf(const float* displacement, const float* spin) const;
  void include(int brick, const Bounds& bounds);
  void addElements(int slot);
  void addRest();
  void addOwners(const std::unordered_map<std::size_t, std::size_t>& owners);
  void sort();

  const Bricks& voxels_;
  Bricks& elements_;
  Index3 factor_;
  std::vector<int> bricks_;
  std::vector<BrickExtent> extents_;
  std::vector<int> numbers_; ///< for each brick its place in these lists, or -1
  std::vector<int> counts_;  ///< the displaced elements around each of the bricks
};

}
