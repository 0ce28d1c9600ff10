#pragma once

#include "Bricks.h"
#include "Simulation.h"

#include <functional>
#include <memory>
#include <vector>

namespace chainmail
{

/// A probe's hand in the tissue.
struct Hold
{
  Probe probe;                          ///< as it was last asked for
  std::vector<std::size_t> voxels;      ///< the elements that it holds, ascending
  std::vector<std::uint32_t> addresses; ///< theirs
  std::vector<float> grabbed;           ///< their displacements when they were grabbed, 3 interleaved values each
  std::vector<int> bricks;              ///< that they lie in
  bool held = false;                    ///< whether they are marked as held on the device

  /// The element whose displacement is the probe's, and what it was: the first held one; one near the probe, held by
  /// another, where it holds none.
  std::uint32_t place = 0;
  std::array<float, 3> placeGrabbed{};

  /// Where its elements are when the probe has gone `to` since it grabbed them (a fraction of the spacing).
  std::vector<float> displacedBy(const std::array<float, 3>& to) const;
};

/// The elements that a probe grabs at the places where they are now, ascending: those within its radius, or the nearest
/// one. `number` is for messages. Throws ProbeError where there are none.
std::vector<std::size_t> elementsAround(Bricks& bricks, const Probe& probe, std::size_t number);

/// The hands of all probes, in the order of the probes.
class Holds
{
public:
  /// Finds what a probe grabs, as elementsAround() does.
  using Grab = std::function<std::vector<std::size_t>(const Probe&, std::size_t number)>;

  Holds(Bricks& bricks, Grab grab)
    : bricks_(bricks)
    , grab_(std::move(grab))
  {
  }

  using Pointer = std::shared_ptr<Hold>;
  const std::vector<Pointer>& all() const { return this->holds_; }

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

  /// Takes carved elements out of every hand.
  void forget(const std::vector<std::size_t>& voxels);

  /// Marks its tissue on the device: nothing but its own probe moves what is held.
  void setHeld(Hold& hold, bool held);

  /// All voxels in a hand.
  std::vector<std::size_t> voxels() const;

  /// How far each probe has come since it grabbed [mm], and how many elements it holds.
  std::vector<ProbeResult> reached();

private:
  void fill(Hold& hold, const std::vector<std::size_t>& mine, const std::vector<std::size_t>& grabbed);

  Bricks& bricks_;
  Grab grab_;
  std::vector<Pointer> holds_;
};

}
