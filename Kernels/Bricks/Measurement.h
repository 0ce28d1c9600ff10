#pragma once

#include "Bricks.h"
#include "Elasticity.h"

namespace chainmail
{

/// Figures of one brick (measure.cl); those of a brick at rest that were not taken are 0.
struct BrickFigures
{
  float energy[3];
  float excess;
  float displaced;
  float low[3];
  float firstRow[2]; ///< y and z of the rows that hold displaced elements; from infinity to minus infinity without any
  float high[3];
  float lastRow[2];
};

/// Figures of all slots from 1 on.
std::vector<BrickFigures> measureBricks(Bricks& bricks, const Elasticity& elasticity = {});

}
