#pragma once

#include "EnvelopePropagation.h"

namespace chainmail
{

/// Makes any state feasible (feasibility.cl). With d(i, j) the shortest path of links between two elements, every
/// element goes half way between min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j)). Both are feasible, so their mean is;
/// where no link was beyond its limit nothing changes. Held elements are then put back where they were by a wave of
/// their own, so they must be compatible with each other.
class Feasibility
{
public:
  explicit Feasibility(Bricks& bricks);
  ~Feasibility();

  void run(EnvelopePropagation& propagation, const Checkpoint& checkpoint);

private:
  std::vector<int> violated();

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field upper_; ///< float [axis][address]; the lower bound is in Bricks::before
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "bricks with links beyond their limits" };
};

}
