#pragma once

#include "ArrivalTimes.h"
#include "EnvelopePropagation.h"
#include "Feasibility.h"
#include "Handles.h"
#include "Sharing.h"
#include "Timestamps.h"

#include <deque>
#include <optional>

namespace chainmail
{

/// Moves tissue to where the probes request it (Simulation::propagate). Waves use either method and run one after the
/// other or overlap. They are shortened where probes and anchors do not allow their full displacement.
class Waves
{
public:
  Waves(Bricks& bricks, Handles& handles, Handles::SharedBodies sharedBodies);

  /// No wave may be under way when this is called.
  void configure(PropagationMethod method, ConflictPolicy policy);
  bool isConfigured(PropagationMethod method, ConflictPolicy policy) const
  {
    return method == this->method_ && policy == this->policy_;
  }
  void keepTimes(bool wanted) { this->times_ = wanted; }

  /// Queues the waves of probes that moved. Tissue of released probes stays held until no wave is under way.
  void add(const Handles::Change& change);

  bool underWay() const { return this->wave_ || !this->queue_.empty() || !this->timestamps_.finished(); }

  /// Runs at most `iterations` (0: until no wave is under way).
  PropagateResult run(int iterations, const Checkpoint& checkpoint);

  /// The state of the waves for a relaxation between their iterations; null where a relaxation has to wait for their
  /// end. Elements that it moves make the rest of the wave inexact, so relaxed() has to be called afterwards. At the
  /// end of the waves the state is then projected to a feasible one.
  const WavesUnderWay* relaxable();
  void relaxed() { this->disturbed_ = true; }

  /// Projects a state to a feasible one after a relaxation that ignores limits. No wave may be under way.
  void projectToFeasible(const Checkpoint& checkpoint);

  /// Ends all waves and clears all propagation times.
  void clear();

  /// The least number of waves that the remaining rotation of a probe takes: each wave rotates by some degrees at most.
  static int wavesFor(const Handle& handle);

  const ArrivalTimes& arrivals() const { return this->arrivals_; }

private:
  using Group = std::deque<Handles::Pointer>;

  /// An envelope wave. The target of a single probe is corrected by the conflict until it fits. Several probes share,
  /// or are split into two halves. If probes prescribe rotations, these first go the same fraction of their motions,
  /// less in each attempt. The other probes of the wave go their whole way.
  struct Wave
  {
    explicit Wave(Bricks& bricks)
      : elements(bricks)
      , rotating(bricks)
    {
    }

    Group handles;
    std::vector<std::pair<Handles::Pointer, Group>> joined; ///< handles that replace several others (Handles::join)
    Elements elements;                                      ///< the elements of the handles
    std::vector<int> bricks;                                ///< bricks that these elements lie in
    std::vector<float> before;                              ///< displacements of these elements before the wave
    std::vector<float> shared;        ///< their target displacements where the probes share; else empty
    std::array<float, 3> to{};        ///< target displacement of a single probe, counted from where it grabbed
    std::array<bool, 3> stays{};      ///< axes along which a single probe cannot move
    std::array<int, 3> lastWay{};     ///< signs of the last corrections
    std::array<int, 3> signChanges{}; ///< how often these signs changed
    std::array<float, 3> tolerance{}; ///< a conflict, per axis, that is no more than rounding
    float stopThreshold = 0.0f;       ///< a conflict of more than this ends an attempt early
    int attempts = 0;

    bool rotates = false;               ///< whether any of the probes prescribes a rotation
    double fraction = 1.0;              ///< fraction of their motions that such probes go in this attempt
    double largestFraction = 1.0;       ///< largest fraction that they may go in one wave
    float way = 0.0f;                   ///< largest shift of an element in this attempt [fractions of the spacing]
    Elements rotating;                  ///< the elements of such probes
    std::vector<float> rotationsBefore; ///< the rotations of these elements before the wave
  };

  int runEnvelopes(int iterations, const Checkpoint& checkpoint);
  int runTimestamps(int iterations, const Checkpoint& checkpoint);
  void beginNext();
  void begin(Group handles);
  void joinBodies();
  void end();
  void attempt();
  bool endAttempt(const Checkpoint& checkpoint);
  bool shorten(const EnvelopePropagation::Conflict& conflict);
  void takeBack();
  bool share(const Checkpoint& checkpoint);
  void countShared();
  template <typename F> void projectToFeasible(const F& isHeld, const Checkpoint& checkpoint);
  void startTimestamps(const Handles::Pointer& handle, const Checkpoint& checkpoint);
  void markHeld();
  void enqueue(Group handles, bool first);
  void letGo();
  void place(const Elements& elements, const std::vector<int>& bricks, const std::vector<float>& values);
  std::vector<float> target() const;

  Bricks& bricks_;
  Handles& handles_;
  Handles::SharedBodies sharedBodies_;
  PropagationMethod method_ = PropagationMethod::Envelope;
  ConflictPolicy policy_ = ConflictPolicy::Limit;
  bool times_ = false;

  std::deque<Group> queue_; ///< the probes of a group form one wave
  std::vector<Handles::Pointer> released_;
  std::optional<Wave> wave_;
  bool disturbed_ = false;  ///< whether links may be beyond their limits when the waves have come to their end
  Handles::Pointer latest_; ///< the probe of the last Timestamp wave
  int lastWaveId_ = 0;      ///< the id of the last wave

  EnvelopePropagation propagation_;
  ArrivalTimes arrivals_;
  Timestamps timestamps_;
  Feasibility feasibility_;
  Sharing sharing_;
  std::size_t numberShared_ = 0; ///< PropagateResult::shared
};

}
