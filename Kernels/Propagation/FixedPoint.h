#pragma once

#include "Bricks.h"
#include "SharedTable.h"

#include <functional>
#include <vector>

namespace chainmail
{

/// Called between launches; throws to stop.
using Checkpoint = std::function<void()>;

/// Something that spreads from brick to brick until nothing changes any more, by a kernel that updates bricks in place
/// (fixedpoint.clh). The device finds out which bricks have something to do; the host launches several turns at once
/// and then gives memory to the bricks that what spreads has come to.
class FixedPoint
{
public:
  /// Adds the kernel's own arguments, which follow FIXED_POINT_ARGUMENTS and the layout of brick.clh. They may be other
  /// buffers at every launch.
  using OwnArguments = std::function<void(ArgumentList&)>;

  /// `extremes`: EXTREMES of the kernel.
  FixedPoint(Bricks& bricks, const char* file, const char* kernel, int extremes = 0);

  /// Begins in these bricks and those beside them.
  void start(const std::vector<int>& bricks);

  bool finished() const { return this->finished_; }

  /// Lets it spread for at most so many iterations (0: to the end), each one turn of all bricks that it has reached. An
  /// extreme of more than `enough` ends it where it is. Returns the number of iterations.
  int run(int iterations, float enough, const Checkpoint& checkpoint, const OwnArguments& own);

  /// The largest of each so far.
  const std::vector<float>& extremes() const { return this->extremes_; }

  /// Slots that were looked at since the start, and those in which something changed, ascending.
  std::vector<int> seen();
  std::vector<int> changed();

private:
  struct Turn
  {
    int parity;
    bool waited; ///< it is for bricks that lacked memory when their turn came
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
  std::vector<float> ofTurn_; ///< extremes of a turn that is half done
  bool finished_ = true;
  bool goesOn_[2] = {}; ///< after the last turn of each parity: something is left to do
  int parity_ = 0;      ///< of the next turn
  bool waited_ = false;
};

}
