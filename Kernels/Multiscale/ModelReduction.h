#pragma once

#include "Bricks.h"
#include "DisplacementSource.h"
#include "VoxelExtents.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace chainmail
{

/// A reduced model: a grid of larger elements that stand for n x n x n voxels each and deform in their place
/// (reduce.cl).
///
/// An element exists where any of its voxels is tissue. Its constraint is the mean over these. It is rigid if one
/// of them is rigid, and anchored if one of them is anchored. Two elements are linked if any of their voxels are
/// linked. So walls of a single voxel stay in one piece, and bodies on both sides of an element of air stay separate.
///
/// Cuts and carves act on the voxels, exactly. Where a cut divides the voxels of an element, the largest connected
/// component stays with this element. Each other component joins the element to which most of its links lead. So each
/// voxel beside a cut follows the tissue on its own side. Elements whose voxels have no link left between them are not
/// linked.
///
/// Displacements of voxels are made from those of the elements when they are needed: of all voxels at once, or of some
/// bricks at a time where all would need too much memory.
class ModelReduction : public DisplacementSource
{
public:
  /// Creates elements of `factor` (2, 4 or 8) voxels of `whole` per axis, or of one on an axis with a single voxel. If
  /// `rotationSettings` is on, the elements have rotations.
  ModelReduction(Bricks& whole, int factor, const RotationSettings& rotationSettings);
  ~ModelReduction() override;

  /// The number of voxels per element along an axis with more than one voxel.
  int voxelsPerElement() const { return std::max({ this->factor_[0], this->factor_[1], this->factor_[2] }); }

  /// The larger elements.
  Bricks& bricks() { return this->bricks_; }

  /// The place of the first larger element, the centre of its voxels [mm], see Grid.
  Vector3 origin() const
  {
    Vector3 origin;
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = 0.5 * (this->factor_[a] - 1) * this->whole_.model().grid().spacing[a];
    }
    return origin;
  }

  /// To be called when the displacements of the larger elements have changed.
  void moved();

  /// Displaces all voxels with the larger elements. The displacement of a voxel is interpolated linearly between the
  /// elements that links join to the voxel's own element. A rigid voxel moves exactly with its own element, including
  /// its rotation. Does nothing if no element has moved since the last call.
  void expand();

  bool displaceAll() override;
  std::uint64_t version() const override { return this->version_; }
  const std::vector<int>& displaced() override;
  const std::vector<BrickExtent>& extents() override;
  std::size_t room() const override { return this->mostAtOnce_; }
  void displace(const std::vector<int>& bricks) override;
  /// The bricks of a box that may be displaced, in lists that displace() has room for.
  std::vector<std::vector<int>> displacedIn(const VoxelBox& box);

  /// Applies the cuts and carves of the voxels to the larger elements. Returns the larger elements removed, ascending.
  std::vector<std::size_t> applyTopology();

  /// Restores all links and elements of both grids. No element may be held at that time.
  void restoreTopology();

  /// The elements that a probe holds if it grabs these voxels, ascending: those of whose voxels it grabs at least half.
  /// If there are none, it holds the one of which it grabs most.
  std::vector<std::size_t> elementsOf(const std::vector<std::size_t>& voxels) const;

  /// The tissue voxels within the box of an element, ascending.
  std::vector<std::size_t> voxelsOf(std::size_t element) const;

  /// The number of parallel voxel links that a link of elements stands for. Its energy and force count as many times.
  double linksPerLink() const;

  /// Gives every voxel of a box the value of its larger element, `axes()` interleaved values each; `nothing` in air.
  template <typename T> void spread(const std::vector<T>& reduced, T nothing, const VoxelBox& box, T* out) const
  {
    const Grid& grid = this->whole_.model().grid();
    const std::size_t axes = static_cast<std::size_t>(this->whole_.model().axes());
    std::vector<float> row(box.size[0] * axes);
    for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
    {
      for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
      {
        this->whole_.row(box.first[0], j, k, box.size[0], row.data());
        const std::size_t first = grid.at(box.first[0], j, k);
        for (std::size_t i = 0; i < static_cast<std::size_t>(box.size[0]); ++i)
        {
          const bool air = std::isinf(row[i * axes]);
          const std::size_t from = air ? 0 : this->ownerOf(first + i);
          for (std::size_t a = 0; a < axes; ++a)
          {
            *out++ = air ? nothing : reduced[from * axes + a];
          }
        }
      }
    }
  }

private:
  using Cell = std::vector<std::size_t>; ///< voxels

  Index3 cellOf(const Index3& voxel) const
  {
    return { voxel[0] / this->factor_[0], voxel[1] / this->factor_[1], voxel[2] / this->factor_[2] };
  }
  std::size_t parentOf(std::size_t voxel) const;
  std::size_t ownerOf(std::size_t voxel) const;
  template <typename F> void forLinks(std::size_t voxel, const F& f) const;
  std::vector<Cell> pieces(std::size_t element) const;
  void join(std::vector<Cell> loose, const std::unordered_map<std::size_t, std::size_t>& before);
  void separate();
  std::set<std::size_t> touched() const;
  std::vector<std::size_t> findOwners(const std::set<std::size_t>& changed);
  void removeLinks(const std::set<std::size_t>& changed);
  const VoxelExtents& movedVoxels();
  void expandThese(const std::vector<int>& bricks);

  Bricks& whole_;
  Index3 factor_;
  std::vector<std::pair<std::size_t, int>> apart_; ///< (element, axis): no link to the next element from the start
  Bricks bricks_;
  std::unordered_map<std::size_t, std::size_t> owners_; ///< voxel -> the element that it follows, if not its parent
  VoxelExtents moved_;
  std::size_t mostAtOnce_;    ///< bricks with a displacement at the same time
  std::uint64_t version_ = 0; ///< of the elements' displacements
  bool current_ = true;       ///< whether all voxels have these
  bool found_ = true;         ///< whether `moved_` is of this version
  Field owner_;               ///< int [address] of the voxels: 1 + the element that it follows, 0 for its parent
  Scratch list_{ "the list of bricks" };
};

}
