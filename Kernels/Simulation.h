#pragma once

#include "Types.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace chainmail
{

/// Deformable tissue on an OpenCL device. Each call finishes before it returns. A simulation is for one thread at a
/// time; others, on the same device, too, may be used in other threads meanwhile: there they take turns, and a kernel
/// that one has to build the others wait for.
///
/// The state is the displacement of every element, in float32, as a fraction of the spacing, kept in bricks that are
/// allocated when a deformation first reaches them. Between any two calls the state is feasible: every link obeys
/// |u(i) - u(j)| <= D(i,j) on every axis, to float rounding. Exceptions: while a wave is under way, and after a
/// relaxation by the published method, until the next one by the projected.
///
/// With Settings::modelReduction n an element stands for n x n x n voxels and is where one of them is. It gives as much
/// as they do on average, and is rigid or anchored where one of them is; a link is where any of its voxels has one to a
/// voxel of the neighbour. Voxels are displaced as the elements around are, in between, on their own side of every cut,
/// and rigid ones exactly as their own element. What reads or writes the grid (displacements, times, clusters, links,
/// cuts, carves, resampling) does so voxel by voxel as ever. A probe holds the elements of which it grabs at least half
/// the voxels, else the one of which it grabs most. Energies and forces count n x n links for one, so that they compare
/// with those of the whole model. Bodies closer than n voxels may stick together, and bone is up to n - 1 voxels
/// thicker.
///
/// Errors are exceptions of Error.h. After InputError the state is as before the call. After Aborted it is at rest, but
/// for resample(), which changes no state. After DeviceError only the destructor may be called.
class Simulation
{
public:
  /// Called with the share done, 0 to 1; returns false to stop the call, which then throws Aborted.
  using Progress = std::function<bool(double)>;

  Simulation(std::shared_ptr<const Model> model, const Settings& settings);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  const Model& model() const;
  const std::string& deviceName() const;
  Index3 brickSize() const;

  /// The most bytes that buffers took on the device at once since the last call: those of all simulations of this
  /// process there.
  std::size_t takePeakDeviceBytes();

  void setProgress(Progress progress);

  /// How waves that start from now on travel; one that is under way is finished first. Default: Envelope, Limit.
  void setPropagation(PropagationMethod method, ConflictPolicy policy);

  /// Whether propagationTimes() and wavefronts() are wanted; Timestamp always keeps them. Default: off. Applies to
  /// waves that start from now on.
  void setPropagationTimes(bool wanted);

  /// How tissue settles from now on. `elasticRecovery`, r in [0, 1]: strain of a link up to (1 - r) of its limit costs
  /// no energy, so that much stays when tissue is released. Default: Projected, 1.
  void setRelaxation(RelaxationMethod method, double elasticRecovery);

  /// Whether the first relaxation after a wave, cut or carve starts on coarser grids (Projected only). The energy does
  /// not rise: of a correction that would raise it only a part is taken, or none. Default: off.
  void setCoarseToFine(bool wanted);

  /// Everything back to its rest place, all probes released. Cuts and carves stay.
  void reset();

  /// reset(), all links whole again and all carved tissue back.
  void mend();

  /// Removes the links whose segment, between the current places of their two elements, crosses the surface.
  /// Exact: neighbouring triangles leave no gap. Returns the number of links removed.
  std::size_t cut(const Surface& surface);

  /// Removes the elements whose current place lies inside a closed surface, with their links; probes let go of them.
  /// Exact as cut(). Returns their number. Throws InputError where the surface is not closed.
  std::size_t carve(const Surface& surface);

  /// Holds exactly these probes from now on. A probe of the same position and radius as one that is held already is
  /// that one, moved where its displacement changed; others grab the tissue that is at their place now, and probes that
  /// are no longer in the list are released where they are. Moves nothing yet: propagate() does.
  void hold(const std::vector<Probe>& probes);

  /// Lets the waves of moved probes travel, in the order in which the probes were moved, for at most so many iterations
  /// (0: until nothing changes). An iteration of Timestamp is one link; of Envelope, one pass over all bricks that a
  /// wave has reached.
  ///
  /// Envelope: probes that one call of hold() moved are one wave where they are compatible with each other and with
  /// what is held; else one half of them goes before the other, and so on. A wave starts when those before it have
  /// finished; with Timestamp, which gives each probe a wave of its own, and Latest it starts at once, and where waves
  /// overlap the later one prevails.
  PropagateResult propagate(int iterations = 0);

  /// hold(), propagate() to the end, and what was reached; forces come from probes().
  std::vector<ProbeResult> pull(const std::vector<Probe>& probes);

  /// Lowers the energy by at most so many iterations; stops when no element moved more than `tolerance` (a fraction of
  /// the spacing) in one. While a wave is under way, Timestamp relaxes the elements that it does not move, Envelope
  /// none.
  RelaxResult relax(int iterations, double tolerance);

  /// The probes of the last hold() in the current state.
  std::vector<ProbeResult> probes() const;

  /// What keeps one of these probes from going further, on the axis on which it lacks most [mm]: the nearest where
  /// several do. A search on the host through the tissue that the probe strains: meant for a few probes that got much
  /// less than they asked for.
  HeldBy heldBy(std::size_t probe) const;

  Statistics measure() const;

  /// Displacements of all voxels of the grid [mm], 3 interleaved floats each; 0 in air. Where the model is reduced,
  /// those of a cut's lips change with the cut. `zeroed`: all of `out` is 0 already; then only memory of tissue that
  /// may have moved is written to.
  void displacements(float* out, bool zeroed = false) const;

  /// When the last wave that came to each element did so: the length of the shortest path of links from the probe
  /// [fractions of the spacing], `axes()` interleaved values a voxel; -1 where none came.
  void propagationTimes(float* out) const;

  /// The number of that wave since reset(), from 1 on, likewise; 0 where none came. `zeroed` as for
  /// displacements().
  void wavefronts(int* out, bool zeroed = false) const;

  /// Rigid cluster of each element and axis: equal numbers move as one; -1 where the element is not rigid. `axes()`
  /// interleaved values a voxel, numbered from 0 in order of the clusters' first voxels.
  void clusters(int* out) const;

  /// 1 where there is tissue now, 0 in air and where it was carved away. One value a voxel.
  void elements(std::uint8_t* out) const;

  /// Which of an element's links exist: bit 0 x-, 1 x+, 2 y-, 3 y+, 4 z-, 5 z+. One value a voxel, 0 in air.
  void links(std::uint8_t* out) const;

  /// Finds where the material of each output voxel comes from; `visit` is called with boxes that do not overlap and
  /// cover every voxel that changed. Output voxels are those of the grid and `padding` more on every side.
  void resample(const Index3& padding, const std::function<void(const ResampledBox&)>& visit) const;

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}
