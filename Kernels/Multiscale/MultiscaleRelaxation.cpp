#include "MultiscaleRelaxation.h"

#include <algorithm>

namespace chainmail
{

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
  }
  if (result.iterations < task.iterations && !result.converged)
  {
    sweep(task.iterations - result.iterations);
  }
  result.converged = result.converged && !task.waves;
  return result;
}

}
