#pragma once

#include "CarryCells.h"

#include <vector>

namespace chainmail
{

/// An octree of bounding boxes that finds deformed tissue by position. A leaf is a block of 2 x 2 x 2 voxels, with the
/// cells whose lowest corners lie there.
class CarryTree
{
public:
  explicit CarryTree(const RestModel& model);

  /// Calls f(first voxel, isWhole) for each leaf with displaced tissue whose cells may cover a position. A leaf is
  /// whole if all corners of its eight cells are elements and no link between them is cut.
  template <typename F> void visitMovedAt(const Vector3& place, const F& f) const
  {
    if (!this->levels_.empty())
    {
      this->visit(static_cast<int>(this->levels_.size()) - 1, { 0, 0, 0 }, place, f);
    }
  }

  /// Finds the element whose current position is nearest to `place`. Returns whether there is any element.
  bool findNearest(const Vector3& place, Index3& element) const;

private:
  struct Box
  {
    float low[3];
    float high[3];
  };

  struct Level
  {
    Grid grid; ///< of the boxes
    std::vector<Box> boxes;
    std::vector<char> moved; ///< not 0 where tissue is displaced
  };

  struct Nearest
  {
    Vector3 place;
    double square;
    Index3 element;
  };

  static constexpr char whole = 2; ///< value of `moved` for whole leaves

  static constexpr Box empty();
  static void include(Box& box, const Box& other);
  bool holds(const Box& box, const Vector3& place) const;
  double squareTo(const Box& box, const Vector3& place) const;
  bool isWhole(const Index3& first) const;
  void findLeaves();
  void addLevel();
  void search(int level, const Index3& at, Nearest& nearest) const;

  template <typename F> void visit(int level, const Index3& at, const Vector3& place, const F& f) const
  {
    const Level& here = this->levels_[level];
    const std::size_t n = here.grid.at(at[0], at[1], at[2]);
    if (!here.moved[n] || !this->holds(here.boxes[n], place))
    {
      return;
    }
    const Index3 first{ 2 * at[0], 2 * at[1], 2 * at[2] };
    if (level == 0)
    {
      f(first, here.moved[n] == whole);
      return;
    }
    const Index3& size = this->levels_[level - 1].grid.size;
    for (int k = first[2]; k < std::min(first[2] + 2, size[2]); ++k)
    {
      for (int j = first[1]; j < std::min(first[1] + 2, size[1]); ++j)
      {
        for (int i = first[0]; i < std::min(first[0] + 2, size[0]); ++i)
        {
          this->visit(level - 1, { i, j, k }, place, f);
        }
      }
    }
  }

  RestModel model_;
  std::vector<Level> levels_; ///< from leaves to the root
};

}
