#pragma once

#include "Bricks.h"
#include "Elasticity.h"

namespace chainmail
{

/// Figures of one brick (measure.cl). All are 0 for a brick at rest that was not measured.
struct BrickFigures
{
  float energy[3];
  float excess;
  float displaced;
  float low[3];
  float firstRow[2]; ///< y and z of the rows that hold displaced elements; infinity to minus infinity without any
  float high[3];
  float lastRow[2];
};

/// The figures of all slots from 1 on: element n is for slot n + 1.
std::vector<BrickFigures> measureBricks(Bricks& bricks, const Elasticity& elasticity = {});

/// The energy of the whole state [mm], from these figures.
double energyOf(const Bricks& bricks, const std::vector<BrickFigures>& figures);

}
