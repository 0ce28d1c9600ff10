#pragma once

#include "Model.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace chainmail
{

/// Some elements of a reduced model. Each stands for `factor` voxels along each axis, or for fewer at the end of the
/// image.
struct ReducedBox
{
  VoxelBox elements;
  /// Signed, see Model::row(): the mean of those of an element's tissue voxels, or 0 if one of them is rigid.
  std::vector<float> constraints;
  /// Bit a: a link of voxels joins the element to the next one along axis a, which is in the box, too.
  std::vector<std::uint8_t> linked;
};

/// The grid of all elements.
Grid reducedGrid(const Grid& whole, const Index3& factor);

/// The elements that have all their voxels in a box, which may be none.
VoxelBox elementsWithin(const Grid& whole, const Index3& factor, const VoxelBox& voxels);

/// Reads rows of voxels as Model::row() does.
using VoxelRows = std::function<void(int i, int j, int k, int count, float* out)>;

/// Reduces the tissue of a box of elements. The elements in the boxes of `known`, which do not overlap, are left out:
/// their voxels are not read and count as air.
ReducedBox reduceBox(const Grid& whole, const Index3& factor, const VoxelBox& elements, int axes, const VoxelRows& rows,
  const std::vector<VoxelBox>& known = {});

}
