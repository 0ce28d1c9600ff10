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

/// Takes tissue to where the probes want it (Simulation::propagate). Waves travel by either method, one after the other
/// or overlapping, and are shortened where probes and anchors do not allow all of their displacement.
class Waves
{
public:
  Waves(Bricks& bricks, Handles& handles, Handles::SharedBodies sharedBodies);

  /// No wave may be under way when this is called.
  void configure(PropagationMethod method, ConflictPolicy policy);
  void keepTimes(bool wanted) { this->times_ = wanted; }

  /// Queues the waves of probes that moved. Released probes let go as soon as no wave needs them.
  void add(const Handles::Change& change);

  bool underWay() const { return this->wave_ || !this->queue_.empty() || !this->timestamps_.finished(); }

  /// Runs at most `iterations` (0: until no wave is under way).
  PropagateResult run(int iterations, const Checkpoint& checkpoint);

  /// The state of the waves for a relaxation between their iterations; null where it has to wait for their end.
  /// Elements that it moves make the rest of the wave inexact, so afterwards relaxed() has to be called; the end of the
  /// wave mends that.
  const WavesUnderWay* relaxable();
  void relaxed() { this->disturbed_ = true; }

  /// Projects the state that a relaxation beyond the limits has left to a feasible one. No wave may be under way.
  void makeFeasible(const Checkpoint& checkpoint);

  /// Ends all waves and forgets all arrival times.
  void clear();

  /// How many waves a probe needs at least for what is left of its way, as it turns some degrees at a time.
  static int wavesFor(const Handle& handle);

  const ArrivalTimes& arrivals() const { return this->arrivals_; }

private:
  using Group = std::deque<Handles::Pointer>;

  /// An envelope wave. That of a single probe may be tried several times, shorter each time. One of several probes is
  /// tried once, and then they share, or go in two halves. Where some of its probes turn, all of these go the same
  /// share of their ways, less in each attempt, before they go in halves.
  struct Wave
  {
    Group handles;
    std::vector<std::pair<Handles::Pointer, Group>> joined; ///< handles that take the place of several (Handles::join)
    std::vector<std::uint32_t> addresses;                   ///< addresses of the handles' elements
    std::vector<int> bricks;                                ///< bricks that these elements lie in
    std::vector<float> before;                              ///< displacements of these elements before the wave
    std::vector<float> shared;        ///< where they are to go because they share; empty where they do not
    std::array<float, 3> to{};        ///< where a single probe is to go, counted from where it grabbed
    std::array<bool, 3> stays{};      ///< axes along which a single probe cannot move
    std::array<int, 3> lastWay{};     ///< signs of the last corrections
    std::array<int, 3> signChanges{}; ///< how often these signs changed
    std::array<float, 3> tolerance{}; ///< a conflict, per axis, that is no more than rounding
    float enough = 0.0f;              ///< a conflict that ends an attempt early
    int attempts = 0;

    bool turns = false;                 ///< whether any of the probes does
    double share = 1.0;                 ///< of the way of those that turn
    double longest = 1.0;               ///< share that they may go at once
    float way = 0.0f;                   ///< the longest way of an element in this attempt [fractions of the spacing]
    std::vector<std::uint32_t> turning; ///< addresses of their elements
    std::vector<float> spinsBefore;     ///< the rotations of these before the wave
  };

  int runEnvelopes(int iterations, const Checkpoint& checkpoint);
  int runTimestamps(int iterations, const Checkpoint& checkpoint);
  void beginNext();
  void begin(Group handles);
  void joinBodies();
  void end();
  void attempt();
  bool settled(const Checkpoint& checkpoint);
  bool shorten(const EnvelopePropagation::Conflict& conflict);
  void takeBack();
  bool share(const Checkpoint& checkpoint);
  void countShared();
  template <typename F> void makeFeasible(const F& isHeld, const Checkpoint& checkpoint);
  void startTimestamps(const Handles::Pointer& handle, const Checkpoint& checkpoint);
  void markHeld();
  void wait(Group handles, bool first);
  void letGo();
  void place(
    const std::vector<std::uint32_t>& addresses, const std::vector<int>& bricks, const std::vector<float>& values);
  std::vector<float> target() const;

  Bricks& bricks_;
  Handles& handles_;
  Handles::SharedBodies sharedBodies_;
  PropagationMethod method_ = PropagationMethod::Envelope;
  ConflictPolicy policy_ = ConflictPolicy::Limit;
  bool times_ = false;

  std::deque<Group> queue_; ///< the probes of a group go together
  std::vector<Handles::Pointer> released_;
  std::optional<Wave> wave_;
  bool disturbed_ = false;  ///< whether links may be beyond their limits when the waves have come to their end
  Handles::Pointer latest_; ///< the probe of the last Timestamp wave
  int front_ = 0;           ///< the number of the last wave

  EnvelopePropagation propagation_;
  ArrivalTimes arrivals_;
  Timestamps timestamps_;
  Feasibility feasibility_;
  Sharing sharing_;
  std::size_t numberShared_ = 0; ///< PropagateResult::shared
};

}
