#pragma once

#include "ArrivalTimes.h"
#include "EnvelopePropagation.h"
#include "Feasibility.h"
#include "Handles.h"
#include "Timestamps.h"

#include <deque>
#include <optional>

namespace chainmail
{

/// Takes tissue where the probes want it: waves by either method, one after the other or overlapping, shortened where
/// probes and anchors do not allow all of it (Simulation::propagate).
class Waves
{
public:
  Waves(Bricks& bricks, Handles& handles);

  /// No wave may be under way.
  void configure(PropagationMethod method, ConflictPolicy policy);
  void keepTimes(bool wanted) { this->times_ = wanted; }

  /// Queues the waves of probes that moved, and lets released ones go as soon as no wave needs them.
  void add(const Handles::Change& change);

  bool underWay() const { return this->wave_ || !this->queue_.empty() || !this->timestamps_.finished(); }

  /// At most so many iterations, 0: until nothing is under way.
  PropagateResult run(int iterations, const Checkpoint& checkpoint);

  /// For a relaxation while waves are under way: null where it has to wait for their end. Elements that it moves make
  /// the rest of the wave inexact; that is repaired at its end.
  const WavesUnderWay* relaxable();
  void relaxed() { this->disturbed_ = true; }

  /// Makes a feasible state of one that a relaxation has left otherwise. No wave may be under way.
  void makeFeasible(const Checkpoint& checkpoint);

  /// All waves ended, no times known.
  void clear();

  const ArrivalTimes& arrivals() const { return this->arrivals_; }

private:
  using Group = std::deque<Handles::Pointer>;

  /// An envelope wave. A single probe's may be tried several times, shorter each time; one of several probes together
  /// is not: they then go half by half.
  struct Wave
  {
    Group handles;
    std::vector<std::uint32_t> addresses; ///< of their elements
    std::vector<int> bricks;              ///< that these lie in
    std::vector<float> before;            ///< displacements of these
    std::array<float, 3> to{};            ///< of a single one, since it grabbed
    std::array<bool, 3> stays{};          ///< axes that a single one cannot move along
    std::array<int, 3> lastWay{};         ///< signs of its last corrections
    std::array<int, 3> turns{};           ///< how often they changed
    std::array<float, 3> tolerance{};     ///< conflict on an axis that is no more than rounding
    float enough = 0.0f;                  ///< conflict that ends an attempt early
    int attempts = 0;
  };

  int runEnvelopes(int iterations, const Checkpoint& checkpoint);
  int runTimestamps(int iterations, const Checkpoint& checkpoint);
  void beginNext();
  void begin(Group handles);
  void end();
  void attempt();
  bool settled();
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
  PropagationMethod method_ = PropagationMethod::Envelope;
  ConflictPolicy policy_ = ConflictPolicy::Limit;
  bool times_ = false;

  std::deque<Group> queue_; ///< those of a group go together
  std::vector<Handles::Pointer> released_;
  std::optional<Wave> wave_;
  bool disturbed_ = false;  ///< links may be beyond their limits when the waves have come to their end
  Handles::Pointer latest_; ///< probe of the last wave of timestamps
  int front_ = 0;           ///< number of the last wave

  EnvelopePropagation propagation_;
  ArrivalTimes arrivals_;
  Timestamps timestamps_;
  Feasibility feasibility_;
};

}
