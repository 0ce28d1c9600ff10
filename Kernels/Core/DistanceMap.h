#pragma once

#include "Model.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// The largest squared distance [half voxels]; larger ones count as this one.
constexpr std::uint16_t farthest = 65535;

/// The squared Euclidean distance [half voxels] to the nearest centre of a voxel that is not `solid`: from the centre
/// of each voxel or, with `halfway`, from the point half a voxel further along each axis that has more than one voxel.
/// It is exact, by one pass along each axis (Felzenszwalb and Huttenlocher, doi 10.4086/toc.2012.v008a019). Beyond the
/// grid everything counts as solid, because tissue continues there. Points that are themselves beyond the last voxel
/// have the distance 0. `distances` has one value for each voxel.
void mapDistances(const Grid& grid, const std::vector<char>& solid, bool halfway, std::uint16_t* distances);

}
