#pragma once

#include "Model.h"

#include <cstddef>
#include <vector>

namespace chainmail
{

struct FoundJoints
{
  std::vector<std::size_t> voxels; ///< of joints (Grid::at), ascending; none for free joints
  std::vector<Model::Link> links;  ///< the links across free joints, ascending
};

/// Finds the voxels of joints, where bodies of rigid tissue meet (see Joints): those voxels of the larger body that
/// touch the other one. Of two bodies of equal size, the one with the larger label counts as the larger one. Tissue
/// without a label always counts as the larger one. Tissue that is stiffer than joints belongs to the nearest body, up
/// to three voxels from it. Joints continue between such tissue of two bodies, because the stiff voxels there would
/// otherwise hold one body at the other. The voxels of such joints are not rigid. For free joints it finds only the
/// links.
///
/// At free joints, tissue with the label of a body belongs to that body even where it is not rigid. There a component
/// of rigid tissue without a label may belong to a labelled body, too: to the one that it touches most. For this, the
/// labelled bodies that it touches must have together at least ten times as many voxels.
///
/// With a size, unlabelled rigid tissue is divided at its thin bridges first (see watershed()).
///
/// `read` returns constraints like Model::row(). The search needs 5 bits for each voxel, and 4 bytes for each voxel of
/// rigid tissue and of the stiff tissue near it. Where joints are found by their size it needs 29 bytes more for each
/// voxel of unlabelled rigid tissue and its marrow. Throws InputError where the labels cannot be used, or where bone
/// that is to be divided by its size has more than watershedVoxels.
FoundJoints findJoints(const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints);

}
