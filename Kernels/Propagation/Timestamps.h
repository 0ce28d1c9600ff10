#pragma once

#include "ArrivalTimes.h"
#include "WavesUnderWay.h"

#include <set>

namespace chainmail
{

/// The published propagation (timestamp.cl; Rodriguez, Leon and Arroyo, algorithms 1 and 2). Each iteration updates the
/// neighbours of elements that moved in the previous one. Such an element takes over the newest wave among these
/// neighbours, within one wave the earliest time, and shifts into that neighbour's box. A new wave may start before
/// others have ended.
///
/// An element passes a wave on only if it had to shift. So a wave ends where nothing is violated. From a feasible state
/// this does not change the result: all elements on a shortest path to one that has to shift have to shift, too.
class Timestamps
{
public:
  Timestamps(Bricks& bricks, ArrivalTimes& arrivals);
  ~Timestamps();

  /// Starts a wave at a probe whose elements already have their new displacements.
  void start(const Handle& source, int front);

  /// Runs all waves for at most `iterations` (0: to their ends). Returns the number of iterations.
  int run(int iterations, const Checkpoint& checkpoint);

  bool finished() const { return this->active_.empty(); }

  /// The state of the waves for a relaxation before all waves have ended, or while the next one waits.
  const WavesUnderWay& underWay();

  void clear();

private:
  void allocate();
  void advance();

  Bricks& bricks_;
  ArrivalTimes& arrivals_;
  Field stamp_;    ///< int [axis][address]: the iteration in which the element was last shifted
  Field nextTime_; ///< the results of an iteration before they become the state
  Field nextFront_;
  std::set<int> active_; ///< bricks in which a wave may take an element over
  int iteration_ = 1;    ///< a stamp of 0 means never
  WavesUnderWay underWay_;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
