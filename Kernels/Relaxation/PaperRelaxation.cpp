#include "PaperRelaxation.h"

#include "Pass.h"
#include "StillResidual.h"

#include <algorithm>

namespace chainmail
{

namespace
{

/// Iterations in one batch of launches.
constexpr int iterationsPerBatch = 16;

}

/// Launches one iteration. `back`: it reads the second copy of the state and writes the first.
void PaperRelaxation::relaxAll(const RelaxationTask& task, int iteration, bool back, float still)
{
  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(true) + task.elasticity.defines() + this->bricks_.ofSoftLinks() +
                              (task.waves ? " -DWAVES" : "");
  launchPass(this->bricks_, context.kernel("paper.cl", defines, "relaxAll"), this->schedule_.groups(),
    this->bricks_.workItems(true), this->schedule_,
    this->bricks_.stateWith(
      back ? this->next_.buffer : this->bricks_.displacement(), this->bricks_.rotations(), this->bricks_.softLinks()),
    static_cast<cl_int>(iteration % 2), still, task.elasticity.slack,
    back ? this->bricks_.displacement() : this->next_.buffer, task.waves);
}

RelaxResult PaperRelaxation::run(const RelaxationTask& task)
{
  this->bricks_.addField(this->next_);
  this->bricks_.context().queue().enqueueCopyBuffer(
    this->bricks_.displacement(), this->next_.buffer, 0, 0, sizeof(float) * 3 * this->bricks_.pitch());
  this->schedule_.begin({});
  const float still = stillResidual(task.tolerance);

  RelaxResult result;
  int launched = 0;
  while (result.iterations < task.iterations && !result.converged)
  {
    const int batch = std::min(iterationsPerBatch, task.iterations - result.iterations);
    this->schedule_.beginBatch(batch);
    for (int n = 0; n < batch; ++n)
    {
      const int iteration = result.iterations + n;
      launched = std::max(launched, iteration);
      task.checkpoint(launched);
      this->schedule_.beginSweep(static_cast<float>(task.tolerance));
      if (this->schedule_.takesPass(iteration % 2))
      {
        this->relaxAll(task, iteration, n % 2 == 1, still);
      }
    }
    const std::vector<float> moves = this->schedule_.endBatch();
    if (moves.size() % 2 == 1)
    {
      this->bricks_.swapDisplacements(this->next_);
    }
    result.iterations += static_cast<int>(moves.size());
    if (!moves.empty())
    {
      result.largestMove = moves.back();
      result.converged = moves.back() <= task.tolerance;
    }
  }
  this->schedule_.markDirty();
  return result;
}

}
