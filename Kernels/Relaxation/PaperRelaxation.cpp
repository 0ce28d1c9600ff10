#include "PaperRelaxation.h"

#include <algorithm>

namespace chainmail
{

namespace
{

/// Iterations that are launched in one go.
constexpr int iterationsPerBatch = 16;

}

/// `back`: from the second copy of the state to the first.
void PaperRelaxation::relaxAll(
  int iteration, bool back, float still, const Elasticity& elasticity, const WavesUnderWay* waves)
{
  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(true) + elasticity.defines() + (waves ? " -DWAVES" : "");
  context.launch(context.kernel("paper.cl", defines, "relaxAll"), this->schedule_.groups(),
    this->bricks_.workItems(true), this->schedule_, static_cast<cl_int>(iteration % 2), still, elasticity.slack,
    this->bricks_.layout(), back ? this->next_.buffer : this->bricks_.displacement,
    back ? this->bricks_.displacement : this->next_.buffer, this->bricks_.tissue(), waves);
}

RelaxResult PaperRelaxation::run(const Elasticity& elasticity, const WavesUnderWay* waves, int iterations,
  double tolerance, const std::function<void(int)>& checkpoint)
{
  this->bricks_.keep(this->next_);
  this->bricks_.context().queue().enqueueCopyBuffer(
    this->bricks_.displacement, this->next_.buffer, 0, 0, sizeof(float) * 3 * this->bricks_.pitch());
  this->schedule_.begin({});
  const float still = stillResidual(tolerance);

  RelaxResult result;
  int launched = 0;
  while (result.iterations < iterations && !result.converged)
  {
    const int batch = std::min(iterationsPerBatch, iterations - result.iterations);
    this->schedule_.beginBatch(batch);
    for (int n = 0; n < batch; ++n)
    {
      const int iteration = result.iterations + n;
      launched = std::max(launched, iteration);
      checkpoint(launched);
      this->schedule_.beginSweep(static_cast<float>(tolerance));
      if (this->schedule_.takesTurn(iteration % 2))
      {
        this->relaxAll(iteration, n % 2 == 1, still, elasticity, waves);
      }
    }
    const std::vector<float> moves = this->schedule_.endBatch();
    if (moves.size() % 2 == 1)
    {
      std::swap(this->bricks_.displacement, this->next_.buffer);
    }
    result.iterations += static_cast<int>(moves.size());
    if (!moves.empty())
    {
      result.largestMove = moves.back();
      result.converged = moves.back() <= tolerance;
    }
  }
  this->schedule_.touch();
  return result;
}

}
