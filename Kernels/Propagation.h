#pragma once

#include "Bricks.h"

#include <functional>

namespace chainmail
{

/// Called between launches; throws to stop.
using Checkpoint = std::function<void()>;

/// Envelope propagation (propagate.cl): takes the state saved in Bricks::before, with held elements moved away from it,
/// to the fixed point.
class Propagation
{
public:
  explicit Propagation(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  /// Starts at the bricks that hold moved elements. Returns per axis the largest conflict: how far two holds pull some
  /// element past what its links allow. It is 0, or float rounding, where all holds are compatible. A conflict of more
  /// than `enough` ends the wave where it is; what is returned is then at most the whole conflict.
  Vector3 run(const std::vector<int>& bricks, double enough, const Checkpoint& checkpoint);

private:
  Bricks& bricks_;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
