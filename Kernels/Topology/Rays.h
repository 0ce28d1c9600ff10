#pragma once

#include "ClosedSurface.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Rays along x through a closed surface, whose crossings give exact winding numbers. The triangles are sorted into
/// columns along x, so each ray tests few of them.
class Rays
{
public:
  /// Through the whole surface.
  explicit Rays(const ClosedSurface& surface);

  /// Through the part of a surface in the box [low, high].
  Rays(const ClosedSurface& surface, const Fixed3& low, const Fixed3& high);

  /// The box, clipped to the bounding box of the surface.
  const Fixed3& low() const { return this->low_; }
  const Fixed3& high() const { return this->high_; }
  bool empty() const { return this->low_[0] > this->high_[0] || this->triangles_.empty(); }

  /// Whether a position [voxels] is inside.
  bool contains(const Vector3& place) const;

  /// contains() for a row of `count` positions from `first` on, one voxel apart along x; their y and z must lie within
  /// [low(), high()].
  void row(const Fixed3& first, int count, char* inside) const;

  /// The sum of the winding numbers of the surface's parts at a position, each times the part's weight.
  int winding(const Fixed3& place, const std::vector<int>& weights) const;

private:
  struct Triangle : ExactTriangle
  {
    Triangle(const std::array<Fixed3, 3>& corners, int ofPart)
      : ExactTriangle(corners)
      , part(ofPart)
    {
    }
    int part;
  };

  /// A triangle that is ahead of the first `before` positions of a row. The winding number of a part at a position is
  /// the sum of the signs of the part's triangles ahead of it.
  struct Crossing
  {
    int part;
    int sign;
    int before;
  };

  /// Index of the column at a y (axis 1) or z (axis 2). It may lie outside the existing columns.
  std::int64_t columnOf(double at, int axis) const;

  /// Calls f(column) for every column in which a ray may meet the triangle.
  template <typename F> void forColumns(const ExactTriangle& triangle, F&& f) const;

  /// The triangles that are ahead of at least one position of a row.
  std::vector<Crossing> crossings(const Fixed3& first, int count) const;

  Fixed3 low_;
  Fixed3 high_;
  Fixed3 width_{};  ///< of one column
  Fixed3 counts_{}; ///< number of columns
  std::vector<Triangle> triangles_;
  std::vector<int> alternating_;    ///< as in ClosedSurface
  bool alternates_;                 ///< whether any entry of alternating_ is not 0
  std::vector<std::uint64_t> ends_; ///< where each column's triangles begin in inColumn_
  std::vector<std::uint32_t> inColumn_;
};

}
