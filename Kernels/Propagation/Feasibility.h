#pragma once

#include "EnvelopePropagation.h"

#include <vector>

namespace chainmail
{

/// Projects any state to a feasible one (feasibility.cl), a method of this project. Every element goes to the mean of
/// min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j)), with d(i, j) the length of the shortest path of links between two
/// elements. Both bounds are feasible states, so their mean is, too, but for its rounding. A feasible state does not
/// change. An envelope wave then puts held elements back where they were, so held elements must be compatible with each
/// other.
class Feasibility
{
public:
  explicit Feasibility(Bricks& bricks);
  ~Feasibility();

  /// Returns whether the state is feasible now. Without rotations it always is. Rotations are not changed, and their
  /// rest offsets may exceed what the limits of links allow around a loop or between held elements. Where
  /// contradictions.cl finds such a loop nothing is changed.
  bool run(EnvelopePropagation& propagation, const Checkpoint& checkpoint);

private:
  std::vector<int> bricksThatAre(const char* what, const char* file, bool vectors, const std::vector<int>& slots);

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field upper_; ///< float [axis][address], the upper bound
  Field lower_; ///< with rotations, the lower bound; otherwise Bricks::before() holds it
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "bricks with links beyond their limits" };
};

}
