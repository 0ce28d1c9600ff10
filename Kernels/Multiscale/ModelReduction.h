#pragma once

#include "Bricks.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace chainmail
{

/// A grid of fewer, larger elements that stand for n x n x n voxels each and deform in their place (reduce.cl).
///
/// An element exists where any of its voxels is tissue. Its constraint is their mean; it is rigid where one of them is
/// rigid and anchored where one is anchored. Two elements are linked where any of their voxels are. So walls of a
/// single voxel stay in one piece, and bodies on either side of an element of air stay apart.
///
/// Cuts and carves act on the voxels, exactly. Where a cut divides the voxels of an element, the largest part stays
/// with it, and each other part joins the element that most of its links lead to. So the tissue on both sides of a cut
/// follows its own side, to the voxel, and elements between which everything is cut have no link left.
class ModelReduction
{
public:
  /// Makes the elements for `factor` (2, 4 or 8) voxels of `whole` per axis, or one on an axis with a single voxel.
  /// Where they turn these elements have spins.
  ModelReduction(Bricks& whole, int factor, const Turning& turning);
  ~ModelReduction();

  /// The number of voxels per element along an axis with more than one voxel.
  int voxelsPerElement() const { return std::max({ this->factor_[0], this->factor_[1], this->factor_[2] }); }

  /// The larger elements.
  Bricks& bricks() { return this->bricks_; }

  /// The place of the first of them, the middle of its voxels [mm], see Grid.
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
  void moved() { this->current_ = false; }

  /// Displaces the voxels as the larger elements are: linear between the elements that links join to the voxel's own
  /// one, and exactly as that one, with its rotation, where the voxel is rigid. Does nothing if no element has moved
  /// since.
  void expand();

  /// Takes over cuts and carves of the voxels. Returns the larger elements that are gone, ascending.
  std::vector<std::size_t> follow();

  /// Restores all links and elements of both grids. No element may be held at that time.
  void mend();

  /// The elements that a probe holds if it grabs these voxels: those of which it grabs at least half, or else the one
  /// of which it grabs most. Ascending.
  std::vector<std::size_t> elementsOf(const std::vector<std::size_t>& voxels) const;

  /// The tissue voxels within the box of an element, ascending.
  std::vector<std::size_t> voxelsOf(std::size_t element) const;

  /// How many links of voxels lie side by side in one link of elements: its energy and its force count as often.
  double linksPerLink() const;

  /// Gives every voxel the value of its larger element, `axes()` interleaved values each; `nothing` in air.
  template <typename T> void spread(const std::vector<T>& reduced, T nothing, T* out) const
  {
    const Grid& grid = this->whole_.model().grid();
    const std::size_t axes = static_cast<std::size_t>(this->whole_.model().axes());
    std::vector<float> row(grid.size[0] * axes);
    for (std::size_t first = 0; first < grid.voxels(); first += grid.size[0])
    {
      const Index3 at = grid.indexOf(first);
      this->whole_.row(0, at[1], at[2], grid.size[0], row.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(grid.size[0]); ++i)
      {
        const bool air = std::isinf(row[i * axes]);
        const std::size_t from = air ? 0 : this->ownerOf(first + i);
        for (std::size_t a = 0; a < axes; ++a)
        {
          out[(first + i) * axes + a] = air ? nothing : reduced[from * axes + a];
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
  std::set<int> displacedBricks();

  Bricks& whole_;
  Index3 factor_;
  std::vector<std::pair<std::size_t, int>> apart_; ///< elements with no link to the next one along an axis, at rest
  Bricks bricks_;
  std::unordered_map<std::size_t, std::size_t> owners_; ///< the element of each voxel that follows another than its own
  bool current_ = true;                                 ///< whether the voxels are where the elements are
  Field owner_; ///< int [address] of the voxels: 1 + the element that it follows, 0 for its own
  Scratch list_{ "the list of bricks" };
};

}
