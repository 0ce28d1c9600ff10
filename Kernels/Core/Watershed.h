#pragma once

#include "VoxelSet.h"

#include <cstddef>
#include <cstdint>

namespace chainmail
{

/// The largest number of voxels that watershed() can divide: it numbers two nodes for each with 32 bits.
constexpr std::size_t watershedVoxels = (std::size_t(1) << 31) - 1;

/// Divides solid tissue into bodies at bridges that are thinner than `size` voxels: a watershed of its distance map.
///
/// The distance d [voxels] is that to the nearest centre of a voxel that is not solid. The tissue is 2 d - 1 voxels
/// thick there. d is taken at the centres of voxels and at the corners where eight solid voxels meet. Otherwise bridges
/// of one and of two voxels would have the same distance. A bridge of an even thickness counts as up to 0.3 voxels
/// thicker, because the voxels nearest to a corner are aside of it.
///
/// Basins are flooded from the maxima of d downwards. Two basins meet at a pass, the thickest place between them. From
/// the highest pass to the lowest, they are joined into one body unless
///
/// - the tissue is thinner than `size` voxels at the pass, and
/// - the maximum of each is at least twice the distance at the pass: 2 t + 1 voxels for a bridge of t voxels.
///
/// So crumbs, and the small maxima of a noisy surface, go to the neighbour behind the highest pass. Of equal passes the
/// widest is first. A larger size divides bodies further, and joins none.
///
/// Solid are the voxels of `bodies` with the value 0. Those with another value belong to that body already and are not
/// solid. They take part as basins, but only flood what is thinner than `size`. They are joined with every basin that
/// is thinner than `size` everywhere.
///
/// Returns for the same voxels the numbers of their bodies: that of a given one, or one from `next` on, which has to be
/// larger than those. 0 in bodies that are nowhere 3 voxels thick: no bridge can divide them from others. It needs 29
/// bytes for each of the voxels.
VoxelMap<std::uint32_t> watershed(const Grid& grid, VoxelMap<std::uint32_t> bodies, int size, std::uint32_t next);

}
