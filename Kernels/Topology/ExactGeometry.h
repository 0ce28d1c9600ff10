#pragma once

#include "Types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace chainmail
{

/// Exact decisions about where elements are with respect to a surface of triangles. Places and surface are rounded to
/// 1/4096 voxel; from there all is done in 128-bit integers, and what the surface passes through exactly is decided as
/// if all tissue were shifted by an infinitesimal (e, e^2, e^3) (simulation of simplicity: Edelsbrunner and Muecke,
/// 1990). So neighbouring triangles leave no gap and count nothing twice.
using Wide = __int128;
using Fixed3 = std::array<std::int64_t, 3>;

constexpr double unitsPerVoxel = 4096.0;

/// A place [voxels], rounded.
Fixed3 fixed(const Vector3& voxel);

/// The points of a surface, rounded. Throws InputError, which calls the surface by `name`, where a point is not finite
/// or too far away for 128 bits, or a triangle names a point that does not exist.
std::vector<Fixed3> fixedPoints(const Surface& surface, const Grid& grid, const std::string& name);

struct ExactTriangle
{
  std::array<Fixed3, 3> corner;
  std::array<Wide, 3> normal;

  explicit ExactTriangle(const std::array<Fixed3, 3>& corners);

  /// Without area: nothing crosses it.
  bool degenerate() const;

  /// Which side of the plane a place is on, 1 or -1; 0 only for degenerate triangles.
  int side(const Fixed3& place) const;

  /// Whether the line through a place along a direction, not parallel to the plane, meets the triangle.
  bool meetsLine(const Fixed3& place, const Fixed3& along) const;

  /// Whether the segment between two places crosses the triangle.
  bool crosses(const Fixed3& from, const Fixed3& to) const;
};

}
