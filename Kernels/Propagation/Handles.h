#pragma once

#include "Elements.h"
#include "Pose.h"
#include "Types.h"

#include <functional>
#include <memory>
#include <unordered_set>
#include <vector>

namespace chainmail
{

/// A handle: the tissue that one probe holds.
struct Handle
{
  explicit Handle(Bricks& bricks)
    : elements(bricks)
  {
  }

  Probe probe;                     ///< as last requested
  std::vector<std::size_t> voxels; ///< the elements that it holds, ascending
  Elements elements;               ///< the same, for their values on the device; their bricks have a state
  std::vector<float> constraints;  ///< their signed constraints when not held, axes() interleaved values each
  std::vector<float> grabbed;      ///< their displacements when they were grabbed, 3 interleaved values each
  std::vector<int> bricks;         ///< bricks that the elements lie in
  bool held = false;               ///< whether the device has its elements marked as held
  bool waits = false;              ///< whether its wave has still to begin
  bool moves = false;              ///< whether a wave under way moves it
  double share = 1.0; ///< how many links of a soft probe each of its elements stands for (Handles::Grabbed)

  /// The element whose displacement counts as the probe's (Grid::at), and its displacement when it was grabbed. This is
  /// the first element held or, where the probe holds none, one near it that another probe holds.
  std::size_t place = 0;
  std::array<float, 3> placeGrabbed{};

  /// For a probe that prescribes a rotation: the places [mm] and rotations of its elements when they were grabbed, 3
  /// values each; their pose now; whether the last wave stopped there only because of the limit for one wave.
  std::vector<double> placesGrabbed;
  std::vector<float> rotationsGrabbed;
  Pose pose;
  bool isOnItsWay = false;
  bool rotatesBody = false; ///< whether its last wave rotated a body that several probes hold (Handles::join())

  Pose asked() const { return { this->probe.displacement, this->probe.rotation }; }

  /// Whether its probe is soft. Then its elements are not held, and other handles may have them, too.
  bool isSoft() const { return this->probe.isSoft(); }
  /// Whether it holds its elements in a pose: it prescribes a rotation and is not soft.
  bool rotates() const { return this->probe.rotates && !this->isSoft(); }

  /// The displacements of its elements if the probe moves by `to` from where it grabbed them (fractions of the
  /// spacing).
  std::vector<float> displacedBy(const std::array<float, 3>& to) const;
  /// The same for a probe that prescribes a rotation, in a pose, and the rotations of the elements.
  std::vector<float> displacedBy(const Pose& to, const Vector3& spacing) const;
  std::vector<float> rotationsIn(const Pose& to) const;
};

/// The handles of all probes, in the order of the probes.
class Handles
{
public:
  using Pointer = std::shared_ptr<Handle>;

  /// What a probe grabs: elements, ascending, and how many voxels each of them stands for on average, counted as
  /// energies count in a reduced model (Simulation).
  struct Grabbed
  {
    std::vector<std::size_t> elements;
    double share = 1.0;
  };
  /// A rigid body that is held by several handles, given by their indices in a list, and by nothing else.
  struct SharedBody
  {
    std::vector<std::size_t> voxels; ///< ascending, with all that these handles hold
    std::vector<std::size_t> handles;
  };
  /// Finds the shared bodies of these handles.
  using SharedBodies = std::function<std::vector<SharedBody>(const std::vector<Pointer>&)>;

  /// Finds what probes with these numbers grab, as elementsAround() does.
  using Grab = std::function<std::vector<Grabbed>(const std::vector<Probe>&, const std::vector<std::size_t>& numbers)>;

  /// `origin`: the place of the first element of `bricks` [mm], see Grid; positions of probes refer to the grid of
  /// voxels.
  Handles(Bricks& bricks, const Vector3& origin, Grab grab)
    : bricks_(bricks)
    , origin_(origin)
    , grab_(std::move(grab))
  {
  }

  const std::vector<Pointer>& all() const { return this->handles_; }
  const Vector3& origin() const { return this->origin_; }

  /// The handles that a new list of probes changes.
  struct Change
  {
    std::vector<Pointer> moved; ///< new handles and handles that are to move elsewhere, in the order of the probes
    std::vector<Pointer> released;
    bool soft = false; ///< whether soft links change; `moved` and `released` contain no soft probe
  };

  /// Replaces the probes by exactly these (Simulation::hold). Tissue that is grabbed is held at once; tissue that is
  /// released stays held until letGo(). Throws InputError before it has changed anything.
  Change take(const std::vector<Probe>& probes);

  /// A handle for a wave of a body that several probes hold. It moves the body by the rigid motion that brings their
  /// elements nearest to where the probes request them (least squares). Null where all request the same motion, so that
  /// nothing has to rotate. It counts as one of all() for setHeld() until part().
  Pointer join(const std::vector<std::size_t>& voxels, const std::vector<Pointer>& handles);
  void part(const std::vector<Pointer>& joined);

  /// Marks the tissue of released handles as no longer held, except where another handle holds it now.
  void letGo(const std::vector<Pointer>& released);

  /// Removes all handles; their tissue is no longer held.
  void clear();

  /// Removes carved elements from every handle.
  void forget(const std::vector<std::size_t>& voxels);

  /// Marks tissue on the device as held, so that only its own probe moves it. `isHeld(handle)` says which handles hold
  /// their tissue from now on.
  template <typename F> void setHeld(const F& isHeld)
  {
    std::vector<Pointer> changed;
    for (const std::vector<Pointer>* handles : { &this->handles_, &this->joined_ })
    {
      for (const Pointer& handle : *handles)
      {
        if (!handle->isSoft() && handle->held != isHeld(*handle))
        {
          handle->held = !handle->held;
          changed.push_back(handle);
        }
      }
    }
    this->mark(changed);
  }

  /// The voxels of all handles that are not soft.
  std::vector<std::size_t> voxels() const;
  /// The voxels of those that hold their elements in a pose.
  std::vector<std::size_t> rotatingVoxels() const;

  /// The links by which soft probes pull now, one for each voxel, for Bricks::setSoftLinks().
  std::vector<SoftLink> softLinks() const;

  /// The force of a soft probe on its elements at their current places: minus the derivative of its energy by a common
  /// displacement of all of them. In a reduced model forces are scaled as energies are.
  Vector3 softForce(const Handle& handle);

  /// How far each probe has come since it grabbed [mm], and how many elements it holds.
  std::vector<ProbeResult> reached();

private:
  std::vector<Pointer> make(
    const std::vector<Probe>& probes, const std::vector<Grabbed>& grabbed, std::unordered_set<std::size_t>& taken);
  Pointer changed(const Probe& probe, const Handle& before, std::unordered_set<std::size_t>& taken);
  bool isAnchored(std::size_t voxel) const;
  std::vector<float> softPlaces(const Handle& handle) const;
  double softWeight(const Handle& handle) const;
  void fill(const std::vector<Pointer>& handles, const std::vector<std::size_t>& places);
  void mark(const std::vector<Pointer>& handles);
  void check(const Probe& probe, std::size_t number) const;
  void follow(Handle& handle, const float* displacement);

  Bricks& bricks_;
  Vector3 origin_;
  Grab grab_;
  std::vector<Pointer> handles_;
  std::vector<Pointer> joined_;
};

}
