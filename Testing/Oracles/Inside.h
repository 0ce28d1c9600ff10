#pragma once

#include "Block.h"
#include "Crossing.h"

#include <cmath>

namespace oracle
{

/// The winding number of a closed, consistently oriented surface around a place: the sum of the triangles' solid angles
/// over 4 pi. Source: Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207.
inline double winding(
  const Vector3& place, const std::vector<Vector3>& points, const std::vector<std::array<int, 3>>& triangles)
{
  double sum = 0.0;
  for (const std::array<int, 3>& ids : triangles)
  {
    const Vector3 a = minus(points[ids[0]], place), b = minus(points[ids[1]], place), c = minus(points[ids[2]], place);
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    sum += 2.0 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4.0 * std::acos(-1.0));
}

/// 1 inside (where the winding number is not 0), 0 outside, -1 within `margin` of a change between the two.
inline int inside(const Vector3& place, double margin, const std::vector<Vector3>& points,
  const std::vector<std::array<int, 3>>& triangles)
{
  int result = -2;
  for (int n = 0; n < 8; ++n)
  {
    Vector3 near = place;
    for (int a = 0; a < 3; ++a)
    {
      near[a] += (n >> a & 1) ? margin : -margin;
    }
    const int here = std::lround(winding(near, points, triangles)) != 0;
    result = result == -2 || result == here ? here : -1;
  }
  return result;
}

}
