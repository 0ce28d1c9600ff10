#pragma once

#include "ArrivalTimes.h"
#include "WavesUnderWay.h"

#include <set>

namespace chainmail
{

/// The published propagation (timestamp.cl; Rodriguez, Leon and Arroyo, algorithms 1 and 2): in each iteration all
/// elements beside one that moved in the iteration before take the earliest arrival among them, or that of the newest
/// wave, and shift into that neighbour's box. A new wave may start before others have come to their ends.
///
/// An element passes a wave on only if it had to shift. So a wave ends where nothing is violated; from a feasible state
/// the result is the same, as every element on a shortest path to one that has to shift has to shift itself.
class Timestamps
{
public:
  Timestamps(Bricks& bricks, ArrivalTimes& arrivals);
  ~Timestamps();

  /// Starts a wave at a probe whose elements have been put where they shall be.
  void start(const Handle& source, int front);

  /// Lets all waves travel for at most so many iterations (0: to their ends). Returns how many it took.
  int run(int iterations, const Checkpoint& checkpoint);

  bool finished() const { return this->active_.empty(); }

  /// For a relaxation before all waves are finished, be it that the next one waits to be started.
  const WavesUnderWay& underWay();

  void clear();

private:
  void keep();
  void advance();

  Bricks& bricks_;
  ArrivalTimes& arrivals_;
  Field stamp_;    ///< int [axis][address]: iteration in which the element was last shifted
  Field nextTime_; ///< what an iteration computes, before it becomes the state
  Field nextFront_;
  std::set<int> active_; ///< bricks in which an element may take up a wave
  int iteration_ = 1;    ///< stamps of 0 mean never
  WavesUnderWay underWay_;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
