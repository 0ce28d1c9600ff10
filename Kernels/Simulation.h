#pragma once

#include "Types.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace chainmail
{

/// Deformable tissue on an OpenCL device. Every call returns when its work is done.
///
/// Threads: a simulation may be used by one thread at a time. Different simulations may be used in different threads at
/// once, even on the same device, where they take turns; a kernel that one of them is building makes the others wait.
///
/// The state is the displacement of every element, in float32, as a fraction of the spacing. It is kept in bricks that
/// are allocated when a deformation first reaches them. Between two calls the state is feasible: every link obeys
/// |u(i) - u(j)| <= D(i,j) on every axis, to float rounding. There are two exceptions: while a wave is under way, and
/// from a relaxation by the published method until the next projected one.
///
/// With Settings::modelReduction n an element stands for n x n x n voxels and exists where any of them is tissue. Its
/// constraint is the mean of their constraints; it is rigid or anchored where any of them is. Two elements are linked
/// where any of their voxels are. Voxels are displaced by interpolation between those elements around them that are on
/// their own side of every cut, and rigid voxels exactly like their own element. Calls that read or write the grid
/// (displacements, times, clusters, links, cuts, carves, resampling) still work voxel by voxel. A probe holds the
/// elements of which it grabs at least half the voxels, or else the one of which it grabs most. Energies and forces
/// count a link n x n times, so they are comparable with those of the whole model. Bodies closer than n voxels may
/// stick together, and bone is up to n - 1 voxels thicker.
///
/// With Settings::rotations every element has a rotation R, too, and a rigid cluster moves and rotates as a body. A
/// link from i to j, of the vector x at rest, obeys |u(j) - u(i) - w| <= D(i,j) with the rest offset
/// w = 1/2 ((R(i) - I) x + (R(j) - I) x). Its energy is
///
///   W / 2 (|u(j) - u(i) - (R(i) - I) x|^2 + |u(j) - u(i) - (R(j) - I) x|^2),  W = v / (|x|^2 D(i,j)),
///
/// v the edge length of a cube as large as an element. So rotating tissue as a whole costs nothing. Where nothing
/// rotates and elements are cubes, the energy is that without rotations. A cluster of which a probe holds one element
/// rotates about that element. One of which elements on a line are held rotates about this line. With more held
/// elements or an anchor it does not rotate, and no cluster does where constraints differ by axis. Waves translate
/// tissue and do not rotate it, so a probe that falls short of its target tries again after tissue has settled a
/// little. Rotations add up to any angle, also beyond half a turn. Calls for Timestamp, Paper or an elastic recovery
/// other than 1 throw InputError.
///
/// With Settings::poissonRatio n tissue also resists changes of volume: an element i has the further energy
///
///   n / (1 - 2 n) v / D(i) d^2,  d = sum over its links of D(i) / (D(i) + D(j)) (strain along R x relative to |x|).
///
/// d is its volumetric strain, and D(i) / (D(i) + D(j)) the share of the strain in its own half of the link. Links to
/// rigid elements do not count. For small strains of homogeneous tissue the energy is that of Hooke's law with a shear
/// modulus of 1 / D. Propagation and limits are the same as without.
///
/// Errors are exceptions of Error.h. Every call that needs the device may throw DeviceError or MemoryError; after that
/// only the destructor may be called. After InputError the state is as before the call. Every call that reports
/// progress may throw Aborted; the tissue is then at rest with all probes released, except after resample(), which
/// changes no state.
class Simulation
{
public:
  /// Called with the share that is done, 0 to 1. Returning false stops the call, which then throws Aborted.
  using Progress = std::function<bool(double)>;

  /// Throws InputError where a setting cannot be used, for example Poisson's ratio without rotations. Also where a
  /// model that is divided into bodies (Joints) is to be reduced, because reduction would join them again. Throws
  /// DeviceError where there is no such device.
  Simulation(std::shared_ptr<const Model> model, const Settings& settings);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  const Model& model() const;
  const std::string& deviceName() const;
  Index3 brickSize() const;

  /// The peak of the bytes of buffers on the device since the last call of this function, summed over all simulations
  /// of this process on that device. Memory that a CPU device keeps for the next buffers after some are freed is not
  /// counted; together with the buffers it never exceeds their earlier peak.
  std::size_t takePeakDeviceBytes();

  /// The function to which long calls report progress from now on; null for none.
  void setProgress(Progress progress);

  /// The function that calls invoke several times a second while they wait for the device's compiler; null for none.
  /// They wait where kernels are used for the first time and are not in the cache of compiled kernels. Where it returns
  /// false, propagate(), relax(), update() and resample() stop as they do for setProgress().
  void setCompiling(std::function<bool()> compiling);

  /// How waves that start from now on travel. Finishes a wave that is under way first. Default: Envelope, Limit.
  void setPropagation(PropagationMethod method, ConflictPolicy policy);

  /// Whether to keep what propagationTimes() and wavefronts() report, for waves that start from now on. Timestamp
  /// always keeps it. Default: off.
  void setPropagationTimes(bool wanted);

  /// How tissue settles from now on. With `elasticRecovery` r, strain of a link up to (1 - r) of its limit costs no
  /// energy, and this much strain remains when tissue is released. Default: Projected, 1. Throws InputError where r is
  /// not in [0, 1].
  void setRelaxation(RelaxationMethod method, double elasticRecovery);

  /// Whether the first relaxation after a wave, cut or carve starts on coarser grids (Projected only) and, with 20
  /// iterations or more and where no rigid cluster can move, is corrected there. The energy still does not rise: a step
  /// that would raise it is applied only in part, or not at all. Default: off.
  void setCoarseToFine(bool wanted);

  /// Puts everything back to its rest place and releases all probes. Cuts and carves stay.
  void reset();

  /// Does what reset() does, and restores all links and all carved tissue.
  void restoreTopology();

  /// Finishes the waves that are under way, then removes the links whose segment, between the current places of their
  /// two elements, crosses the surface. The decision is exact: neighbouring triangles leave no gap. Returns the number
  /// of links removed. Throws InputError where a point is not finite or too far away, or a triangle names a point that
  /// is missing.
  std::size_t cut(const Surface& surface);

  /// Finishes the waves that are under way, then removes the elements whose current place lies inside a closed surface,
  /// with their links; probes let go of them. Exact like cut(). A place is inside where the surface winds around it, in
  /// whichever direction; parts that lie within others and face the other way are hollows (ClosedSurface). Returns the
  /// number of elements removed, and in `parts` what the surface is made of. Throws InputError as cut() does, and where
  /// the surface is not closed.
  std::size_t carve(const Surface& surface, SurfaceParts* parts = nullptr);

  /// Holds exactly these probes from now on. A probe with the position, radius, `rotates` and `body` of one that is
  /// already held is that same probe, moved where its displacement changed. Any other probe grabs the tissue that is at
  /// its place now. Probes that are no longer in the list are released where they are. Moves nothing yet: propagate()
  /// does, and relax() does for soft probes, which propagate() ignores. A probe may become soft, or cease to be, and
  /// stays the same. Throws ProbeError for a probe without tissue at its place, or with an invalid position,
  /// displacement, radius or tolerance.
  ///
  /// A probe that `rotates` takes what it grabs from x to c + displacement + R (x - c), with c its centre and R its
  /// rotation. The elements rotate by R, too. With each rigid element it grabs the whole rigid cluster. Unless the
  /// probe is soft, the cluster then has exactly this pose. A probe that is not soft also grabs elements of a
  /// constraint up to 0.12 in the notches of the cluster: those with two links to it or to others of these, up to three
  /// layers. The rotations of other elements settle with the tissue. It needs Settings::rotations and constraints that
  /// are the same for all axes.
  void hold(const std::vector<Probe>& probes);

  /// Lets the waves of moved probes travel, in the order in which the probes were moved, for at most `iterations` (0:
  /// until nothing changes). An iteration of Timestamp is one link; one of Envelope is a pass over all bricks that a
  /// wave has reached. Throws InputError where the number is negative.
  ///
  /// With Envelope, probes that one call of hold() moved form one wave if they are compatible with each other and with
  /// the tissue that is held. If not, one half of them goes before the other, and so on recursively. With Timestamp
  /// each probe has a wave of its own. A wave starts when those before it have finished; with Timestamp and Latest it
  /// starts at once, and where waves overlap the later one prevails.
  ///
  /// With Settings::rotations, several probes that one call moved may be all that holds a free rigid cluster. If the
  /// call moved at most 32 probes and they do not Share, they then move the cluster together: by the rigid motion that
  /// brings their elements nearest to their targets (least squares).
  ///
  /// Probes that rotate, and such clusters, rotate by at most 7.5 degrees in a wave, or less where that is too far. All
  /// that move together go the same share of their paths. With `iterations` 0 tissue then settles a little and they
  /// continue, until they reach their targets or gain nothing more. Otherwise they stay there until they are moved
  /// again.
  PropagateResult propagate(int iterations = 0);

  /// Calls hold() and propagate() to the end, and returns what each probe reached. Forces come from probes() alone.
  std::vector<ProbeResult> pull(const std::vector<Probe>& probes);

  /// Lowers the energy in at most `iterations`. Stops after one in which no element moved more than `tolerance`, a
  /// fraction of the spacing. Where it started on coarser grids (setCoarseToFine()), it also stops where its distance
  /// from the optimum is estimated to be at most `error`: the root mean square over displaced elements, as a fraction
  /// of the largest displacement. 0: no estimate. While a wave is under way, Timestamp relaxes the elements that the
  /// wave does not move, and Envelope none. Throws InputError where a number is negative.
  RelaxResult relax(int iterations, double tolerance, double error = 0.0);

  /// Deforms tissue in one call, after cuts and carves. State and results are those of these single calls, bit for
  /// bit: reset() where Update::fromRest says so; setPropagation() where the method or the policy differs from the
  /// present one; setRelaxation(), setCoarseToFine(), setPropagationTimes(), hold(), propagate(), relax(), probes() and
  /// measure(). So without Update::fromRest probes that are already held move on, and waves that are under way
  /// continue.
  ///
  /// `begins` is called when a part begins; the share that setProgress() reports starts at 0 in each part. Where it
  /// returns false, the call throws Aborted, with tissue at rest and all probes released. Throws what the single calls
  /// throw. The calls before the one that throws have then had their effect.
  UpdateResult update(const Update& update, const std::function<bool(UpdatePart)>& begins = nullptr);

  /// The probes of the last hold() or update(), in their order, with what they have reached and their forces.
  std::vector<ProbeResult> probes() const;

  /// What keeps a probe, given by its number, from moving further on the axis on which it lacks most [mm]; the nearest
  /// one where several do. This searches on the host through the tissue that the probe strains, so it is meant for the
  /// few probes that got much less than they asked for. Throws InputError where there is no probe of that number.
  Limiter limiter(std::size_t probe) const;

  /// The bodies of rigid tissue as it is now, in the order of their first voxels; cuts and carves may have divided
  /// them, and so may Joints. A probe with a displacement holds a body as an anchor does.
  std::vector<RigidBody> bodies() const;

  /// Energy, violations, displaced elements and memory of the present state.
  Statistics measure() const;

  // --- Values of voxels: those of a box, or of the whole grid

  /// Displacements [mm], 3 interleaved floats a voxel; 0 in air. Where the model is reduced,
  /// voxels at a cut may be displaced differently after it. `zeroed` says that `out` is already all 0; then only the
  /// values of tissue that may have moved are written.
  void displacements(const VoxelBox& box, float* out, bool zeroed = false) const;
  void displacements(float* out, bool zeroed = false) const { this->displacements(this->whole(), out, zeroed); }

  /// When the last wave that reached each element arrived there: the length of the shortest path of links from the
  /// probe, as a fraction of the spacing. `axes()` interleaved values a voxel; -1 where no wave came.
  void propagationTimes(const VoxelBox& box, float* out) const;
  void propagationTimes(float* out) const { this->propagationTimes(this->whole(), out); }

  /// The number of the last wave that reached each element, counted since reset() from 1 on; 0 where none came. Laid
  /// out as in propagationTimes(); `zeroed` as in displacements().
  void wavefronts(const VoxelBox& box, int* out, bool zeroed = false) const;
  void wavefronts(int* out, bool zeroed = false) const { this->wavefronts(this->whole(), out, zeroed); }

  /// The rigid cluster of each element and axis: elements of equal numbers move as one; -1 where the element is not
  /// rigid. `axes()` interleaved values a voxel, numbered from 0 in the order of the clusters' first voxels.
  void clusters(const VoxelBox& box, int* out) const;
  void clusters(int* out) const { this->clusters(this->whole(), out); }

  /// 1 where there is tissue now, 0 in air and where it was carved away. One value a voxel.
  void elements(const VoxelBox& box, std::uint8_t* out) const;
  void elements(std::uint8_t* out) const { this->elements(this->whole(), out); }

  /// Which of an element's links exist: bit 0 x-, 1 x+, 2 y-, 3 y+, 4 z-, 5 z+. One value a voxel, 0 in air.
  /// `ofPictures`: links across free joints (Joints) count as existing, as they do for resample().
  void links(const VoxelBox& box, std::uint8_t* out, bool ofPictures = false) const;
  void links(std::uint8_t* out, bool ofPictures = false) const { this->links(this->whole(), out, ofPictures); }

  // --- Output

  /// Finds where the material of each output voxel comes from. Output voxels are those of the grid and `padding` more
  /// on every side; `detail` may select a part of them, and further voxels between them. Offsets are in voxels of the
  /// grid. `visit` gets boxes that do not overlap. Together they cover every voxel that may differ from an earlier
  /// resampling with this padding and detail, which `since` names by its number; with `since` 0, every voxel that
  /// changed. Tissue that is displaced by less than a millionth of a voxel on every axis counts as at rest. Throws
  /// InputError where a padding is negative, the output cannot be as fine or there was no such resampling. Changing
  /// `cuts`, the padding or the detail since the last resampling starts anew.
  Resampled resample(const Index3& padding, const BoxVisitor& visit, std::uint64_t since = 0,
    CutSurfaces cuts = CutSurfaces::Stepped, const OutputDetail& detail = {}) const;

  /// Exports the tissue that Resamplers in other processes need, each for its part of such an output. The parts differ
  /// only in which voxels they have. Calls take(n, message) for receiver n, in its order, once or more often with
  /// messages of up to some MB. A receiver gets displacements only where they have changed since what it holds. Throws
  /// InputError as resample() does.
  void exportTissue(const Index3& padding, CutSurfaces cuts, const std::vector<TissueReceiver>& receivers,
    const std::function<void(std::size_t n, const std::vector<char>& message)>& take) const;

  /// The portions in which a part of such an output has to be exported, where the model is reduced and the
  /// displacements of all voxels would need too much memory. Together they cover all of the part that tissue may have
  /// left or reached. Each replaces what its receiver holds. None where there is enough memory.
  std::optional<std::vector<OutputDetail>> portions(
    const Index3& padding, CutSurfaces cuts, const OutputDetail& part) const;

  /// The voxels of the grid that a part of such an output may show. Loads the tissue that resample() needs for it, so
  /// that needs no rows of the model.
  Sources sources(const Index3& padding, CutSurfaces cuts, const OutputDetail& detail) const;

private:
  VoxelBox whole() const { return VoxelBox::all(this->model().grid()); }

  class Impl;
  struct Release
  {
    void operator()(Impl* impl) const;
  };
  std::unique_ptr<Impl, Release> impl_;
};

}
