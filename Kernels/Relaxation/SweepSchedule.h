#pragma once

#include "Bricks.h"
#include "SharedTable.h"

#include <functional>
#include <tuple>
#include <vector>

namespace chainmail
{

/// Which bricks a relaxation has to visit: those in which something can change. That is exact: an element stays put, to
/// the bit, when neither it nor a neighbour moved since its last turn, so results do not depend on the size of bricks.
///
/// The device keeps the account (sweep.clh). The host launches all turns of several sweeps, a batch, and then looks at
/// what became of them: what follows a turn in which a brick lacks memory, or a sweep that comes to rest, the device
/// has called off by itself.
class SweepSchedule
{
public:
  explicit SweepSchedule(Bricks& bricks);

  /// What moves as a whole, through many bricks: it takes part from the moment something moves in one of them or beside
  /// it.
  struct Bodies
  {
    std::function<std::vector<int>()> asleep;            ///< bricks of those that could move, but do not take part
    std::function<void(const std::vector<int>&)> awaken; ///< those of these bricks take part, and have memory
  };

  /// All that was ever touched may move. Empty functions: there are no bodies.
  void begin(Bodies bodies);

  /// The next sweeps; at most so many.
  void beginBatch(int sweeps);
  /// The next sweep. It is called off where the one before, of the same batch, moved nothing by more than `enough`.
  void beginSweep(float enough);
  /// A turn of the sweep: of a kind that sweep.clh knows, or of the bodies. False where the batch before has had it.
  bool takesTurn(int kind);
  static constexpr int ofBodies = 2;
  /// The largest move in each sweep of the batch that is done. A sweep may be half done: it is the next batch's first.
  std::vector<float> endBatch();

  /// After a batch: something else has moved elements of these bricks.
  void note(const std::vector<int>& bricks);
  /// After a batch: tells Bricks what was touched.
  void touch();

  // For the launches of a turn: SWEEP_ARGUMENTS of sweep.clh, all or single ones, and the number of work-groups.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_int4, cl_float>(
      this->activity(), this->log(), this->turn(), this->turns_.back().enough);
  }
  const cl::Buffer& activity() const { return this->activity_.buffer(); }
  const cl::Buffer& log() const { return this->log_.buffer(); }
  cl_int4 turn() const;
  std::size_t groups() const { return static_cast<std::size_t>(this->activity_.rows()) - 1; }

private:
  struct Turn
  {
    int sweep;
    int kind;
    float enough; ///< of a sweep that this begins; negative: it goes on anyhow
  };

  void fit();
  void makeReady(const std::vector<int>& slots);

  Bricks& bricks_;
  Bodies bodies_;
  SharedTable activity_;
  SharedTable log_;

  int sweep_ = 0;  ///< number of the next sweep, or of the one that is half done
  int resume_ = 0; ///< the turn that one goes on with: of bricks that waited; and without, its first
  bool waited_ = false;
  float largest_ = 0.0f; ///< move so far

  std::vector<Turn> turns_; ///< those of the batch; launches count from 1
  int begun_ = 0;           ///< sweeps of the batch
  int first_ = 0;           ///< launch of the sweep
  int before_ = 0;          ///< that of the sweep before
  float enough_ = -1.0f;
};

}
