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
/// changes any more. The device finds out which bricks have something to do. The host launches several turns at once
/// and then gives memory to the bricks that changes have come to.
class FixedPoint
{
public:
  /// Adds the kernel's own arguments, which follow FIXED_POINT_ARGUMENTS and the layout of brick.clh. It is called for
  /// every launch, since their buffers may have changed.
  using OwnArguments = std::function<void(ArgumentList&)>;

  /// `extremes` is the value of EXTREMES in the kernel.
  FixedPoint(Bricks& bricks, const char* file, const char* kernel, int extremes = 0);

  /// Begins in these bricks and those that share a face with one of them.
  void start(const std::vector<int>& bricks);

  bool finished() const { return this->finished_; }

  /// Continues for at most `iterations` (0: until nothing changes). In each one every brick that changes have reached
  /// has its turn once. An extreme of more than `enough` ends it where it is. Returns the number of iterations.
  ///
  /// Every value that a kernel passes on is to be that of one path of links, which comes to no element twice. With each
  /// iteration all values of paths one element longer are final, so there are no more iterations than elements. A
  /// kernel of which that does not hold would go on for ever: Error is thrown.
  int run(int iterations, float enough, const Checkpoint& checkpoint, const OwnArguments& own);

  /// Takes away what the kernel noted in the rows of all bricks by these flags.
  void forget(int flags);

  /// The largest value of each extreme so far.
  const std::vector<float>& extremes() const { return this->extremes_; }

  /// Slots in which it began or that had a turn since, and slots in which something changed, ascending.
  std::vector<int> seen();
  std::vector<int> changed();

private:
  struct Turn
  {
    int parity;
    bool waited; ///< the turn is for bricks that lacked memory when it was theirs
  };

  int parityOf(int brick) const;
  void fit();
  void launch(const std::vector<Turn>& turns, float enough, const Checkpoint& checkpoint, const OwnArguments& own);
  bool isBeyond(float enough) const;
  std::vector<int> slotsWith(int flags);

  Bricks& bricks_;
  const char* file_;
  const char* name_;
  SharedTable visits_;
  SharedTable log_;
  std::vector<float> extremes_;
  std::vector<float> ofTurn_; ///< extremes of the turn that is half done
  std::size_t followed_ = 0;  ///< see Bricks::follow()
  bool finished_ = true;
  bool goesOn_[2] = {}; ///< for each parity: its last turn left something to do
  int parity_ = 0;      ///< of the next turn
  bool waited_ = false;
  std::size_t iterations_ = 0; ///< since the start
};

}
