#include "Relaxation.h"

#include "TightGroups.h"

#include <algorithm>
#include <cstring>

namespace chainmail
{

namespace
{

/// Turns of a sweep: red, black, clusters.
constexpr int turnsPerSweep = 3;

/// Residuals below this share of the tolerance are left alone: far from the hand a deformation then ends somewhere.
constexpr double stillShare = 1.0 / 64.0;

/// Sweeps that move nothing further than this have come to rest, be it at the optimum or because chains of links at
/// their limits block each other: then the groups of such links get a turn, at most once in so many sweeps.
constexpr float restingMove = 1e-3f;
constexpr int sweepsPerGroupTurn = 8;

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

void Relaxation::note(int slot, int faces)
{
  if (faces == 0)
  {
    return;
  }
  this->bricks_.touch(slot);
  Activity& activity = this->activity_[slot];
  activity.any = this->turn_;
  for (int d = 0; d < 6; ++d)
  {
    if (faces & (1 << d))
    {
      activity.face[d] = this->turn_;
    }
  }
}

std::vector<int> Relaxation::pending()
{
  // Since the last turn of the same colour.
  const int since = this->turn_ - turnsPerSweep;
  std::vector<int> bricks;
  for (int slot = 1; slot < this->bricks_.slots(); ++slot)
  {
    const int brick = this->bricks_.brick(slot);
    bool active = this->activity_[slot].any >= since;
    for (int d = 0; !active && d < 6; ++d)
    {
      const int near = this->bricks_.slot(this->bricks_.neighbour(brick, d));
      active = near > 0 && this->activity_[near].face[Bricks::opposite(d)] >= since;
    }
    if (active)
    {
      bricks.push_back(brick);
    }
  }
  this->bricks_.require(bricks);
  this->activity_.resize(this->bricks_.slots());
  return bricks;
}

float Relaxation::relaxColour(int colour, float omega, float still)
{
  std::vector<int> list = this->pending();
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
  cl::Kernel kernel = context.kernel("relax.cl", this->bricks_.defines(true), "relax");
  int argument = 0;
  kernel.setArg(argument++, this->list_.holding(context, list));
  kernel.setArg(argument++, static_cast<cl_int>(colour));
  kernel.setArg(argument++, omega);
  kernel.setArg(argument++, still);
  kernel.setArg(argument++, this->bricks_.pitch());
  this->bricks_.bindTable(kernel, argument);
  kernel.setArg(argument++, this->bricks_.displacement);
  kernel.setArg(argument++, this->bricks_.constraint);
  kernel.setArg(argument++, this->bricks_.cutsOrNothing());
  kernel.setArg(argument++, resultBuffer);
  const std::size_t items = this->bricks_.workItems(true);
  context.runGroups(kernel, list.size(), items);
  context.read(resultBuffer, result);

  float largest = 0.0f;
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    float move;
    std::memcpy(&move, &result[n].s[1], sizeof(move));
    largest = std::max(largest, move);
    this->note(list[n], result[n].s[0]);
  }
  return largest;
}

RelaxResult Relaxation::run(
  RigidClusters& clusters, int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint)
{
  constexpr int everyFace = 127;
  this->turn_ = 0;
  this->activity_.assign(this->bricks_.slots(), Activity());
  for (int slot = 1; slot < this->bricks_.slots(); ++slot)
  {
    if (this->bricks_.touched(slot))
    {
      this->note(slot, everyFace);
    }
  }
  const float still = static_cast<float>(tolerance * stillShare);

  int sweepsSinceGroups = sweepsPerGroupTurn;
  RelaxResult result;
  while (result.iterations < iterations && !result.converged)
  {
    checkpoint(result.iterations);
    const float omega = omegaOf(firstSweep + result.iterations);
    float largest = 0.0f;
    for (int colour = 0; colour < 2; ++colour)
    {
      ++this->turn_;
      largest = std::max(largest, this->relaxColour(colour, omega, still));
    }

    // Clusters take part before any of their neighbours can have moved: from the moment something moves in their brick
    // or beside it.
    ++this->turn_;
    clusters.activate(this->pending());
    this->activity_.resize(this->bricks_.slots());
    std::vector<int> moved;
    largest = std::max(largest, clusters.relax(omega, still, moved));
    for (const int brick : moved)
    {
      this->note(this->bricks_.slot(brick), everyFace);
    }

    ++sweepsSinceGroups;
    if (largest <= std::max(restingMove, static_cast<float>(tolerance)) && sweepsSinceGroups >= sweepsPerGroupTurn)
    {
      sweepsSinceGroups = 0;
      moved.clear();
      largest = std::max(largest, moveTightGroups(this->bricks_, still, moved));
      this->activity_.resize(this->bricks_.slots());
      for (const int brick : moved)
      {
        this->note(this->bricks_.slot(brick), everyFace);
      }
      clusters.refresh();
    }

    ++result.iterations;
    result.largestMove = largest;
    result.converged = largest <= tolerance;
  }
  return result;
}

}
