#pragma once

#include "RigidClusters.h"
#include "SweepPlan.h"
#include "SweepSchedule.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// Three-colour projected over-relaxation (relax.cl, clusters.cl). A sweep has a colour pass for red elements, one for
/// black elements and one for rigid clusters.
///
/// Only bricks in which something can change are visited. A feasible state stays feasible and its energy does not rise.
/// In an infeasible state, for example while waves are under way, elements whose boxes have no common point do not
/// move. Elasticity::limited says whether boxes apply at all.
class Relaxation
{
public:
  explicit Relaxation(Bricks& bricks);

  /// Relaxes by at most `iterations` sweeps. `firstSweep`: the number of sweeps already done. While waves are under
  /// way, rigid clusters do not move.
  RelaxResult run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves, Range range,
    int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint);

private:
  struct Run;

  void addSweep(const Run& run, int sweep, float stopThreshold, bool inOneLaunch);
  void relaxColour(const Run& run, int colour, int sweep);
  bool fitsOneLaunch() const;
  void relaxBatch(const Run& run);
  float restingMoveAfter(const Run& run, int sweeps) const;
  float activeSetStep(const Run& run, bool atRest);

  Bricks& bricks_;
  SweepSchedule schedule_;
  SharedTable batch_;       ///< passes of one launch, see relaxBatch()
  int activeSetPeriod_ = 0; ///< sweeps between active-set steps, see activeSetStep()
  int sweepsSinceActiveSet_ = 0;
};

}
