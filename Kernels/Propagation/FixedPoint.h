#pragma once

#include "Bricks.h"
#include "SharedTable.h"

#include <functional>
#include <vector>

namespace chainmail
{

/// Called between launches; throws to stop.
using Checkpoint = std::function<void()>;

/// Runs a kernel that updates bricks in place and passes changes on from brick to brick (fixedpoint.clh), until nothing
/// changes any more. The device determines which bricks need an update. The host enqueues several launches at once and
/// then allocates the bricks that changes have reached.
class FixedPoint
{
public:
  /// Adds the kernel's own arguments, which follow FIXED_POINT_ARGUMENTS and STATE_ARGUMENTS. Called for every
  /// launch, since the buffers may have been replaced.
  using OwnArguments = std::function<void(ArgumentList&)>;

  /// `extremes` is the value of EXTREMES in the kernel.
  FixedPoint(Bricks& bricks, const char* file, const char* kernel, int extremes = 0);

  /// Begins in these bricks and those that share a face with one of them.
  void start(const std::vector<int>& bricks);

  bool finished() const { return this->finished_; }

  /// Continues for at most `iterations` (0: until nothing changes). Each one visits once every brick that changes have
  /// reached, but for those that it postpones (fixedpoint.clh). An extreme of more than `stopThreshold` ends the run
  /// early. Returns the number of iterations.
  ///
  /// Every value that a kernel passes on must be that of a path of links that visits no element twice. Each iteration
  /// that postpones nothing makes the values of paths one element longer final. Only a fixed number of iterations may
  /// postpone, so there are at most that many more than elements. A kernel that violates this would never end: where
  /// `iterations` is 0, Error is thrown.
  int run(int iterations, float stopThreshold, const Checkpoint& checkpoint, const OwnArguments& own);

  /// Clears these flags of VISIT_STATE for all bricks.
  void forget(int flags);

  /// The largest value of each extreme so far.
  const std::vector<float>& extremes() const { return this->extremes_; }

  /// Slots of the bricks in which it began or that were visited since, and slots in which something changed; ascending.
  std::vector<int> seen();
  std::vector<int> changed();

private:
  struct ParityPass
  {
    int parity;
    bool waited; ///< only bricks are visited that were not updatable in the launch before
  };

  int parityOf(int brick) const;
  void fit();
  void launch(
    const std::vector<ParityPass>& passes, float stopThreshold, const Checkpoint& checkpoint, const OwnArguments& own);
  bool isBeyond(float stopThreshold) const;
  std::vector<int> slotsWith(int flags);

  Bricks& bricks_;
  const char* file_;
  const char* name_;
  SharedTable visits_;
  SharedTable log_;
  std::vector<float> extremes_;
  std::vector<float> ofPass_;        ///< extremes of the parity pass under way
  std::size_t exchangesApplied_ = 0; ///< see BrickStorage::applyExchanges()
  bool finished_ = true;
  bool goesOn_[2] = {}; ///< for each parity: whether its last pass left something to do
  int parity_ = 0;      ///< of the next pass
  bool waited_ = false;
  float postponed_[2] = {};    ///< LOG_POSTPONED of each parity's last launch
  float passed_ = 0.0f;        ///< LOG_PASSED of the last launch
  std::size_t iterations_ = 0; ///< since the start
};

}
