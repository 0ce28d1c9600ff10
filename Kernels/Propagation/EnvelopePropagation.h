#pragma once

#include "Elements.h"
#include "FixedPoint.h"

namespace chainmail
{

/// Envelope propagation (envelope.cl), a method of this project. It starts from a feasible state in which handles have
/// been moved, and clamps every element to the bounds of its neighbours until nothing changes. The caller has saved the
/// bricks of these handles (Snapshot::save()). Every other brick is saved when the wave reaches it.
class EnvelopePropagation
{
public:
  explicit EnvelopePropagation(Bricks& bricks)
    : bricks_(bricks)
    , fixedPoint_(bricks, "envelope.cl", "propagate", 6)
  {
  }
  ~EnvelopePropagation() { this->bricks_.removeField(this->shift_); }

  /// How far moved tissue exceeds what held tissue allows, per axis; 0 or float rounding where the two are compatible.
  struct Conflict
  {
    Vector3 tooHigh{};
    Vector3 tooLow{};

    double largest() const;
  };

  /// Begins a wave in the bricks of the moved handles.
  void start(const std::vector<int>& bricks);

  /// The same where handles have been rotated, too. `elements` and `shifts`: the elements of all moved handles and
  /// their shifts (fractions of the spacing), 3 interleaved values each.
  void startPoses(const std::vector<int>& bricks, const Elements& elements, const std::vector<float>& shifts);

  /// To be called when other tissue is held than before while the wave is under way.
  void heldChanged();

  /// Restores all displacements from before the wave.
  void takeBack() { this->bricks_.before().restore(this->fixedPoint_.seen()); }

  /// Makes Bricks::before() hold the state before the wave everywhere, after its end.
  void saveRest();

  /// Runs the wave for at most `iterations` (0: to its end). Each one visits once every brick that the wave has
  /// reached. A conflict of more than `stopThreshold` ends the wave early; conflict() is then a lower bound of the
  /// whole conflict. Returns the number of iterations.
  int run(int iterations, float stopThreshold, const Checkpoint& checkpoint);

  /// Frees the memory that only waves need.
  void release() { this->bricks_.removeField(this->shift_); }

  bool finished() const { return this->fixedPoint_.finished(); }
  Conflict conflict() const;

private:
  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field shift_{ 3, sizeof(float), "the displacement by a wave" }; ///< with rotations only, see envelope.cl
  bool poses_ = false; ///< whether the wave is of handles that have been rotated
  Scratch list_{ "the list of bricks" };
};

}
