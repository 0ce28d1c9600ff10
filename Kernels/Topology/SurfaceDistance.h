#pragma once

#include "ExactGeometry.h"
#include "Places.h"

#include <array>
#include <vector>

namespace chainmail
{

/// Gives grid points near a surface their signed distance from it (CutDistances): from the plane of the nearest
/// triangle, measured at their current places, and positive where the triangle's normal points.
void addSurfaceDistances(Bricks& bricks, const Places& places, const std::vector<Fixed3>& points,
  const std::vector<std::array<int, 3>>& triangles);

}
