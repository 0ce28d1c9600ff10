#pragma once

#include "ArrivalTimes.h"
#include "WavesUnderWay.h"

#include <set>

namespace chainmail
{

/// The published propagation (timestamp.cl; Rodriguez, Leon and Arroyo, algorithms 1 and 2). In each iteration every
/// element beside one that moved in the iteration before takes over the earliest arrival among those neighbours, or
/// that of the newest wave, and shifts into that neighbour's box. A new wave may start before others have come to their
/// ends.
///
/// An element passes a wave on only if it had to shift. So a wave ends where nothing is violated. From a feasible state
/// this changes no result, as every element on a shortest path to one that has to shift has to shift itself.
class Timestamps
{
public:
  Timestamps(Bricks& bricks, ArrivalTimes& arrivals);
  ~Timestamps();

  /// Starts a wave at a probe whose elements have already been moved to where they are to be.
  void start(const Handle& source, int front);

  /// Lets all waves travel for at most `iterations` (0: to their ends). Returns how many it took.
  int run(int iterations, const Checkpoint& checkpoint);

  bool finished() const { return this->active_.empty(); }

  /// The state of the waves for a relaxation before all waves have come to their ends, or while the next one waits.
  const WavesUnderWay& underWay();

  void clear();

private:
  void keep();
  void advance();

  Bricks& bricks_;
  ArrivalTimes& arrivals_;
  Field stamp_;    ///< int [axis][address]: the iteration in which the element was last shifted
  Field nextTime_; ///< the results of an iteration before they become the state
  Field nextFront_;
  std::set<int> active_; ///< bricks in which an element may take up a wave
  int iteration_ = 1;    ///< a stamp of 0 means never
  WavesUnderWay underWay_;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
