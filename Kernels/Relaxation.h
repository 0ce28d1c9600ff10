#pragma once

#include "ActiveBricks.h"
#include "RigidClusters.h"
#include "Simulation.h"

#include <functional>

namespace chainmail
{

/// Waves of Timestamp that have not come to their ends: an element may relax, on an axis, where it did not move in this
/// iteration and belongs to the same wavefront as all that it is linked to.
struct WavesUnderWay
{
  const cl::Buffer* front = nullptr; ///< int [axis][address], `axes()` runs: number of the wavefront
  const cl::Buffer* stamp = nullptr; ///< int [axis][address]: iteration in which the element was last moved by a wave
  int iteration = 0;                 ///< the present one

  /// Sets the arguments WAVES_ARGUMENTS of waves.clh.
  void bind(cl::Kernel& kernel, int& argument) const;
};

/// What a relaxation has to do.
enum class Reach
{
  Far, ///< carry what hands do, from element to element
  Near ///< mend what is rough: coarser grids have done the rest
};

/// Residuals up to this are left alone at a tolerance, so that a deformation ends somewhere, far from the hand.
float stillResidual(double tolerance);

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
    , active_(bricks)
  {
  }

  /// Where waves are under way rigid clusters stay.
  RelaxResult run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves, Reach reach,
    int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint);

private:
  void relaxColour(int colour, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves);

  Bricks& bricks_;
  ActiveBricks active_;
  int groupPeriod_ = 0; ///< sweeps between turns of tight groups
  int sweepsSinceGroups_ = 0;
};

}
