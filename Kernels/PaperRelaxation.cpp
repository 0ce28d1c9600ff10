#include "PaperRelaxation.h"

#include <algorithm>
#include <cstring>

namespace chainmail
{

float PaperRelaxation::relaxAll(float still, const Elasticity& elasticity, const WavesUnderWay* waves)
{
  std::vector<int> list = this->active_.pending();
  for (int& entry : list)
  {
    entry = this->bricks_.slot(entry);
  }
  if (list.empty())
  {
    return 0.0f;
  }
  Context& context = this->bricks_.context();
  std::vector<cl_int2> result(list.size());
  const cl::Buffer& resultBuffer = this->result_.sized(context, sizeof(cl_int2) * result.size());
  const std::string defines = this->bricks_.defines(true) + elasticity.defines() + (waves ? " -DWAVES" : "");
  cl::Kernel kernel = context.kernel("paper.cl", defines, "relaxAll");
  int argument = 0;
  kernel.setArg(argument++, this->list_.holding(context, list));
  kernel.setArg(argument++, still);
  kernel.setArg(argument++, elasticity.slack);
  kernel.setArg(argument++, this->bricks_.pitch());
  this->bricks_.bindTable(kernel, argument);
  kernel.setArg(argument++, this->bricks_.displacement);
  kernel.setArg(argument++, this->next_.buffer);
  kernel.setArg(argument++, this->bricks_.constraint);
  kernel.setArg(argument++, this->bricks_.cutsOrNothing());
  kernel.setArg(argument++, resultBuffer);
  if (waves)
  {
    waves->bind(kernel, argument);
  }
  context.runGroups(kernel, list.size(), this->bricks_.workItems(true));
  context.read(resultBuffer, result);

  // A brick leaves the list after an iteration in which nothing in it moved: both copies of it are then the same.
  std::swap(this->bricks_.displacement, this->next_.buffer);

  float largest = 0.0f;
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    float move;
    std::memcpy(&move, &result[n].s[1], sizeof(move));
    largest = std::max(largest, move);
    this->active_.note(list[n], result[n].s[0]);
  }
  return largest;
}

RelaxResult PaperRelaxation::run(const Elasticity& elasticity, const WavesUnderWay* waves, int iterations,
  double tolerance, const std::function<void(int)>& checkpoint)
{
  this->bricks_.keep(this->next_);
  this->bricks_.context().queue().enqueueCopyBuffer(
    this->bricks_.displacement, this->next_.buffer, 0, 0, sizeof(float) * 3 * this->bricks_.pitch());
  this->active_.begin();
  const float still = stillResidual(tolerance);

  RelaxResult result;
  while (result.iterations < iterations && !result.converged)
  {
    checkpoint(result.iterations);
    this->active_.advance();
    result.largestMove = this->relaxAll(still, elasticity, waves);
    ++result.iterations;
    result.converged = result.largestMove <= tolerance;
  }
  return result;
}

}
