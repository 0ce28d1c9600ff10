#pragma once

#include "Bricks.h"

#include <vector>

namespace chainmail
{

/// Recomputes the pressure of elements (volumetricstrain.clh) in these slots and those that share a face with them. To
/// be called after anything except a relaxation has moved elements. Makes all these bricks updatable. Does nothing if
/// Poisson's ratio is 0. `activity`: the table of a relaxation's sweeps (sweepaccount.clh) with a row for every slot,
/// or null. Bricks with pressure, now or before, are noted in it as moved in sweep `sweep`.
void updatePressureAround(
  Bricks& bricks, const std::vector<int>& slots, const cl::Buffer* activity = nullptr, int sweep = 0);

}
