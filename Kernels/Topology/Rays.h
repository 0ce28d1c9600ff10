#pragma once

#include "ClosedSurface.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Rays along x through a closed surface, whose crossings give winding numbers, exactly. The triangles are sorted into
/// columns along x, so that a ray meets few of them.
class Rays
{
public:
  /// Through all of a surface.
  explicit Rays(const ClosedSurface& surface);

  /// Through the part of it in the box [low, high].
  Rays(const ClosedSurface& surface, const Fixed3& low, const Fixed3& high);

  /// The part of the box that the surface reaches.
  const Fixed3& low() const { return this->low_; }
  const Fixed3& high() const { return this->high_; }
  bool empty() const { return this->low_[0] > this->high_[0] || this->triangles_.empty(); }

  /// Whether a place [voxels] is inside.
  bool contains(const Vector3& place) const;

  /// The same for a row of `count` places from `first` on, one voxel apart along x; their y and z must lie within
  /// [low(), high()].
  void row(const Fixed3& first, int count, char* inside) const;

  /// The sum over the surface's parts of how often each winds around a place, times its weight.
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

  /// A triangle that is ahead of the first `before` places of a row. The signs of all that are ahead of a place add up
  /// to the part's winding number there.
  struct Crossing
  {
    int part;
    int sign;
    int before;
  };

  /// Index of the column at a y (axis 1) or z (axis 2). It may lie outside the columns that there are.
  std::int64_t columnOf(double at, int axis) const;

  /// Calls f(column) for every column in which a ray may meet the triangle.
  template <typename F> void forColumns(const ExactTriangle& triangle, F&& f) const;

  /// The triangles ahead of any place of a row.
  std::vector<Crossing> crossings(const Fixed3& first, int count) const;

  Fixed3 low_;
  Fixed3 high_;
  Fixed3 width_{};  ///< of one column
  Fixed3 counts_{}; ///< number of columns
  std::vector<Triangle> triangles_;
  std::vector<int> alternating_;    ///< as in ClosedSurface
  bool alternates_;                 ///< whether any part does
  std::vector<std::uint64_t> ends_; ///< where each column's triangles begin in inColumn_
  std::vector<std::uint32_t> inColumn_;
};

}
