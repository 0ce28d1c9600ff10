#pragma once

#include "Bricks.h"
#include "SharedTable.h"

#include <functional>
#include <tuple>
#include <vector>

namespace chainmail
{

/// Finds which bricks a relaxation has to visit: those in which something can change. Leaving out the others is exact:
/// an element stays put, to the bit, when neither it nor a neighbour moved since its last turn. So results do not
/// depend on the size of bricks.
///
/// The device keeps the account (sweep.clh). The host launches all turns of several sweeps as one batch and then looks
/// at the outcome. By itself the device calls off all launches that follow a turn in which a brick lacked memory, or a
/// sweep that came to rest.
class SweepSchedule
{
public:
  explicit SweepSchedule(Bricks& bricks);

  /// Rigid clusters, which move as a whole through many bricks. A body takes part from the moment that something moves
  /// in one of its bricks or beside it.
  struct Bodies
  {
    std::function<std::vector<int>()> asleep;            ///< bricks of bodies that could move but do not take part
    std::function<void(const std::vector<int>&)> awaken; ///< lets the bodies of these bricks take part, with memory
  };

  /// Starts a relaxation: everything that was ever touched may move. With empty functions there are no bodies.
  void begin(Bodies bodies);

  /// Starts a batch of at most `sweeps` sweeps.
  void beginBatch(int sweeps);
  /// Starts a sweep. It is called off where the sweep before, in the same batch, moved nothing by more than `enough`.
  void beginSweep(float enough);
  static constexpr float goesOn = -1.0f; ///< a move below all others: such a sweep is never called off
  /// Starts a turn of the sweep, of a kind of sweep.clh or of the bodies. False where the last batch has already done
  /// it.
  bool takesTurn(int kind);
  static constexpr int ofBodies = 2;
  /// Ends a batch: the largest move in each sweep that is done. A sweep may be half done; the next batch then begins
  /// with it.
  std::vector<float> endBatch();

  /// Between batches: something else has moved elements of these bricks.
  void note(const std::vector<int>& bricks);
  /// Between batches: tells Bricks which slots were touched.
  void touch();

  // --- For the launches of a turn: SWEEP_ARGUMENTS of sweep.clh, together or one by one, and the number of work-groups
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_int4, cl_float>(
      this->activity(), this->log(), this->turn(), this->turns_.back().enough);
  }
  const cl::Buffer& activity() const { return this->activity_.buffer(); }
  const cl::Buffer& log() const { return this->log_.buffer(); }
  cl_int4 turn() const;
  /// Adds the turn to a table of turns for one launch, see sweepaccount.clh.
  void addTo(SharedTable& batch, float omega) const;
  std::size_t groups() const { return static_cast<std::size_t>(this->activity_.rows()) - 1; }

private:
  struct Turn
  {
    int sweep;
    int kind;
    float enough; ///< of a sweep that this turn begins; negative: it is not called off
  };

  void fit();
  void makeReady(const std::vector<int>& slots);

  Bricks& bricks_;
  Bodies bodies_;
  SharedTable activity_;
  SharedTable log_;
  std::size_t followed_ = 0; ///< see Bricks::follow()

  int sweep_ = 0;  ///< number of the next sweep, or of the one that is half done
  int resume_ = 0; ///< the turn that a half done sweep goes on with, for the bricks that waited; else its first
  bool waited_ = false;
  float largest_ = 0.0f; ///< largest move of that sweep so far

  std::vector<Turn> turns_; ///< turns of the batch; launches count from 1
  int begun_ = 0;           ///< sweeps begun in the batch
  int first_ = 0;           ///< first launch of the sweep
  int before_ = 0;          ///< first launch of the sweep before
  float enough_ = -1.0f;
};

}
