#include "Readout.h"

#include "ElementRule.h"
#include "ElementRuns.h"
#include "Elements.h"
#include "Threads.h"
#include "VolumetricStrain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace chainmail
{

namespace
{

/// The links that lead out of handles, for one component of the constraint, and the forces of these links.
class OutgoingLinks
{
public:
  OutgoingLinks(
    Bricks& bricks, const Handles& handles, int component, const Elasticity& elasticity, double linksPerLink)
    : bricks_(bricks)
    , probes_(handles)
    , component_(component)
    , softElements_(bricks)
    , elasticity_(elasticity)
    , linksPerLink_(linksPerLink)
    , inner_(bricks)
    , outer_(bricks)
  {
  }

  /// Adds the links that lead out of a handle. `voxels` (ascending) move with it.
  void add(std::size_t handle, const std::vector<std::size_t>& voxels)
  {
    const Grid& grid = this->bricks_.model().grid();
    const SoftLinks* soft = this->bricks_.softLinks();
    for (const std::size_t voxel : voxels)
    {
      const Index3 at = grid.indexOf(voxel);
      if (const SoftLink* link = soft ? soft->of(voxel) : nullptr)
      {
        this->soft_.push_back({ handle, link });
        this->softElements_.add(at);
      }
      this->bricks_.forNeighbours(at,
        [&](int direction, const Index3& next)
        {
          if (std::binary_search(voxels.begin(), voxels.end(), grid.at(next[0], next[1], next[2])))
          {
            return;
          }
          const auto link =
            this->bricks_.link(this->constraintOf(at), this->constraintOf(next), direction, this->component_);
          if (link.exists)
          {
            this->handles_.push_back(handle);
            this->inner_.add(at);
            this->outer_.add(next);
            this->limits_.push_back(link.limit);
            this->directions_.push_back(direction);
            this->places_.push_back(at);
            if (this->hasPressure())
            {
              this->addShares(at, next);
            }
          }
        });
    }
  }

  std::size_t count() const { return this->limits_.size() + this->soft_.size(); }

  /// Adds to each handle's force the pull of its links, and forgets the links.
  void pull(std::vector<ProbeResult>& results)
  {
    const std::vector<float> ui = this->inner_.displacements();
    const std::vector<float> uj = this->outer_.displacements();
    const Rotations* rotations = this->bricks_.rotations();
    const std::vector<float> si = rotations ? this->inner_.rotations() : std::vector<float>();
    const std::vector<float> sj = rotations ? this->outer_.rotations() : std::vector<float>();
    const std::vector<float> ti = this->hasPressure() ? this->inner_.pressures() : std::vector<float>();
    const std::vector<float> tj = this->hasPressure() ? this->outer_.pressures() : std::vector<float>();
    for (std::size_t m = 0; m < this->limits_.size(); ++m)
    {
      const Vector3 before = results[this->handles_[m]].force;
      for (int a = 0; a < 3; ++a)
      {
        if (this->bricks_.model().axes() == 1 || a == this->component_)
        {
          // The derivative of weight * pull^2 by u, in physical units: spacings cancel.
          double pull = 0.0;
          if (rotations)
          {
            const int direction = this->directions_[m];
            pull = static_cast<double>(uj[3 * m + a]) - ui[3 * m + a] -
                   rotations->restOffset(&si[3 * m], &sj[3 * m], direction, a);
            pull *= rotations->weight(direction / 2) * rotations->proportions.s[a];
          }
          else
          {
            pull = this->elasticity_.pull(ui[3 * m + a], uj[3 * m + a], this->limits_[m]);
          }
          results[this->handles_[m]].force[a] -=
            2.0 * this->linksPerLink_ * Elasticity::weight(this->limits_[m]) * pull;
          if (this->hasPressure())
          {
            // The pressure of each end acts along the link as rotated by that end (volumetricstrain.clh).
            const int direction = this->directions_[m];
            const double way = (direction % 2 == 0 ? -1.0 : 1.0) / rotations->proportions.s[direction / 2];
            results[this->handles_[m]].force[a] -=
              this->linksPerLink_ * way *
              (static_cast<double>(this->shares_[m][0]) * ti[m] * leverArmOf(&si[3 * m], direction / 2, a) +
                static_cast<double>(this->shares_[m][1]) * tj[m] * leverArmOf(&sj[3 * m], direction / 2, a));
          }
        }
      }
      if (this->probes_.all()[this->handles_[m]]->probe.rotates)
      {
        this->addTorque(m, before, &ui[3 * m], &uj[3 * m], &si[3 * m], results[this->handles_[m]]);
      }
    }
    this->pullSoft(results);
    this->handles_.clear();
    this->places_.clear();
    this->inner_.clear();
    this->outer_.clear();
    this->limits_.clear();
    this->directions_.clear();
    this->shares_.clear();
  }

private:
  /// Adds the forces of soft links, which lead out of a handle, too.
  void pullSoft(std::vector<ProbeResult>& results)
  {
    const std::vector<float> u = this->softElements_.displacements();
    for (std::size_t m = 0; m < this->soft_.size(); ++m)
    {
      const SoftPull& soft = this->soft_[m];
      for (int a = 0; a < 3; ++a)
      {
        if (this->bricks_.model().axes() == 1 || a == this->component_)
        {
          results[soft.handle].force[a] -= 2.0 * this->linksPerLink_ * soft.link->weight *
                                           (soft.link->place[a] - u[3 * m + a]) *
                                           this->bricks_.softLinks()->proportions().s[a];
        }
      }
    }
    this->soft_.clear();
    this->softElements_.clear();
  }

  bool hasPressure() const { return this->bricks_.rotations() && this->bricks_.rotations()->hasPressure(); }

  /// Adds the moment of a link about the centre of its handle: lever arm x force, and the derivative of the link's
  /// energy by the rotation of the element with the handle. `before`: the force of the handle without this link.
  void addTorque(std::size_t link, const Vector3& before, const float* ui, const float* uj, const float* si,
    ProbeResult& result) const
  {
    const Grid& grid = this->bricks_.model().grid();
    const Handle& handle = *this->probes_.all()[this->handles_[link]];
    const Rotations& rotations = *this->bricks_.rotations();
    const int direction = this->directions_[link];
    Vector3 arm;
    Vector3 force;
    Vector3 way;    // the unstrained link, by the rotation of its inner end [mm]
    Vector3 strain; // derivative by u(i) of the energy of the deviation from that [energy / mm]
    for (int a = 0; a < 3; ++a)
    {
      arm[a] = this->probes_.origin()[a] + (this->places_[link][a] + static_cast<double>(ui[a])) * grid.spacing[a] -
               (handle.probe.centre[a] + handle.pose.shift[a]);
      force[a] = result.force[a] - before[a];
      const double rest = (direction % 2 == 0 ? -1.0 : 1.0) * (a == direction / 2 ? 1.0 : 0.0);
      const double wanted = rotations.restOffset(si, si, direction, a);
      way[a] = (rest + wanted) * grid.spacing[a];
      strain[a] = -this->linksPerLink_ * Elasticity::weight(this->limits_[link]) * rotations.weight(direction / 2) *
                  rotations.proportions.s[a] * (static_cast<double>(uj[a]) - ui[a] - wanted);
    }
    for (int a = 0; a < 3; ++a)
    {
      const int b = (a + 1) % 3;
      const int c = (a + 2) % 3;
      result.torque[a] += arm[b] * force[c] - arm[c] * force[b] + way[b] * strain[c] - way[c] * strain[b];
    }
  }

  /// Stores which shares of a link's strain are in the halves of its two ends.
  void addShares(const Index3& at, const Index3& next)
  {
    const float own = this->meanOf(at);
    const float other = this->meanOf(next);
    const bool counts = own > 0.0f && other > 0.0f;
    this->shares_.push_back({ counts ? own / (own + other) : 0.0f, counts ? other / (own + other) : 0.0f });
  }

  /// One constraint for an element, like meanConstraint() of volumetricstrain.clh.
  float meanOf(const Index3& at) const
  {
    const int axes = this->bricks_.model().axes();
    float c[3];
    this->bricks_.row(at[0], at[1], at[2], 1, c);
    float sum = 0.0f;
    for (int a = 0; a < axes; ++a)
    {
      if (c[a] == 0.0f)
      {
        return 0.0f;
      }
      sum += std::fabs(c[a]);
    }
    return sum / static_cast<float>(axes);
  }

  /// One component of R e, with e the unit vector along an axis and R the rotation `spin`.
  static double leverArmOf(const float* spin, int along, int axis)
  {
    float offset[3];
    rule::single::rotationOffsetOfAxis(spin, along, offset);
    return offset[axis] + (axis == along ? 1.0 : 0.0);
  }

  float constraintOf(const Index3& at) const
  {
    float c[3];
    this->bricks_.row(at[0], at[1], at[2], 1, c);
    return c[this->component_];
  }

  struct SoftPull
  {
    std::size_t handle;
    const SoftLink* link;
  };

  Bricks& bricks_;
  const Handles& probes_;
  int component_;
  std::vector<SoftPull> soft_;
  Elements softElements_; ///< the elements that these links pull
  const Elasticity& elasticity_;
  double linksPerLink_;
  std::vector<std::size_t> handles_;
  Elements inner_;
  Elements outer_;
  std::vector<float> limits_;
  std::vector<int> directions_;              ///< from inner_ to outer_
  std::vector<Index3> places_;               ///< indices of the inner elements
  std::vector<std::array<float, 2>> shares_; ///< only where tissue resists changes of volume
};

}

void Readout::displacements(const VoxelBox& box, float* out, bool zeroed) const
{
  if (!zeroed)
  {
    std::fill(out, out + 3 * box.voxels(), 0.0f);
  }
  if (!this->reduction_ || this->reduction_->displaceAll())
  {
    this->readDisplacements(box, out);
    return;
  }
  for (const std::vector<int>& bricks : this->reduction_->displacedIn(box))
  {
    this->reduction_->displace(bricks);
    this->readDisplacements(box, out);
  }
}

/// Writes the displacements of bricks that are displaced now.
void Readout::readDisplacements(const VoxelBox& box, float* out) const
{
  const Grid& grid = this->voxels_.model().grid();
  const Bricks& bricks = this->voxels_;
  bricks.readSlots<float>({ { bricks.displacement(), 3 } }, bricks.slotsIn(box, bricks.dirtySlots()),
    [&](int slot, const Bricks::SlotValues<float>& u)
    {
      bricks.forRows(bricks.brick(slot), box,
        [&](const Bricks::Row& row, int first, int last, std::size_t at)
        {
          // Rows in which nothing moved are not written. So the system need not provide memory for them.
          bool moved = false;
          for (int i = first; i < last; ++i)
          {
            for (std::size_t a = 0; a < 3; ++a)
            {
              const float value = u(a, row.local(i));
              moved = moved || value != 0.0f || std::signbit(value); // -0 is written, too, whatever else its row holds
            }
          }
          float* to = moved ? out + 3 * at : nullptr;
          for (int i = first; to && i < last; ++i, to += 3)
          {
            for (std::size_t a = 0; a < 3; ++a)
            {
              to[a] = static_cast<float>(u(a, row.local(i)) * grid.spacing[a]);
            }
          }
        });
    });
}

void Readout::propagationTimes(const ArrivalTimes& arrivals, const VoxelBox& box, float* out) const
{
  if (!this->reduction_)
  {
    arrivals.readTimes(box, out);
    return;
  }
  const VoxelBox all = VoxelBox::all(this->bricks_.model().grid());
  std::vector<float> times(all.voxels() * this->voxels_.model().axes());
  arrivals.readTimes(all, times.data());
  for (float& time : times)
  {
    time *= time < 0.0f ? 1.0f : static_cast<float>(this->reduction_->voxelsPerElement());
  }
  this->reduction_->spread(times, -1.0f, box, out);
}

void Readout::wavefronts(const ArrivalTimes& arrivals, const VoxelBox& box, int* out, bool zeroed) const
{
  if (!this->reduction_)
  {
    arrivals.readFronts(box, out, zeroed);
    return;
  }
  const VoxelBox all = VoxelBox::all(this->bricks_.model().grid());
  std::vector<int> fronts(all.voxels() * this->voxels_.model().axes());
  arrivals.readFronts(all, fronts.data(), true);
  this->reduction_->spread(fronts, 0, box, out);
}

void Readout::clusters(const VoxelBox& box, int* out) const
{
  const Grid& grid = this->voxels_.model().grid();
  const std::size_t axes = static_cast<std::size_t>(this->voxels_.model().axes());
  std::fill(out, out + axes * box.voxels(), -1);
  for (std::size_t a = 0; a < axes; ++a)
  {
    for (const ElementRun& run : connectedRuns(this->voxels_, static_cast<int>(a), true))
    {
      const Index3 at = grid.indexOf(run.first);
      const int end = std::min(at[0] + static_cast<int>(run.count), box.first[0] + box.size[0]);
      for (int i = std::max(at[0], box.first[0]); i < end && box.contains(i, at[1], at[2]); ++i)
      {
        out[box.at(i, at[1], at[2]) * axes + a] = run.component;
      }
    }
  }
}

void Readout::elements(const VoxelBox& box, std::uint8_t* out) const
{
  const std::size_t axes = static_cast<std::size_t>(this->voxels_.model().axes());
  std::vector<float> row(box.size[0] * axes);
  for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
  {
    for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
    {
      this->voxels_.row(box.first[0], j, k, box.size[0], row.data());
      std::uint8_t* to = out + box.at(box.first[0], j, k);
      for (int i = 0; i < box.size[0]; ++i)
      {
        to[i] = std::isinf(row[i * axes]) ? 0 : 1;
      }
    }
  }
}

void Readout::links(const VoxelBox& box, std::uint8_t* out, bool ofPictures) const
{
  // Links lead to the voxels around the box, too.
  const Grid& grid = this->voxels_.model().grid();
  VoxelBox wide;
  for (int a = 0; a < 3; ++a)
  {
    wide.first[a] = std::max(box.first[a] - 1, 0);
    wide.size[a] = std::min(box.first[a] + box.size[a] + 1, grid.size[a]) - wide.first[a];
  }
  std::vector<std::uint8_t> tissue(wide.voxels());
  this->elements(wide, tissue.data());
  const std::size_t step[3] = { 1, static_cast<std::size_t>(wide.size[0]),
    static_cast<std::size_t>(wide.size[0]) * wide.size[1] };
  inParallel(static_cast<std::size_t>(box.size[2]),
    [&](std::size_t slice)
    {
      const int k = box.first[2] + static_cast<int>(slice);
      for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
      {
        for (int i = box.first[0]; i < box.first[0] + box.size[0]; ++i)
        {
          const std::size_t voxel = wide.at(i, j, k);
          const Index3 at{ i, j, k };
          unsigned bits = 0;
          for (int a = 0; tissue[voxel] != 0 && a < 3; ++a)
          {
            bits |= at[a] > 0 && tissue[voxel - step[a]] != 0 ? CUT_BIT(2 * a) : 0;
            bits |= at[a] + 1 < grid.size[a] && tissue[voxel + step[a]] != 0 ? CUT_UP_BIT(a) : 0;
          }
          const Links& links = this->voxels_.links();
          const unsigned gone = bits == 0 ? 0 : ofPictures ? links.shownBits(i, j, k) : links.cutBits(i, j, k);
          out[box.at(i, j, k)] = static_cast<std::uint8_t>(bits & ~gone);
        }
      }
    });
}

std::vector<std::size_t> Readout::voxelsOf(std::size_t element) const
{
  return this->reduction_ ? this->reduction_->voxelsOf(element) : std::vector<std::size_t>{ element };
}

std::vector<RigidBody> Readout::bodies(const Handles& handles, const RigidClusters& clusters) const
{
  const Model& model = this->voxels_.model();
  std::vector<RigidBody> bodies;
  clusters.forClusters(
    [&](auto first, auto last, bool anchored)
    {
      RigidBody body;
      body.voxel = this->voxelsOf(*first).front();
      body.elements = static_cast<std::size_t>(last - first);
      body.limiter.bone = anchored;
      body.limiter.what = anchored ? Limiter::What::Rigid : Limiter::What::Nothing;
      for (; body.limiter.what == Limiter::What::Rigid && first != last; ++first)
      {
        for (const std::size_t voxel : this->voxelsOf(*first))
        {
          const Index3 at = model.grid().indexOf(voxel);
          const int face = model.anchoringFace(at[0], at[1], at[2]);
          if (face >= 0 && body.limiter.what == Limiter::What::Rigid)
          {
            body.limiter.what = Limiter::What::Face;
            body.limiter.face = face;
          }
        }
      }
      bodies.push_back(body);
    });
  for (std::size_t n = 0; n < handles.all().size(); ++n)
  {
    if (handles.all()[n]->isSoft())
    {
      continue;
    }
    for (const std::size_t element : handles.all()[n]->voxels)
    {
      const int id = clusters.clusterOf(element, 0);
      if (id >= 0 && bodies[id].limiter.what == Limiter::What::Nothing)
      {
        bodies[id].limiter.what = Limiter::What::Probe;
        bodies[id].limiter.probe = n;
        bodies[id].limiter.bone = true;
      }
    }
  }
  return bodies;
}

/// Adds the force of each handle: the gradient of the energy by a displacement of its voxels together with the bone
/// that they are part of. Of soft probes: the forces of their links.
void Readout::addForces(std::vector<ProbeResult>& results, Handles& handles, const RigidClusters& clusters,
  const Elasticity& elasticity) const
{
  constexpr std::size_t linksPerTransfer = std::size_t(1) << 20;
  for (std::size_t handle = 0; handle < results.size(); ++handle)
  {
    if (handles.all()[handle]->isSoft())
    {
      results[handle].force = handles.softForce(*handles.all()[handle]);
      for (double& force : results[handle].force)
      {
        force *= this->reduction_ ? this->reduction_->linksPerLink() : 1.0;
      }
    }
  }
  updatePressureAround(this->bricks_, this->bricks_.dirtySlots());
  const int axes = this->bricks_.model().axes();
  for (int component = 0; component < axes; ++component)
  {
    OutgoingLinks links(
      this->bricks_, handles, component, elasticity, this->reduction_ ? this->reduction_->linksPerLink() : 1.0);
    std::unordered_map<int, std::size_t> onlyThisBone; // per bone, the first handle that holds no other tissue
    std::vector<std::pair<std::size_t, std::size_t>> alike;
    for (std::size_t handle = 0; handle < results.size(); ++handle)
    {
      if (handles.all()[handle]->isSoft())
      {
        continue;
      }
      const std::vector<std::size_t>& held = handles.all()[handle]->voxels;
      const int bone = held.empty() ? -1 : clusters.clusterOf(held.front(), component);
      if (bone >= 0 && std::all_of(held.begin(), held.end(),
                         [&](std::size_t voxel) { return clusters.clusterOf(voxel, component) == bone; }))
      {
        const auto [first, isFirst] = onlyThisBone.emplace(bone, handle);
        if (!isFirst)
        {
          alike.emplace_back(first->second, handle);
          continue;
        }
      }
      links.add(handle, clusters.withClusters(held, component));
      if (links.count() > linksPerTransfer)
      {
        links.pull(results);
      }
    }
    links.pull(results);
    for (const auto& [first, same] : alike)
    {
      for (int a = 0; a < 3; ++a)
      {
        results[same].force[a] = axes == 1 || a == component ? results[first].force[a] : results[same].force[a];
      }
    }
  }
}

}
