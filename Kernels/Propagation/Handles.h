#pragma once

#include "Bricks.h"
#include "Types.h"

#include <functional>
#include <memory>
#include <vector>

namespace chainmail
{

/// What a probe holds of the tissue.
struct Handle
{
  Probe probe;                          ///< as it was last asked for
  std::vector<std::size_t> voxels;      ///< the elements that it holds, ascending
  std::vector<std::uint32_t> addresses; ///< theirs
  std::vector<float> constraints;       ///< theirs, where nobody holds them, axes() interleaved values each
  std::vector<float> grabbed;           ///< their displacements when they were grabbed, 3 interleaved values each
  std::vector<int> bricks;              ///< that they lie in
  bool held = false;                    ///< whether they are marked as held on the device
  bool waits = false;                   ///< for its wave to begin
  bool moves = false;                   ///< by a wave that is under way

  /// The element whose displacement is the probe's, and what it was: the first held one; one near the probe, held by
  /// another, where it holds none.
  std::uint32_t place = 0;
  std::array<float, 3> placeGrabbed{};

  /// Where its elements are when the probe has gone `to` since it grabbed them (a fraction of the spacing).
  std::vector<float> displacedBy(const std::array<float, 3>& to) const;
};

/// The handles of all probes, in the order of the probes.
class Handles
{
public:
  /// Finds what probes with these numbers grab, as elementsAround() does.
  using Grab = std::function<std::vector<std::vector<std::size_t>>(
    const std::vector<Probe>&, const std::vector<std::size_t>& numbers)>;

  Handles(Bricks& bricks, Grab grab)
    : bricks_(bricks)
    , grab_(std::move(grab))
  {
  }

  using Pointer = std::shared_ptr<Handle>;
  const std::vector<Pointer>& all() const { return this->handles_; }

  /// What a new list of probes changes.
  struct Change
  {
    std::vector<Pointer> moved; ///< grabbed, or to be taken elsewhere, in the order of the probes
    std::vector<Pointer> released;
  };

  /// Takes exactly these probes (Simulation::hold). Tissue that is grabbed is held at once; tissue that is released
  /// stays held until letGo(). Throws InputError, and nothing changed.
  Change take(const std::vector<Probe>& probes);

  /// Lets go of released holds. What others hold of their tissue stays held.
  void letGo(const std::vector<Pointer>& released);

  /// Lets all go.
  void clear();

  /// Takes carved elements out of every handle.
  void forget(const std::vector<std::size_t>& voxels);

  /// Marks tissue on the device: nothing but its own probe moves what is held. `isHeld(handle)` says which handles hold
  /// theirs from now on.
  template <typename F> void setHeld(const F& isHeld)
  {
    std::vector<Pointer> changed;
    for (const Pointer& handle : this->handles_)
    {
      if (handle->held != isHeld(*handle))
      {
        handle->held = !handle->held;
        changed.push_back(handle);
      }
    }
    this->mark(changed);
  }

  /// All voxels in a handle.
  std::vector<std::size_t> voxels() const;

  /// How far each probe has come since it grabbed [mm], and how many elements it holds.
  std::vector<ProbeResult> reached();

private:
  std::vector<Pointer> make(const std::vector<Probe>& probes, const std::vector<std::vector<std::size_t>>& grabbed,
    const std::vector<Pointer>& goingOn);
  void fill(const std::vector<Pointer>& handles, const std::vector<std::size_t>& places);
  void mark(const std::vector<Pointer>& handles);

  Bricks& bricks_;
  Grab grab_;
  std::vector<Pointer> handles_;
};

}
