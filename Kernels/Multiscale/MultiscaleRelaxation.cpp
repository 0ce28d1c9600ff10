#include "MultiscaleRelaxation.h"

#include <algorithm>

namespace chainmail
{

namespace
{

/// A correction counts as so many sweeps, because it takes about as long. So a limit to the number of sweeps limits the
/// time, whatever the sweeps are spent on.
constexpr int sweepsOfCorrection = 12;

/// Sweeps between two corrections.
constexpr int sweepsBetween = 4;

/// Further corrections find less than sweeps do: what is left is near limits of links.
constexpr int mostCorrections = 6;

/// The last correction is one of which a smaller share is kept.
constexpr double leastKept = 0.25;

/// How far a state is from the optimum is estimated from how far a correction, or a round of sweeps, has just moved it.
/// Pulls at random in scans were 0.1 to 1.2 times as far from it after corrections that moved them by more than 0.5 %,
/// and 0.2 to 2.5 times after most rounds. Where blocked groups of elements move slowly, nothing shows how far they
/// have to go.
constexpr double timesCorrection = 0.8;
constexpr double timesRound = 2.0;

/// Neither a correction nor the opening sweeps show a smaller distance than this. What they leave is near limits of
/// links, and only longer rounds move it.
constexpr double leastShown = 0.005;

/// Calls release() in the end, also where a relaxation is stopped.
template <typename T> struct ReleasedAtEnd
{
  ~ReleasedAtEnd() { released.release(); }
  T& released;
};

}

void MultiscaleRelaxation::tissueChanged()
{
  this->coarseToFine_.forget();
  this->restart(true);
}

RelaxResult MultiscaleRelaxation::run(const RelaxationTask& task)
{
  RigidClusters& clusters = task.clusters();
  RelaxResult result;
  if (this->sweep_ > 0 && this->isNear(task))
  {
    result.converged = true;
    return result;
  }
  const ReleasedAtEnd<CoarseToFine> released{ this->coarseToFine_ };
  if (this->sweep_ == 0)
  {
    const bool coarse = this->startsCoarse_ && this->mayStartCoarse_ && !task.waves &&
                        this->coarseToFine_.run(clusters, task.elasticity, task.tolerance, [&] { task.checkpoint(0); });
    this->range_ = coarse ? Range::Near : Range::Far;
    if (coarse)
    {
      this->sweep(task, clusters, CoarseToFine::sweepsToJudge, result);
      result.coarseStep = this->coarseToFine_.judge(task.elasticity);
      this->range_ = result.coarseStep > 0.0 ? Range::Near : Range::Far;
      result.converged = result.converged && result.coarseStep == 1.0;
      this->correct(task, clusters, result);
    }
  }
  while (result.iterations < task.iterations && !result.converged && !this->isNear(task))
  {
    this->sweepRound(task, clusters, result);
  }
  result.converged = (result.converged || this->isNear(task)) && !task.waves;
  return result;
}

/// Adds at most `most` sweeps to the result.
void MultiscaleRelaxation::sweep(const RelaxationTask& task, RigidClusters& clusters, int most, RelaxResult& result)
{
  clusters.begin(this->handles_.voxels(), this->handles_.rotatingVoxels());
  const RelaxResult sweeps = this->relaxation_.run(clusters, task.elasticity, task.waves, this->range_, this->sweep_,
    std::min(most, task.iterations - result.iterations), task.tolerance,
    [&](int done) { task.checkpoint(result.iterations + done); });
  this->sweep_ += sweeps.iterations;
  result.iterations += sweeps.iterations;
  result.largestMove = sweeps.largestMove;
  result.converged = sweeps.converged;
}

/// Corrects the state after a start on coarser grids, as long as that helps.
void MultiscaleRelaxation::correct(const RelaxationTask& task, RigidClusters& clusters, RelaxResult& result)
{
  double kept = *result.coarseStep;
  double shown = std::numeric_limits<double>::infinity(); // the distance from the optimum, of what corrections find
  for (int n = 0; n < mostCorrections && kept >= leastKept && shown > task.error && !this->isNear(task) &&
                  !result.converged && task.iterations - result.iterations >= sweepsOfCorrection + sweepsBetween;
       ++n)
  {
    const std::optional<double> share =
      this->coarseToFine_.correct(clusters, task.elasticity, [&] { task.checkpoint(result.iterations); });
    if (!share)
    {
      return;
    }
    kept = *share;
    result.iterations += sweepsOfCorrection;
    this->sweep_ = 0; // roughness is what is left now, so the plan of sweeps begins anew
    this->sweep(task, clusters, sweepsBetween, result);
    if (task.error > 0.0 && kept >= leastKept)
    {
      shown = timesCorrection / kept * this->start_.change();
      this->distance_ = std::max(leastShown, shown);
    }
  }
}

/// Sweeps to the end of a round. Where no distance is asked for, or sweeps are not in rounds, makes all of them.
void MultiscaleRelaxation::sweepRound(const RelaxationTask& task, RigidClusters& clusters, RelaxResult& result)
{
  if (task.error == 0.0 || this->range_ == Range::Far)
  {
    this->sweep(task, clusters, task.iterations, result);
    return;
  }
  const bool opening = this->sweep_ < SweepPlan::roundsEnd(0);
  const int end = SweepPlan::roundsEnd(this->sweep_);
  this->start_.save();
  this->sweep(task, clusters, end - this->sweep_, result);
  if (this->sweep_ == end)
  {
    this->distance_ = std::max(opening ? leastShown : 0.0, timesRound * this->start_.change());
  }
}

}
