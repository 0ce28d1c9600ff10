#include "MultiscaleRelaxation.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// A correction counts as so many sweeps, because it takes about as long. So a limit to the number of sweeps limits the
/// time, whatever the sweeps are spent on.
constexpr int sweepsOfCorrection = 12;

/// Further corrections find less than sweeps do: what is left is near limits of links.
constexpr int mostCorrections = 6;

/// The last correction is one of which a smaller share is kept.
constexpr double leastKept = 0.25;

/// How far a state is from the optimum is estimated from how far a correction, or a round of sweeps, has just moved it.
/// Pulls at random in scans were 0.2 to 0.9 times as far from it after the first correction, if that moved them by more
/// than 0.5 %, 0.2 to 0.6 times after such a further one, and 0.2 to 2.5 times after most rounds.
constexpr double timesFirst = 0.65;
constexpr double timesFurther = 0.45;
constexpr double timesRound = 2.0;

/// Where blocked groups of elements move slowly, no change shows how far they have to go, but the energy still falls,
/// and it is quadratic in the distance. The distance of most pulls was 0.02 to 0.15 times the root of the share of the
/// energy that the last correction and the sweeps after it had removed.
constexpr double timesRootOfDrop = 0.07;

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
    this->distance_ = std::numeric_limits<double>::infinity();
    const bool coarse = this->startsCoarse_ && this->mayStartCoarse_ && !task.waves &&
                        this->coarseToFine_.run(clusters, task.elasticity, task.tolerance, [&] { task.checkpoint(0); });
    this->range_ = coarse ? Range::Near : Range::Far;
    if (coarse)
    {
      this->sweep(task, clusters, CoarseToFine::sweepsToJudge, result);
      const CoarseToFine::Judgement judgement = this->coarseToFine_.judge(task.elasticity);
      result.coarseStep = judgement.kept;
      result.coarseDrop = judgement.drop;
      this->range_ = result.coarseStep > 0.0 ? Range::Near : Range::Far;
      result.converged = result.converged && result.coarseStep == 1.0;
      if (result.coarseStep >= leastKept && this->coarseToFine_.corrects(clusters, task.elasticity))
      {
        this->correct(task, clusters, judgement.energy, result);
      }
    }
  }
  while (result.iterations < task.iterations && !result.converged && !this->isNear(task))
  {
    if (task.error > 0.0 && this->range_ == Range::Near)
    {
      this->sweepRound(task, clusters, result);
    }
    else
    {
      this->sweep(task, clusters, task.iterations, result);
    }
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

/// Corrects the state after a start on coarser grids, as long as that helps. Where rigid clusters can move, the opening
/// sweeps come before, which are often enough. `energy`: of the state.
void MultiscaleRelaxation::correct(
  const RelaxationTask& task, RigidClusters& clusters, double energy, RelaxResult& result)
{
  if (clusters.anyFree() && !result.converged && result.iterations < task.iterations)
  {
    this->sweepRound(task, clusters, result);
    energy = this->coarseToFine_.energy(task.elasticity);
  }
  const double enough = task.error > 0.0 ? task.error : leastShown; // from there on sweeps find more
  double kept = 1.0;
  double shown = this->distance_; // of what corrections find
  for (int n = 0;
       n < mostCorrections && kept >= leastKept && shown > enough && !this->isNear(task) && !result.converged &&
       task.iterations - result.iterations >= sweepsOfCorrection + CoarseToFine::sweepsToJudge;
       ++n)
  {
    this->coarseToFine_.correct(clusters, task.elasticity, energy, [&] { task.checkpoint(result.iterations); });
    result.iterations += sweepsOfCorrection;
    this->sweep_ = 0; // roughness is what is left now, so the plan of sweeps begins anew
    this->sweep(task, clusters, CoarseToFine::sweepsToJudge, result);
    const CoarseToFine::Judgement judgement = this->coarseToFine_.judge(task.elasticity);
    kept = judgement.kept;
    energy = judgement.energy;
    result.converged = result.converged && kept == 1.0;
    if (kept >= leastKept)
    {
      shown = std::max((n == 0 ? timesFirst : timesFurther) / kept * this->start_.change(),
        timesRootOfDrop * std::sqrt(std::max(0.0, judgement.drop)));
      this->distance_ = std::max(leastShown, shown);
    }
  }
}

/// Sweeps to the end of a round, after coarser grids.
void MultiscaleRelaxation::sweepRound(const RelaxationTask& task, RigidClusters& clusters, RelaxResult& result)
{
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
