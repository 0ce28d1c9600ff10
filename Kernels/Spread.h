#pragma once

#include "Bricks.h"

#include <functional>
#include <map>
#include <vector>

namespace chainmail
{

/// Called between launches; throws to stop.
using Checkpoint = std::function<void()>;

/// Something that spreads from brick to brick until nothing changes any more, by a kernel that updates bricks in place.
/// Bricks of one parity (of the brick grid) never touch, so one launch may update all of them.
///
/// The kernel's first arguments are the list of slots, each with what changed before, the number of rounds within a
/// brick that surely suffices, the pitch and brick.clh's table; its last is `result`, some ints for each brick of which
/// the first are the faces that changed elements touch, as spread.clh says.
class Spread
{
public:
  /// `results`: ints per brick.
  Spread(Bricks& bricks, const char* file, const char* kernel, int results)
    : bricks_(bricks)
    , file_(file)
    , name_(kernel)
    , results_(results)
  {
  }

  /// Begins in these bricks and those beside them.
  void start(const std::vector<int>& bricks);

  bool finished() const { return this->pending_[0].empty() && this->pending_[1].empty(); }

  /// One launch over all bricks of a parity that have to be looked at. `bind` sets the kernel's own arguments.
  void turn(int parity, const std::function<void(cl::Kernel&, int&)>& bind);

  /// The slots of the last launch, and the results of each.
  const std::vector<int>& slots() const { return this->slots_; }
  const cl_int* resultOf(std::size_t n) const { return this->values_.data() + n * this->results_; }

private:
  int parityOf(int brick) const;
  void notify(int brick, int parity, int faces);

  Bricks& bricks_;
  const char* file_;
  const char* name_;
  std::size_t results_;
  std::map<int, int> pending_[2]; ///< by parity: brick, and what changed before (spread.clh)
  std::vector<cl_int2> list_;
  std::vector<int> slots_;
  std::vector<cl_int> values_;
  Scratch listBuffer_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
