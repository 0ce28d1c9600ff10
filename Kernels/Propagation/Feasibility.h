#pragma once

#include "EnvelopePropagation.h"

#include <vector>

namespace chainmail
{

/// Projects any state to a feasible one (feasibility.cl), a method of this project. With d(i, j) the length of the
/// shortest path of links between two elements, every element goes half way between min_j(u(j) + d(i, j)) and
/// max_j(u(j) - d(i, j)). Both bounds are feasible states, so their mean is, too, and where no link was beyond its
/// limit nothing changes. An envelope wave then puts held elements back where they were, so they must be compatible
/// with each other.
class Feasibility
{
public:
  explicit Feasibility(Bricks& bricks);
  ~Feasibility();

  /// Returns whether the state is feasible now. It always is where elements do not turn. Where they do, spins stay as
  /// they are, and may ask for more than the limits of links around a loop, or between held elements, allow.
  /// Where contradictions.cl finds that, all stays as it is.
  bool run(EnvelopePropagation& propagation, const Checkpoint& checkpoint);

private:
  std::vector<int> bricksThatAre(const char* what, const char* file, bool vectors, const std::vector<int>& slots);

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field upper_; ///< float [axis][address], the upper bound; Bricks::before holds the lower one
  Field lower_; ///< where elements turn, the lower bound
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "bricks with links beyond their limits" };
};

}
