#pragma once

#include "Model.h"

#include <cstddef>
#include <vector>

namespace chainmail
{

/// The voxels of joints (Grid::at), ascending: where bodies of rigid tissue meet (see Joints), the voxels of the larger
/// one that touch the other one. Of bodies alike in size these are of the one with the larger label; tissue without a
/// label always counts as the larger one. Tissue that is stiffer than joints belongs to the nearest body, up to three
/// voxels from it, and joints go on between such tissue of two bodies, or the stiff voxels there would hold one body at
/// the other; they are then voxels that are not rigid. `read` gives constraints as Model::row() does. Takes 6 bytes a
/// voxel while it works, and 12 where joints are to be found by their size. Throws InputError where the labels cannot
/// be used.
std::vector<std::size_t> findJoints(const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints);

}
