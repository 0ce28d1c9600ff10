#pragma once

#include "Block.h"

#include <algorithm>
#include <cmath>

namespace oracle
{

/// The result of a simple test of a segment against a triangle. `margin` is the distance to the nearest other result:
/// the least change of a barycentric or segment parameter that reverses the decision.
struct Crossing
{
  bool crosses = false;
  double margin = std::numeric_limits<double>::infinity();
};

inline Vector3 minus(const Vector3& a, const Vector3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}
inline Vector3 cross(const Vector3& a, const Vector3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}
inline double dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Intersects the segment's line with the triangle's plane: t along the segment, barycentric v and w, in double
/// precision. For surfaces in general position; ties are not handled.
inline Crossing crossing(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b, const Vector3& c)
{
  const Vector3 direction = minus(q, p), e1 = minus(b, a), e2 = minus(c, a);
  const Vector3 h = cross(direction, e2);
  const double determinant = dot(e1, h);
  if (determinant == 0.0)
  {
    return {};
  }
  const Vector3 s = minus(p, a);
  const Vector3 r = cross(s, e1);
  const double v = dot(s, h) / determinant;
  const double w = dot(direction, r) / determinant;
  const double t = dot(e2, r) / determinant;
  // They cross where all five are positive.
  const double least = std::min({ v, w, 1.0 - v - w, t, 1.0 - t });
  return { least > 0.0, std::abs(least) };
}

/// Removes the links whose segment between the current places of their elements crosses a triangle. Returns the margin
/// of each decision (see Crossing), per voxel and direction.
inline std::vector<Vector3> cut(Block& block, const std::vector<Vector3>& state, const std::vector<Vector3>& points,
  const std::vector<std::array<int, 3>>& triangles)
{
  const auto place = [&](std::size_t voxel)
  {
    const Index3 p = block.index(voxel);
    Vector3 x;
    for (int a = 0; a < 3; ++a)
    {
      x[a] = block.spacing[a] * (p[a] + state[voxel][a]);
    }
    return x;
  };
  std::vector<Vector3> margin(block.count(), Vector3{ 1.0, 1.0, 1.0 });
  for (const Link& link : links(block))
  {
    const Vector3 p = place(link.from), q = place(link.to);
    bool crosses = false;
    double sure = 1.0, unsure = 1.0;
    for (const auto& t : triangles)
    {
      const Crossing one = crossing(p, q, points[t[0]], points[t[1]], points[t[2]]);
      if (one.crosses)
      {
        sure = crosses ? std::max(sure, one.margin) : one.margin;
        crosses = true;
      }
      else
      {
        unsure = std::min(unsure, one.margin);
      }
    }
    // One crossing is enough, so the largest of their margins counts. Without a crossing the smallest margin counts.
    margin[link.from][link.direction] = crosses ? sure : unsure;
    if (crosses)
    {
      block.cut[link.from] |= static_cast<std::uint8_t>(1u << link.direction);
    }
  }
  return margin;
}

/// The links of every voxel as six bits: x-, x+, y-, y+, z-, z+.
inline std::vector<std::uint8_t> linkBits(const Block& block)
{
  std::vector<std::uint8_t> bits(block.count(), 0);
  for (const Link& link : links(block))
  {
    bits[link.from] |= static_cast<std::uint8_t>(2u << (2 * link.direction));
    bits[link.to] |= static_cast<std::uint8_t>(1u << (2 * link.direction));
  }
  return bits;
}

}
