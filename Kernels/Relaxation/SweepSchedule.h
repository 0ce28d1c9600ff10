#pragma once

#include "Bricks.h"
#include "SharedTable.h"

#include <functional>
#include <tuple>
#include <vector>

namespace chainmail
{

/// PASS_ARGUMENTS of sweep.clh.
using PassArguments = std::tuple<const cl::Buffer&, const cl::Buffer&, cl_int4, cl_float>;

/// Determines which bricks a relaxation has to visit: those in which something can change. Skipping the others is
/// exact: updating an element changes no bit if neither it nor a neighbour has moved since its last update. So results
/// do not depend on the size of bricks.
///
/// The device updates the tables (sweep.clh). The host launches all passes of several sweeps as one batch and then
/// reads the result. By itself the device calls off all later launches in two cases. Either a brick was not updatable
/// in a pass, or a sweep moved nothing by more than the stop threshold.
class SweepSchedule
{
public:
  explicit SweepSchedule(Bricks& bricks);

  /// Rigid clusters (bodies), which move as a whole through many bricks. A body becomes active as soon as something
  /// moves in one of its bricks or in a neighbouring brick.
  struct Bodies
  {
    std::function<std::vector<int>()> asleep;            ///< bricks of inactive bodies that could move
    std::function<void(const std::vector<int>&)> awaken; ///< activates the bodies of these bricks, allocates states
  };

  /// Starts a relaxation: all dirty bricks (Bricks::dirtySlots) may move. With empty functions there are no bodies.
  void begin(Bodies bodies);

  /// Starts a batch of at most `sweeps` sweeps.
  void beginBatch(int sweeps);
  /// Starts a sweep. It is called off if the previous sweep of the same batch moved nothing by more than
  /// `stopThreshold`, the stop threshold.
  void beginSweep(float stopThreshold);
  static constexpr float goesOn = -1.0f; ///< below all moves: a sweep with this stop threshold is never called off
  /// Starts a pass of the sweep, of a kind of sweep.clh or `ofBodies`. Returns false if the last batch has already done
  /// this pass.
  bool takesPass(int kind);
  static constexpr int ofBodies = 2;
  /// Ends a batch. Returns the largest move of each completed sweep. The last sweep may be incomplete; the next batch
  /// then begins with the rest of it.
  std::vector<float> endBatch();

  /// To be called between batches, after anything else has moved elements of these bricks.
  void note(const std::vector<int>& bricks);
  /// To be called between batches: marks the slots with moved elements as dirty (Bricks::markDirty).
  void markDirty();

  // --- For the launches of a pass: its arguments, and the number of work-groups
  PassArguments arguments() const
  {
    return { this->activity(), this->log(), this->numbers(), this->passes_.back().stopThreshold };
  }
  const cl::Buffer& activity() const { return this->activity_.buffer(); }
  const cl::Buffer& log() const { return this->log_.buffer(); }
  cl_int4 numbers() const;
  /// Adds the current pass to a table of passes for one launch, see sweepaccount.clh.
  void addTo(SharedTable& batch, float omega) const;
  std::size_t groups() const { return static_cast<std::size_t>(this->activity_.rows()) - 1; }

private:
  struct PassEntry
  {
    int sweep;
    int kind;
    float stopThreshold; ///< stop threshold of a sweep that this pass begins; negative: it is not called off
  };

  void fit();
  void makeReady(const std::vector<int>& slots);

  Bricks& bricks_;
  Bodies bodies_;
  SharedTable activity_;
  SharedTable log_;
  std::size_t exchangesApplied_ = 0; ///< see BrickStorage::applyExchanges()

  int sweep_ = 0;  ///< number of the next sweep, or of the incomplete one
  int resume_ = 0; ///< kind of the pass that continues an incomplete sweep, for the bricks that waited; else 0
  bool waited_ = false;
  float largest_ = 0.0f; ///< largest move of the incomplete sweep so far

  std::vector<PassEntry> passes_; ///< passes of the batch, numbered from 1
  int begun_ = 0;                 ///< sweeps begun in the batch
  int first_ = 0;                 ///< first pass of the sweep
  int before_ = 0;                ///< first pass of the previous sweep
  float stopThreshold_ = -1.0f;
};

}
