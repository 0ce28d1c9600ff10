#pragma once

#include "RigidClusters.h"
#include "SweepSchedule.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// What a relaxation has to do.
enum class Reach
{
  Far, ///< carry what handles do, from element to element
  Near ///< mend what is rough: coarser grids have done the rest
};

/// Three-colour projected over-relaxation (relax.cl, clusters.cl): red elements, black elements, rigid clusters.
///
/// Only active bricks are visited. The state must be feasible: then it stays so and the energy does not rise. Where it
/// is not, as while waves are under way, elements whose boxes have no common point stay; Elasticity::limited says
/// whether there are boxes.
class Relaxation
{
public:
  explicit Relaxation(Bricks& bricks)
    : bricks_(bricks)
    , schedule_(bricks)
  {
  }

  /// Where waves are under way rigid clusters stay.
  RelaxResult run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves, Reach reach,
    int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint);

private:
  void relaxColour(int colour, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves);

  Bricks& bricks_;
  SweepSchedule schedule_;
  int groupPeriod_ = 0; ///< sweeps between turns of blocked groups
  int sweepsSinceGroups_ = 0;
};

}
