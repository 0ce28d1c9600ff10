#include "Relaxation.h"

#include "TightGroups.h"

#include <algorithm>
#include <cstring>

namespace chainmail
{

namespace
{

/// Where chains of links at their limits block each other, sweeps come to rest above the optimum, or creep there: then
/// the groups of such links get turns. Twice as often after each turn that is worth it, as it moves them by this share
/// of what the sweep moved; half as often, down to once in so many sweeps, after any other one; and before a relaxation
/// counts as converged. A short one, of a tissue that is all at its limits as a wave has left it, has none.
constexpr int longestGroupPeriod = 32;
constexpr float worthATurn = 0.03f;

/// Over-relaxation of a sweep: Chebyshev's sequence, which starts at 1 (best for the first few sweeps, where most
/// energy goes) and rises to finalOmega (best for long ones).
float omegaOf(int sweep)
{
  constexpr double finalOmega = 1.9; // = 2 / (1 + sqrt(1 - rho2))
  constexpr double rho2 = 1.0 - (2.0 / finalOmega - 1.0) * (2.0 / finalOmega - 1.0);
  double omega = 1.0;
  for (int s = 0; s < sweep && s < 200; ++s)
  {
    omega = s == 0 ? 1.0 / (1.0 - rho2 / 2.0) : 1.0 / (1.0 - rho2 * omega / 4.0);
  }
  return static_cast<float>(omega);
}

}

float stillResidual(double tolerance)
{
  return static_cast<float>(tolerance / 64.0);
}

void WavesUnderWay::bind(cl::Kernel& kernel, int& argument) const
{
  kernel.setArg(argument++, *this->front);
  kernel.setArg(argument++, *this->stamp);
  kernel.setArg(argument++, static_cast<cl_int>(this->iteration));
}

/// Something moved somewhere in these bricks.
void Relaxation::note(const std::vector<int>& bricks)
{
  for (const int brick : bricks)
  {
    this->active_.note(this->bricks_.slot(brick), ActiveBricks::everyFace);
  }
}

float Relaxation::relaxColour(
  int colour, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves)
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
  cl::Kernel kernel = context.kernel("relax.cl", defines, "relax");
  int argument = 0;
  kernel.setArg(argument++, this->list_.holding(context, list));
  kernel.setArg(argument++, static_cast<cl_int>(colour));
  kernel.setArg(argument++, omega);
  kernel.setArg(argument++, still);
  kernel.setArg(argument++, elasticity.slack);
  kernel.setArg(argument++, this->bricks_.pitch());
  this->bricks_.bindTable(kernel, argument);
  kernel.setArg(argument++, this->bricks_.displacement);
  kernel.setArg(argument++, this->bricks_.constraint);
  kernel.setArg(argument++, this->bricks_.cutsOrNothing());
  kernel.setArg(argument++, resultBuffer);
  if (waves)
  {
    waves->bind(kernel, argument);
  }
  const std::size_t items = this->bricks_.workItems(true);
  context.runGroups(kernel, list.size(), items);
  context.read(resultBuffer, result);

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

RelaxResult Relaxation::run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves,
  int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint)
{
  this->active_.begin();
  const float still = stillResidual(tolerance);

  if (firstSweep == 0)
  {
    this->groupPeriod_ = longestGroupPeriod;
    this->sweepsSinceGroups_ = 0;
  }
  RelaxResult result;
  while (result.iterations < iterations && !result.converged)
  {
    checkpoint(result.iterations);
    const float omega = omegaOf(firstSweep + result.iterations);
    float largest = 0.0f;
    for (int colour = 0; colour < 2; ++colour)
    {
      this->active_.advance();
      largest = std::max(largest, this->relaxColour(colour, omega, still, elasticity, waves));
    }

    this->active_.advance();
    if (!waves)
    {
      // Clusters take part before any of their neighbours can have moved: from the moment something moves in their
      // brick or beside it.
      clusters.activate(this->active_.pending());
      std::vector<int> moved;
      largest = std::max(largest, clusters.relax(omega, still, elasticity, moved));
      this->note(moved);

      ++this->sweepsSinceGroups_;
      if (largest <= tolerance || this->sweepsSinceGroups_ >= this->groupPeriod_)
      {
        this->sweepsSinceGroups_ = 0;
        moved.clear();
        const float ofGroups = moveTightGroups(this->bricks_, clusters, elasticity, still, moved);
        this->groupPeriod_ = ofGroups > worthATurn * largest ? std::max(1, this->groupPeriod_ / 2)
                                                             : std::min(longestGroupPeriod, 2 * this->groupPeriod_);
        largest = std::max(largest, ofGroups);
        this->note(moved);
        clusters.refresh();
      }
    }

    ++result.iterations;
    result.largestMove = largest;
    result.converged = largest <= tolerance;
  }
  return result;
}

}
