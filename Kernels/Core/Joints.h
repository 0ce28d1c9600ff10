#pragma once

#include "Model.h"

#include <cstddef>
#include <vector>

namespace chainmail
{

struct FoundJoints
{
  std::vector<std::size_t> voxels; ///< Grid::at, ascending; none of free joints
  std::vector<Model::Link> links;  ///< that free joints are without, ascending
};

/// The voxels of joints: where bodies of rigid tissue meet (see Joints), the voxels of the larger
/// one that touch the other one. Of bodies alike in size these are of the one with the larger label; tissue without a
/// label always counts as the larger one. Tissue that is stiffer than joints belongs to the nearest body, up to three
/// voxels from it, and joints go on between such tissue of two bodies, or the stiff voxels there would hold one body at
/// the other; they are then voxels that are not rigid. Of free joints the links alone.
///
/// At free joints, tissue with a body's label belongs to it also where it is not rigid, and rigid tissue without a label
/// that touches labelled bodies of together at least ten times as many voxels to the one that it touches most. `read` gives constraints as Model::row() does. Takes 6 bytes a
/// voxel while it works, and 12 where joints are to be found by their size. Throws InputError where the labels cannot
/// be used.
FoundJoints findJoints(const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints);

}
