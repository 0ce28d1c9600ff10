#pragma once

#include "Bricks.h"

namespace chainmail
{

/// Figures of one brick (measure.cl).
struct BrickFigures
{
  float energy[3];
  float excess;
  float displaced;
  float low[3];
  float high[3];
};

/// Figures of all slots from 1 on.
std::vector<BrickFigures> measureBricks(Bricks& bricks);

}
