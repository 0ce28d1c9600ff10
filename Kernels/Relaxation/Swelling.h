#pragma once

#include "Bricks.h"

#include <vector>

namespace chainmail
{

/// Brings the tension of elements (swelling.clh) up to date in these slots and beside them, which become ready: after
/// anything but a relaxation has moved them. Does nothing where Poisson's ratio is 0. Where there is the activity of a
/// relaxation's sweeps (sweep.clh), with a row for every slot, bricks with tension are noted in it, in this sweep.
void updateTensionAround(
  Bricks& bricks, const std::vector<int>& slots, const cl::Buffer* activity = nullptr, int sweep = 0);

}
