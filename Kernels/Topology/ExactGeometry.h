#pragma once

#include "Types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace chainmail
{

/// Exact predicates for the positions of elements relative to a surface of triangles. Positions and points are rounded
/// to 1/4096 voxel, and everything after that is computed in 128-bit integers. A position exactly on the surface is
/// decided as if all tissue were shifted by an infinitesimal (e, e^2, e^3): simulation of simplicity, H. Edelsbrunner
/// and E. Muecke, 1990. So neighbouring triangles leave no gap and no link is counted twice.
using Wide = __int128;
using Fixed3 = std::array<std::int64_t, 3>;

constexpr double unitsPerVoxel = 4096.0;

/// A position [voxels] rounded to 1/4096 voxel.
Fixed3 fixed(const Vector3& voxel);

/// The points of a surface, rounded. Throws InputError, whose message calls the surface `name`, where a point is not
/// finite or too far away for 128 bits, or where a triangle names a point that does not exist.
std::vector<Fixed3> fixedPoints(const Surface& surface, const Grid& grid, const std::string& name);

struct ExactTriangle
{
  std::array<Fixed3, 3> corner;
  std::array<Wide, 3> normal;

  explicit ExactTriangle(const std::array<Fixed3, 3>& corners);

  /// Whether the triangle has no area. Nothing crosses such a triangle.
  bool degenerate() const;

  /// Which side of the plane a position is on, 1 or -1; 0 only for degenerate triangles.
  int side(const Fixed3& place) const;

  /// Whether the line through a position along a direction meets the triangle. The direction must not be parallel to
  /// its plane.
  bool meetsLine(const Fixed3& place, const Fixed3& along) const;

  /// Whether the segment between two positions crosses the triangle.
  bool crosses(const Fixed3& from, const Fixed3& to) const;
};

}
