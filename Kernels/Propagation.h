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

  /// How far moved tissue is beyond what held tissue allows, per axis; 0, or float rounding, where it is compatible.
  struct Conflict
  {
    Vector3 tooHigh{};
    Vector3 tooLow{};

    double largest() const;
  };

  /// Starts at the bricks that hold moved elements. A conflict of more than `enough` ends the wave where it is; what is
  /// returned is then at most the whole conflict.
  Conflict run(const std::vector<int>& bricks, double enough, const Checkpoint& checkpoint);

private:
  Bricks& bricks_;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
