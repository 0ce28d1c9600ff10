#pragma once

#include "FixedPoint.h"

namespace chainmail
{

/// Envelope propagation (envelope.cl): takes the state saved in Bricks::before, with held elements moved away from it,
/// to the fixed point.
class EnvelopePropagation
{
public:
  explicit EnvelopePropagation(Bricks& bricks)
    : bricks_(bricks)
    , fixedPoint_(bricks, "envelope.cl", "propagate", 6)
  {
  }

  /// How far moved tissue is beyond what held tissue allows, per axis; 0, or float rounding, where it is compatible.
  struct Conflict
  {
    Vector3 tooHigh{};
    Vector3 tooLow{};

    double largest() const;
  };

  /// Begins a wave at the bricks that hold moved elements.
  void start(const std::vector<int>& bricks);

  /// Lets it travel for at most so many iterations (0: to the end), each one turn of all bricks that it has reached. A
  /// conflict of more than `enough` ends it where it is; conflict() is then at most the whole conflict. Returns the
  /// number of iterations.
  int run(int iterations, float enough, const Checkpoint& checkpoint);

  bool finished() const { return this->fixedPoint_.finished(); }
  Conflict conflict() const;

private:
  Bricks& bricks_;
  FixedPoint fixedPoint_;
};

}
