#pragma once

#include "ExactGeometry.h"
#include "Places.h"

#include <array>
#include <vector>

namespace chainmail
{

/// Gives the grid points near a surface, in and around the bricks that it cuts, their signed distance from it
/// (CutDistances): from the plane of the nearest triangle, measured at their current places, and positive where the
/// triangle's normal points. Where a surface is flat this is exact, also beyond its edges.
void setSurfaceDistances(Bricks& bricks, const std::vector<int>& cutBricks, const Places& places,
  const std::vector<Fixed3>& points, const std::vector<std::array<int, 3>>& triangles);

}
