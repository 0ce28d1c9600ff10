#pragma once

#include "RigidClusters.h"
#include "SweepSchedule.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// What the sweeps of a relaxation are for.
enum class Reach
{
  Far, ///< to carry what handles do from element to element
  Near ///< to smooth what is rough: coarser grids have done the rest
};

/// Three-colour projected over-relaxation (relax.cl, clusters.cl). A sweep has a colour pass for red elements, one for
/// black elements and one for rigid clusters.
///
/// Only bricks in which something can change are visited. A feasible state stays feasible and its energy does not rise.
/// In a state that is not feasible, as while waves are under way, elements whose boxes have no common point stay where
/// they are. Elasticity::limited says whether there are boxes at all.
class Relaxation
{
public:
  explicit Relaxation(Bricks& bricks);

  /// Relaxes. While waves are under way rigid clusters stay where they are.
  RelaxResult run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves, Reach reach,
    int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint);

private:
  void relaxColour(
    int colour, bool turns, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves);
  bool isSmall() const;
  void relaxBatch(const RigidClusters& clusters, float still, const Elasticity& elasticity);
  float turnOfGroups(RigidClusters& clusters, const Elasticity& elasticity, float still, bool atRest);

  Bricks& bricks_;
  SweepSchedule schedule_;
  SharedTable batch_;   ///< turns that one launch takes, see relaxBatch()
  int groupPeriod_ = 0; ///< sweeps between the turns of blocked groups
  int sweepsSinceGroups_ = 0;
};

}
