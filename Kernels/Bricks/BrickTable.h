#pragma once

#include "Model.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace chainmail
{

/// Where each brick is in the grid, which slot of the pool it has, and which offset each element has in its brick.
/// brick.clh describes the layout of the pool and what an address is.
class BrickTable
{
public:
  /// Throws InputError where the brick size cannot be used.
  BrickTable(const Grid& grid, const Index3& brickSize);

  /// Neighbour directions: 0 x-, 1 x+, 2 y-, 3 y+, 4 z-, 5 z+.
  static constexpr int opposite(int direction) { return direction ^ 1; }

  Index3 size() const { return this->size_; }
  int elementsPerBrick() const { return this->elements_; }

  /// A brick's number is its index in a table of all bricks of the grid, padded by one brick on every side.
  int brickAt(int i, int j, int k) const
  {
    return (i / this->size_[0] + 1) + this->strideY_ * (j / this->size_[1] + 1) +
           this->strideZ_ * (k / this->size_[2] + 1);
  }
  /// All numbers of bricks are less than this.
  int numbers() const { return static_cast<int>(this->table_.size()); }
  Index3 origin(int brick) const;
  int beside(int brick, int x, int y, int z) const { return brick + x + y * this->strideY_ + z * this->strideZ_; }
  int neighbour(int brick, int direction) const
  {
    const int strides[3] = { 1, this->strideY_, this->strideZ_ };
    return brick + (direction % 2 == 0 ? -1 : 1) * strides[direction / 2];
  }
  /// 0 where the brick has no memory, because it holds no tissue or because no deformation has reached it.
  int slot(int brick) const { return this->table_[brick]; }
  int brick(int slot) const { return this->place_[slot]; }
  /// Slots are 1 .. slots() - 1.
  int slots() const { return static_cast<int>(this->place_.size()); }

  /// The slots of these bricks, of those that have one.
  std::vector<int> slotsOf(const std::vector<int>& bricks) const;
  std::vector<int> bricksOf(const std::vector<int>& slots) const;
  /// The bricks of those slots whose entry in `found` is not 0.
  std::vector<int> bricksWhere(const std::vector<int>& slots, const std::vector<int>& found) const;
  /// These slots and all that share a face with one of them, ascending.
  std::vector<int> slotsAround(const std::vector<int>& slots) const;

  std::uint32_t address(int i, int j, int k) const;
  std::uint32_t local(int i, int j, int k) const;

  /// The elements of a brick that lie in one row along x, within the grid.
  struct Row
  {
    std::size_t voxel; ///< Grid::at of the first
    int count;
    std::uint32_t firsts[2]; ///< `local` of the first two
    std::uint32_t local(int n) const { return this->firsts[n & 1] + static_cast<std::uint32_t>(n >> 1); }
  };
  std::vector<Row> rows(int brick) const;
  /// Those of these slots whose bricks meet a box.
  std::vector<int> slotsIn(const VoxelBox& box, const std::vector<int>& slots) const;
  /// Calls f(row, first, last, at) for the rows of a brick that meet a box: elements `first` to `last` - 1 of the row
  /// lie in it, the first of these at `at` in an array over the box.
  template <typename F> void forRows(int brick, const VoxelBox& box, const F& f) const
  {
    for (const Row& row : this->rows(brick))
    {
      const Index3 at = this->grid_.indexOf(row.voxel);
      const int first = std::max(box.first[0] - at[0], 0);
      const int last = std::min(box.first[0] + box.size[0] - at[0], row.count);
      if (first < last && box.contains(at[0] + first, at[1], at[2]))
      {
        f(row, first, last, box.at(at[0] + first, at[1], at[2]));
      }
    }
  }

protected:
  Grid grid_;
  Index3 size_;
  Index3 counts_;
  int elements_;
  int strideY_;
  int strideZ_;
  std::vector<int> table_; ///< slot of each brick
  std::vector<int> place_; ///< brick of each slot; slot 0 stands for all bricks without memory
};

}
