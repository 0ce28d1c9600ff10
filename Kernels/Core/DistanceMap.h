#pragma once

#include "VoxelSet.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// The largest squared distance [half voxels]; larger ones count as this one.
constexpr std::uint16_t farthest = 65535;

/// The squared Euclidean distance [half voxels] of each solid voxel to the nearest centre of a voxel that is not solid:
/// from its own centre or, with `halfway`, from the point half a voxel further along each axis that has more than one
/// voxel. It is exact, by one pass along each axis (Felzenszwalb and Huttenlocher, doi 10.4086/toc.2012.v008a019).
/// Beyond the grid everything counts as solid, because tissue continues there. Points that are themselves beyond the
/// last voxel have the distance 0.
///
/// Solid are the voxels of `solid` with a value other than 0. The distances are by the numbers of its voxels; of those
/// that are not solid, theirs.
std::vector<std::uint16_t> mapDistances(const Grid& grid, const VoxelMap<char>& solid, bool halfway);

}
