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
constexpr int mostCorrections = 3;

/// The last correction is one of which a smaller share is kept.
constexpr double leastKept = 0.25;

}

void MultiscaleRelaxation::tissueChanged()
{
  this->coarseToFine_.forget();
  this->restart(true);
}

RelaxResult MultiscaleRelaxation::run(const RelaxationTask& task)
{
  RigidClusters& clusters = task.clusters();
  bool coarse = false;
  if (this->sweep_ == 0)
  {
    coarse = this->startsCoarse_ && this->mayStartCoarse_ && !task.waves &&
             this->coarseToFine_.run(clusters, task.elasticity, task.tolerance, [&] { task.checkpoint(0); });
    this->range_ = coarse ? Range::Near : Range::Far;
  }
  RelaxResult result;
  const auto sweep = [&](int most)
  {
    const RelaxResult before = result;
    clusters.begin(this->handles_.voxels(), this->handles_.rotatingVoxels());
    result = this->relaxation_.run(clusters, task.elasticity, task.waves, this->range_, this->sweep_, most,
      task.tolerance, [&](int done) { task.checkpoint(before.iterations + done); });
    this->sweep_ += result.iterations;
    result.iterations += before.iterations;
    result.coarseStep = before.coarseStep;
  };
  if (coarse)
  {
    sweep(std::min(task.iterations, CoarseToFine::sweepsToJudge));
    result.coarseStep = this->coarseToFine_.judge(task.elasticity);
    this->range_ = result.coarseStep > 0.0 ? Range::Near : Range::Far;
    result.converged = result.converged && result.coarseStep == 1.0;
    double kept = *result.coarseStep;
    for (int n = 0; n < mostCorrections && kept >= leastKept && !result.converged &&
                    task.iterations - result.iterations >= sweepsOfCorrection + sweepsBetween;
         ++n)
    {
      const std::optional<double> share =
        this->coarseToFine_.correct(clusters, task.elasticity, [&] { task.checkpoint(result.iterations); });
      if (!share)
      {
        break;
      }
      kept = *share;
      result.iterations += sweepsOfCorrection;
      this->sweep_ = 0; // roughness is what is left now, so the plan of sweeps begins anew
      sweep(sweepsBetween);
    }
  }
  if (result.iterations < task.iterations && !result.converged)
  {
    sweep(task.iterations - result.iterations);
  }
  result.converged = result.converged && !task.waves;
  return result;
}

}
