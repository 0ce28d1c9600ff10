#pragma once

#include "ExactGeometry.h"
#include "Places.h"

#include <array>
#include <vector>

namespace chainmail
{

/// Gives grid points near a surface their signed distance from it (CutDistances). The distance is that from the plane
/// of the nearest triangle, at the current positions of the grid points. It is positive on the side to which the
/// triangle's normal points.
void addSurfaceDistances(Bricks& bricks, const Places& places, const std::vector<Fixed3>& points,
  const std::vector<std::array<int, 3>>& triangles);

}
