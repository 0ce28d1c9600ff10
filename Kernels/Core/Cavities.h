#pragma once

#include "VoxelSet.h"

namespace chainmail
{

/// Adds to `solid` the cavities in it: voxels that no path through voxels outside both sets connects with a face of the
/// grid or with a voxel of `outside`. A cavity that a face of the grid cuts open counts as enclosed if it is so within
/// that face: the tissue continues beyond the grid. Needs 12 bytes for each row of voxels, and as many for each further
/// run that the sets divide it into.
void fillCavities(const Grid& grid, const VoxelSet& outside, VoxelSet& solid);

}
