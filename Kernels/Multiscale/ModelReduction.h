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
/// An element is where any of its voxels is. It gives as much as they do on average; where one of them is rigid it is
/// rigid, where one is anchored it is anchored. A link is where any of its voxels has one to a voxel of the neighbour,
/// so that walls of a single voxel stay in one piece and bodies on either side of an element of air stay apart.
///
/// Cuts and carves act on the voxels, exactly. Where a cut divides the voxels of an element the largest part stays with
/// it, and the others join the element that most of their links lead to: so both sides of a cut follow their own side,
/// to the voxel, and what is cut through has no link left.
class ModelReduction
{
public:
  /// The elements that stand for `factor` (2, 4 or 8) voxels of `whole` per axis; for a single one on flat axes.
  ModelReduction(Bricks& whole, int factor);
  ~ModelReduction();

  /// Per axis that is not flat.
  int voxelsPerElement() const { return std::max({ this->factor_[0], this->factor_[1], this->factor_[2] }); }

  /// The grid of larger elements.
  Bricks& bricks() { return this->bricks_; }

  /// The displacements of the larger elements changed.
  void moved() { this->current_ = false; }

  /// Displaces the voxels as the larger elements are: linear between those that the voxel's own one hangs together
  /// with, and exactly as its own one where the voxel is rigid.
  void expand();

  /// Takes over what was cut and carved of the voxels. Returns the larger elements that are gone, ascending.
  std::vector<std::size_t> follow();

  /// All links and elements back, of both grids. Nothing may be held by then.
  void mend();

  /// The elements that a probe holds which grabs these voxels: those of which it has at least half, else
  /// the one of which it has most. Ascending.
  std::vector<std::size_t> elementsOf(const std::vector<std::size_t>& voxels) const;

  /// The tissue within the box of an element, ascending.
  std::vector<std::size_t> voxelsOf(std::size_t element) const;

  /// So many links of voxels, side by side, go through one of an element: what its energy and its force count for.
  double linksPerLink() const;

  /// Values of the larger elements, `axes()` interleaved ones each, as values of their voxels; `nothing` in air.
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
  std::vector<std::pair<std::size_t, int>> apart_; ///< elements without a link to the next one along an axis, at rest
  Bricks bricks_;
  std::unordered_map<std::size_t, std::size_t> owners_; ///< of voxels that follow another element than their own
  bool current_ = true;                                 ///< the voxels are where the elements are
  Field owner_; ///< int [address] of the voxels: 1 + that element, 0 the own one
  Scratch list_{ "the list of bricks" };
};

}
