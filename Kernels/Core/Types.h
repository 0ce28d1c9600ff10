#pragma once

// The values that go into a simulation and come out of it (Simulation.h).

#include "Model.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace chainmail
{

/// Where and how a simulation runs.
struct Settings
{
  std::string device; ///< see chooseDevice()
  Index3 brickSize{ 0, 0,
    0 }; ///< elements per axis, each a power of two, x 4 to 64, y and z 2 to 32; 0 = best for the device
  bool rotations = false;    ///< whether tissue and rigid clusters rotate, see Simulation
  double poissonRatio = 0.0; ///< transverse over axial strain of tissue that rotates, [0, 0.49], see Simulation
  int modelReduction = 1;    ///< 1, 2, 4 or 8: voxels per element along each axis, see Simulation
};

/// A handle in the tissue. When it first appears it grabs the elements within `radius` of `position`, or the nearest
/// one, and from then on moves them together.
///
/// With a tolerance it is soft. A soft probe moves nothing by itself: a link without a limit pulls each of its elements
/// towards a target t, and Simulation::relax() balances that against all other links. Such a link has the energy
/// (u - t)^2 / tolerance on each axis [mm], with u the displacement of the element. A link between two elements, of
/// constraint D, has (u - v)^2 / (D h), h the spacing. So a tolerance compares with D h, the length by which that link
/// may stretch. Missing t by the tolerance costs as much as stretching a link of that D h to its limit. A tolerance
/// below a millionth of the spacing counts as a millionth. A soft probe holds nothing: elements may have any number of
/// soft probes, and be held besides. The target of a soft anchor is where its tissue was when it was grabbed.
struct Probe
{
  Vector3 position{};     ///< [mm], see Grid
  Vector3 displacement{}; ///< [mm], counted from where the tissue was when it was grabbed; an anchor ignores it
  double radius = 0.0;    ///< [mm], 0 = the nearest element
  bool anchor = false;    ///< hold the tissue where it is instead of moving it
  double tolerance = 0.0; ///< [mm], 0 = tissue goes exactly there, as far as limits allow; else the probe is soft

  /// Whether it prescribes a rotation, too (Simulation::hold()). An anchor ignores this, `rotation` and `centre`.
  bool rotates = false;
  Vector3 rotation{}; ///< [rad] rotation vector along the grid's axes since it grabbed; of any length
  Vector3 centre{};   ///< [mm] centre of the rotation, a position in the tissue as it was when it was grabbed

  /// The voxels (Grid::at) that it grabs where they are tissue; null: the tissue around its position. `body` is a
  /// number that distinguishes probes with different voxels.
  std::shared_ptr<const std::vector<std::size_t>> voxels;
  std::uint64_t body = 0;

  bool isSoft() const { return this->tolerance > 0.0; }
};

/// How a wave of displacement travels through tissue.
enum class PropagationMethod
{
  Envelope, ///< every element is clamped to the bounds of moved neighbours, until nothing changes (envelope.cl)
  Timestamp ///< the published method: one link an iteration, the earliest arrival counts (timestamp.cl)
};

/// What happens where probes pull tissue further apart than it can stretch. Anchors always hold. With Envelope, more
/// than 32 probes that start together share, whatever the policy.
enum class ConflictPolicy
{
  Limit,  ///< the later probe is shortened, per axis, to what the earlier ones allow
  Latest, ///< the later probe wins and drags the tissue of earlier ones along
  Share   ///< probes that start together all yield, to the mean of the bounds that their requests set (Sharing.h)
};

/// How tissue settles.
enum class RelaxationMethod
{
  Projected, ///< three-colour over-relaxation within the limits of the links (relax.cl)
  Paper      ///< the published method: all elements at once to the weighted mean, limits ignored (paper.cl)
};

/// How tissue deforms in Simulation::update(). The defaults are those of a new simulation, and no relaxation.
struct Method
{
  PropagationMethod propagation = PropagationMethod::Envelope;
  ConflictPolicy conflict = ConflictPolicy::Limit;
  int propagationIterations = 0; ///< the most of an update; 0: until all waves have come to their end
  RelaxationMethod relaxation = RelaxationMethod::Projected;
  double elasticRecovery = 1.0;     ///< [0, 1], see Simulation::setRelaxation()
  bool coarseToFine = false;        ///< see Simulation::setCoarseToFine()
  int relaxationIterations = 0;     ///< the most of an update
  double relaxationTolerance = 0.0; ///< largest move after which relaxation stops, as a fraction of the spacing
  double relaxationError = 0.0;     ///< see Simulation::relax()

  bool operator==(const Method& other) const
  {
    const auto all = [](const Method& m)
    {
      return std::tie(m.propagation, m.conflict, m.propagationIterations, m.relaxation, m.elasticRecovery,
        m.coarseToFine, m.relaxationIterations, m.relaxationTolerance, m.relaxationError);
    };
    return all(*this) == all(other);
  }
  bool operator!=(const Method& other) const { return !(*this == other); }
};

/// What Simulation::update() has to do.
struct Update
{
  bool fromRest = false; ///< first put everything back to its rest place and release all probes
  Method method;
  bool propagationTimes = false; ///< see Simulation::setPropagationTimes()
  std::vector<Probe> probes;     ///< all that are held from now on, see Simulation::hold()
};

/// The parts of Simulation::update(), in their order.
enum class UpdatePart
{
  Propagate, ///< also holds the probes
  Relax,     ///< also determines the forces of the probes
  Measure
};

/// What a propagation did.
struct PropagateResult
{
  int iterations = 0;
  bool finished = true;   ///< whether all waves have come to their end
  std::size_t shared = 0; ///< probes that did not get what they asked for because they share (ConflictPolicy)
};

/// What became of a probe.
struct ProbeResult
{
  Vector3 reached{}; ///< [mm] its displacement since it grabbed; shorter than asked where the tissue does not stretch
                     ///< so far (see Simulation::limiter()), where its wave has not started yet, or where a later probe
                     ///< dragged it back. Of a soft probe: the mean of its elements
  Vector3 force{}; ///< the force that it must exert: the gradient of the energy by the displacement of the tissue that
                   ///< it holds, with the bone that this is part of. Of a soft probe: the force of its links
  std::size_t elements = 0; ///< how many it grabbed, of the reduced model where the model is reduced
  /// Of a probe that `rotates`: its rotation since it grabbed [rad], as a rotation vector, and the torque that it must
  /// exert. This is the moment about its centre as moved, the gradient of the energy by the rotation. `reached` is then
  /// the displacement of its centre.
  Vector3 rotated{};
  Vector3 torque{};
};

/// What keeps a probe from reaching its displacement.
struct Limiter
{
  enum class What
  {
    Nothing, ///< it reached its displacement, or its wave has not come to its end
    Probe,   ///< tissue that another probe holds
    Face,    ///< tissue that is anchored at a face of the grid
    Rigid    ///< anchored rigid tissue
  };

  What what = What::Nothing;
  std::size_t probe = 0; ///< with Probe: the number of that other probe
  int face = 0;          ///< with Face: that face, as in Anchors::faces
  bool bone = false;     ///< the bone that the probe holds is itself held there; else tissue between is at its limits
  /// The joints at their limits on the path from the probe to what holds it, in this order: a voxel (Grid::at) of each
  /// body.
  std::vector<std::pair<std::size_t, std::size_t>> joints;
};

/// A body of rigid tissue, which moves as one: a rigid cluster (along x, where constraints differ by axis).
struct RigidBody
{
  std::size_t voxel = 0;    ///< its first voxel, Grid::at
  std::size_t elements = 0; ///< how many it has, of the reduced model where the model is reduced
  /// What holds it in place: an anchor (Face where one of its voxels is at an anchored face, else Rigid), or else a
  /// probe, the first of several; Nothing where it is free to move.
  Limiter limiter;
};

/// A cutting surface: triangles in [mm], see Grid. It need not be closed, flat or connected.
struct Surface
{
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
};

/// The parts of a closed surface: its connected components (Simulation::carve()).
struct SurfaceParts
{
  std::size_t count = 0;
  std::size_t mixed = 0;    ///< those with triangles that face both ways
  std::size_t hollows = 0;  ///< those that enclose what stays
  std::size_t reversed = 0; ///< those that face the other way than the largest part and are not hollows
};

/// What a relaxation did.
struct RelaxResult
{
  int iterations = 0;       ///< sweeps; a correction on coarser grids counts as 12
  double largestMove = 0.0; ///< of the last iteration, as a fraction of the spacing
  bool converged = false;
  std::optional<double> coarseStep; ///< where coarser grids took part (Simulation::setCoarseToFine()): the share of
                                    ///< their correction that was applied, 1 all, 0 none
  double coarseDrop = 0.0; ///< then: the share of the energy that this correction and the sweeps after it removed
};

/// Figures of the whole state: that of the reduced model where the model is reduced.
struct Statistics
{
  double energy = 0.0;        ///< sum over links and axes of max(0, |u(i) - u(j)| - (1 - r) D(i,j))^2 / D(i,j) [mm],
                              ///< and what soft probes add (Probe)
  double maxLinkExcess = 0.0; ///< largest violation of a link's limit, as a fraction of the spacing; 0 if none
  std::size_t displaced = 0;  ///< elements away from their rest place
  std::size_t allocated = 0;  ///< element places, also in air, whose displacement is stored on the device
  std::size_t deviceBytes = 0;
};

/// What an update did.
struct UpdateResult
{
  PropagateResult propagation;
  RelaxResult relaxation;
  std::vector<ProbeResult> probes; ///< in the order of Update::probes
  Statistics statistics;
};

/// How a resampling shows the surfaces along which tissue was cut or carved.
enum class CutSurfaces
{
  Stepped, ///< half way between two elements: a voxel shows tissue or none
  Smooth   ///< where the blade went: a voxel shows tissue in proportion to its share on the side of the tissue
};

/// A box of output voxels and the origin of their material, as an offset of 3 floats per voxel [voxels]: the material
/// at voxel y came from y + offset. 0: y shows what it showed before. NaN: tissue left y and none came.
struct ResampledBox
{
  Index3 first{}; ///< lowest voxel, in indices of the output (OutputDetail); may be negative when that is padded
  Index3 size{};
  const float* offset = nullptr; ///< of the lowest voxel
  Index3 step{};                 ///< floats between the offsets of adjacent voxels along each axis
  /// The coverage of the lowest voxel: the share of it, 0 to 1, that shows tissue and not what is behind a cut surface.
  /// Coverages of adjacent voxels are a third of `step` floats apart. Null: it is 1 everywhere. Below one half the
  /// centre of the voxel is outside tissue, and its offset leads to the adjacent tissue.
  const float* coverage = nullptr;

  std::size_t voxels() const { return static_cast<std::size_t>(this->size[0]) * this->size[1] * this->size[2]; }

  /// Calls f(voxel, offset) for each voxel, along x first. `offset` points to the 3 floats, which are NaN where the
  /// centre of the voxel is outside tissue.
  template <typename F> void forVoxels(F&& f) const
  {
    this->forCovered(
      [&f](const Index3& voxel, const float* at, float coverage)
      {
        constexpr float nan = std::numeric_limits<float>::quiet_NaN();
        const float nothing[3] = { nan, nan, nan };
        f(voxel, coverage < 0.5f ? nothing : at);
      });
  }

  /// Calls f(voxel, offset, coverage) for each voxel, along x first.
  template <typename F> void forCovered(F&& f) const
  {
    for (int k = 0; k < this->size[2]; ++k)
    {
      for (int j = 0; j < this->size[1]; ++j)
      {
        const std::ptrdiff_t begin = j * this->step[1] + k * this->step[2];
        for (int i = 0; i < this->size[0]; ++i)
        {
          const std::ptrdiff_t at = begin + i * this->step[0];
          f(Index3{ { this->first[0] + i, this->first[1] + j, this->first[2] + k } }, this->offset + at,
            this->coverage ? this->coverage[at / 3] : 1.0f);
        }
      }
    }
  }
};

/// Which part of an output is computed, and how finely. Output voxel `finer` * i is at voxel i of the grid.
struct OutputDetail
{
  static constexpr int most = 4;

  int finer = 1; ///< voxels per voxel of the grid along each axis, 1 to `most`; 1 along an axis with a single voxel
  /// The lowest and the highest voxel that is computed, in indices of the grid. Anything outside the output is left
  /// out.
  Index3 first{ { std::numeric_limits<int>::min(), std::numeric_limits<int>::min(), std::numeric_limits<int>::min() } };
  Index3 last{ { std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), std::numeric_limits<int>::max() } };

  bool operator==(const OutputDetail& other) const
  {
    return this->finer == other.finer && this->first == other.first && this->last == other.last;
  }
  bool operator!=(const OutputDetail& other) const { return !(*this == other); }
};

/// The voxels of the grid that a part of an output may show. Where offsets are 0, a voxel shows voxels of `resting`.
/// Every other offset leads into `moved`, which is empty where nothing moves into that part; places outside the grid
/// count as its nearest ones.
struct Sources
{
  VoxelBox resting;
  VoxelBox moved;
};

/// Which tissue of a simulation a Resampler holds.
struct TissueVersion
{
  std::uint64_t simulation = 0; ///< its number, unique in its process; 0: none
  std::uint64_t revision = 0;   ///< grows with every change of the tissue

  bool operator==(const TissueVersion& other) const
  {
    return this->simulation == other.simulation && this->revision == other.revision;
  }
};

/// A Resampler in another process, for Simulation::exportTissue().
struct TissueReceiver
{
  int number = 0;      ///< distinguishes it from others
  OutputDetail detail; ///< the part of the output that it is to resample
  TissueVersion has;   ///< what it holds: Resampler::version()
};

/// Gets one or more boxes at a time. Their pointers are valid until it returns.
using BoxVisitor = std::function<void(const std::vector<ResampledBox>&)>;

/// What a resampling found.
struct Resampled
{
  std::uint64_t number = 0; ///< of this resampling; later ones can continue from it
  bool atRest = true;       ///< every voxel shows what it showed before all deformation
};

}
