#pragma once

#include "Tissue.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace chainmail
{

/// Consecutive elements along x that links join.
struct ElementRun
{
  std::size_t first; ///< Grid::at
  std::uint32_t count;
  int component; ///< the connected component that they are part of
  bool anchored; ///< whether one of them is anchored
};

/// The elements of all connected components, in the order of voxels. Links join two elements of a component.
/// `rigidOnly`: only elements whose constraint on `axis` is 0 count. Components are numbered in the order of their
/// first voxels.
std::vector<ElementRun> connectedRuns(const Tissue& tissue, int axis, bool rigidOnly);

}
