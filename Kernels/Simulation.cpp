#include "Simulation.h"

#include "Carving.h"
#include "CoarseToFine.h"
#include "Cutting.h"
#include "Error.h"
#include "HeldBy.h"
#include "Measurement.h"
#include "ModelReduction.h"
#include "PaperRelaxation.h"
#include "Relaxation.h"
#include "Resampling.h"
#include "Waves.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace chainmail
{

class Simulation::Impl
{
public:
  Impl(std::shared_ptr<const Model> model, const Settings& settings)
    : model_(std::move(model))
    , context_(Context::of(settings.device))
    , voxels_(this->context_, this->model_, settings.brickSize)
    , reduction_(settings.modelReduction == 1 ? nullptr : new ModelReduction(this->voxels_, settings.modelReduction))
    , bricks_(this->reduction_ ? this->reduction_->bricks() : this->voxels_)
    , handles_(this->bricks_, [this](const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers)
        { return this->grab(probes, numbers); })
    , waves_(this->bricks_, this->handles_)
    , relaxation_(this->bricks_)
    , coarseToFine_(this->bricks_, this->handles_)
    , paperRelaxation_(this->bricks_)
    , resampling_(this->voxels_)
  {
  }

  void setPropagation(PropagationMethod method, ConflictPolicy policy);
  void setRelaxation(RelaxationMethod method, double elasticRecovery);
  void reset();
  void mend();
  std::size_t cut(const Surface& surface);
  std::size_t carve(const Surface& surface);
  void hold(const std::vector<Probe>& probes);
  PropagateResult propagate(int iterations);
  RelaxResult relax(int iterations, double tolerance);
  std::vector<ProbeResult> probes();
  HeldBy heldBy(std::size_t probe);
  Statistics measure();
  void displacements(float* out, bool zeroed);
  void propagationTimes(float* out);
  void wavefronts(int* out, bool zeroed);
  void clusters(int* out);
  void elements(std::uint8_t* out);
  void links(std::uint8_t* out);
  void resample(const Index3& padding, const std::function<void(const ResampledBox&)>& visit);

  std::shared_ptr<const Model> model_;
  std::shared_ptr<Context> context_;
  Progress progress_;
  Bricks voxels_;                             ///< one element each
  std::unique_ptr<ModelReduction> reduction_; ///< null: none
  Bricks& bricks_;                            ///< of the elements that deform: the voxels, or those of the reduction
  Handles handles_;
  Waves waves_;
  bool startsCoarse_ = false;

private:
  void checkpoint(double share);
  Bricks& voxels();
  void moved();
  std::vector<std::vector<std::size_t>> grab(const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers);
  void addForces(std::vector<ProbeResult>& results);
  RigidClusters& rigidClusters();

  /// Runs a public call that checkpoints may stop.
  template <typename Body> auto stoppable(Body&& body) -> decltype(body())
  {
    try
    {
      return body();
    }
    catch (const Aborted&)
    {
      this->reset();
      throw;
    }
  }

  Relaxation relaxation_;
  CoarseToFine coarseToFine_;
  PaperRelaxation paperRelaxation_;
  RelaxationMethod relaxationMethod_ = RelaxationMethod::Projected;
  Elasticity elasticity_;
  bool beyondLimits_ = false; ///< links may be, since the published method relaxed
  Resampling resampling_;
  std::optional<RigidClusters> clusters_;
  int sweep_ = 0;            ///< since the last wave, cut or carve
  Reach reach_ = Reach::Far; ///< of these sweeps
};

void Simulation::Impl::checkpoint(double share)
{
  if (this->progress_ && !this->progress_(share))
  {
    throw Aborted();
  }
}

/// The voxels where they are now.
Bricks& Simulation::Impl::voxels()
{
  if (this->reduction_)
  {
    this->reduction_->expand();
  }
  return this->voxels_;
}

/// Elements may be elsewhere from now on.
void Simulation::Impl::moved()
{
  if (this->reduction_)
  {
    this->reduction_->moved();
  }
}

std::vector<std::vector<std::size_t>> Simulation::Impl::grab(
  const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers)
{
  std::vector<std::vector<std::size_t>> grabbed = elementsAround(this->voxels(), probes, numbers);
  for (std::vector<std::size_t>& voxels : grabbed)
  {
    voxels = this->reduction_ ? this->reduction_->elementsOf(voxels) : voxels;
  }
  return grabbed;
}

void Simulation::Impl::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  if (!(elasticRecovery >= 0.0 && elasticRecovery <= 1.0))
  {
    throw InputError("The elastic recovery must be a number from 0 to 1.");
  }
  const float slack = static_cast<float>(1.0 - elasticRecovery);
  if (slack == this->elasticity_.slack && method == this->relaxationMethod_)
  {
    return;
  }
  this->elasticity_.slack = slack;
  this->relaxationMethod_ = method;
  if (method != RelaxationMethod::Paper)
  {
    this->paperRelaxation_.release();
  }
  this->sweep_ = 0;
}

void Simulation::Impl::reset()
{
  this->waves_.clear();
  this->handles_.clear();
  this->bricks_.clearDisplacements();
  this->moved();
  this->sweep_ = 0;
  this->beyondLimits_ = false;
}

void Simulation::Impl::mend()
{
  this->reset();
  if (this->reduction_)
  {
    this->reduction_->mend();
  }
  else
  {
    this->bricks_.mend();
  }
  this->clusters_.reset();
  this->coarseToFine_.forget();
}

std::size_t Simulation::Impl::cut(const Surface& surface)
{
  fixedPoints(surface, this->model_->grid(), "cut"); // refuses before anything moves
  this->propagate(0);                                // a wave that is under way knows the links it has passed
  const std::size_t removed = cutLinks(this->voxels(), surface);
  if (removed > 0)
  {
    if (this->reduction_)
    {
      this->reduction_->follow();
    }
    this->clusters_.reset();
    this->coarseToFine_.forget();
    this->sweep_ = 0;
  }
  return removed;
}

std::size_t Simulation::Impl::carve(const Surface& surface)
{
  const ClosedSurface closed(surface, this->model_->grid());
  this->propagate(0); // a wave that is under way knows the tissue it has passed
  const std::vector<std::size_t> removed = carveElements(this->voxels(), closed);
  if (!removed.empty())
  {
    this->handles_.forget(this->reduction_ ? this->reduction_->follow() : removed);
    this->clusters_.reset();
    this->coarseToFine_.forget();
    this->sweep_ = 0;
  }
  return removed.size();
}

void Simulation::Impl::setPropagation(PropagationMethod method, ConflictPolicy policy)
{
  this->propagate(0);
  this->waves_.configure(method, policy);
}

void Simulation::Impl::hold(const std::vector<Probe>& probes)
{
  this->waves_.add(this->handles_.take(probes));
}

PropagateResult Simulation::Impl::propagate(int iterations)
{
  if (iterations < 0)
  {
    throw InputError("The number of iterations of a propagation must not be negative.");
  }
  if (!this->waves_.underWay())
  {
    return PropagateResult();
  }
  this->sweep_ = 0;
  this->moved();
  return this->stoppable(
    [&]
    {
      // How many launches it takes is not known beforehand: the share approaches 1.
      int launches = 0;
      return this->waves_.run(iterations,
        [&]
        {
          ++launches;
          this->checkpoint(launches / (launches + 50.0));
        });
    });
}

std::vector<ProbeResult> Simulation::Impl::probes()
{
  std::vector<ProbeResult> results = this->handles_.reached();
  this->addForces(results);
  return results;
}

HeldBy Simulation::Impl::heldBy(std::size_t probe)
{
  const std::vector<Handles::Pointer>& handles = this->handles_.all();
  if (probe >= handles.size())
  {
    throw InputError("There is no probe " + std::to_string(probe) + " to ask about.");
  }
  HeldBy heldBy;
  const Handle& handle = *handles[probe];
  if (handle.probe.anchor || handle.voxels.empty() || this->waves_.underWay())
  {
    return heldBy;
  }
  const Vector3 reached = this->handles_.reached()[probe].reached;
  Vector3 lack;
  for (int a = 0; a < 3; ++a)
  {
    lack[a] = handle.probe.displacement[a] - reached[a];
  }
  const auto most =
    std::max_element(lack.begin(), lack.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
  const int axis = static_cast<int>(most - lack.begin());
  if (std::fabs(*most) <= 1e-5 * (std::fabs(handle.probe.displacement[axis]) + this->model_->grid().spacing[axis]))
  {
    return heldBy; // rounding
  }
  const std::optional<Grip> grip = findGrip(this->bricks_, handles, handle, axis, *most > 0.0 ? 1.0 : -1.0);
  if (!grip)
  {
    return heldBy;
  }
  heldBy.bone = grip->rigidly;
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    if (std::binary_search(handles[n]->voxels.begin(), handles[n]->voxels.end(), grip->voxel))
    {
      heldBy.what = HeldBy::What::Probe;
      heldBy.probe = n;
      return heldBy;
    }
  }
  heldBy.what = HeldBy::What::Rigid;
  for (const std::size_t voxel :
    this->reduction_ ? this->reduction_->voxelsOf(grip->voxel) : std::vector<std::size_t>{ grip->voxel })
  {
    const Index3 at = this->model_->grid().indexOf(voxel);
    const int face = this->model_->anchoringFace(at[0], at[1], at[2]);
    if (face >= 0)
    {
      heldBy.what = HeldBy::What::Face;
      heldBy.face = face;
      return heldBy;
    }
  }
  return heldBy;
}

/// Gradients of the energy where the voxels of a handle, with the bone they are part of, move together.
void Simulation::Impl::addForces(std::vector<ProbeResult>& results)
{
  constexpr std::size_t linksPerTransfer = std::size_t(1) << 20;
  const Grid& grid = this->bricks_.model().grid();
  const int axes = this->model_->axes();
  const double linksPerLink = this->reduction_ ? this->reduction_->linksPerLink() : 1.0;
  for (int component = 0; component < axes; ++component)
  {
    const auto constraintOf = [&](const Index3& at)
    {
      float c[3];
      this->bricks_.row(at[0], at[1], at[2], 1, c);
      return std::fabs(c[component]);
    };
    // The links that lead out of handles.
    std::vector<std::size_t> handles;
    std::vector<std::uint32_t> inner;
    std::vector<std::uint32_t> outer;
    std::vector<float> limits;
    const auto addLinks = [&]
    {
      const std::vector<float> ui = this->bricks_.displacements(inner);
      const std::vector<float> uj = this->bricks_.displacements(outer);
      for (std::size_t m = 0; m < limits.size(); ++m)
      {
        for (int a = 0; a < 3; ++a)
        {
          if (axes == 1 || a == component)
          {
            // d/du of weight * pull^2 in physical units; spacings cancel.
            const double pull = this->elasticity_.pull(ui[3 * m + a], uj[3 * m + a], limits[m]);
            results[handles[m]].force[a] -= 2.0 * linksPerLink * Elasticity::weight(limits[m]) * pull;
          }
        }
      }
      handles.clear();
      inner.clear();
      outer.clear();
      limits.clear();
    };
    std::unordered_map<int, std::size_t> onlyThisBone; // the first handle that holds no other tissue
    std::vector<std::pair<std::size_t, std::size_t>> alike;
    for (std::size_t handle = 0; handle < results.size(); ++handle)
    {
      const std::vector<std::size_t>& held = this->handles_.all()[handle]->voxels;
      const int bone = held.empty() ? -1 : this->rigidClusters().clusterOf(held.front(), component);
      if (bone >= 0 && std::all_of(held.begin(), held.end(),
                         [&](std::size_t voxel) { return this->clusters_->clusterOf(voxel, component) == bone; }))
      {
        const auto [first, isFirst] = onlyThisBone.emplace(bone, handle);
        if (!isFirst)
        {
          alike.emplace_back(first->second, handle);
          continue;
        }
      }
      const std::vector<std::size_t> voxels = this->rigidClusters().withClusters(held, component);
      for (const std::size_t voxel : voxels)
      {
        const Index3 at = grid.indexOf(voxel);
        this->bricks_.forNeighbours(at,
          [&](int, const Index3& next)
          {
            if (std::binary_search(voxels.begin(), voxels.end(), grid.at(next[0], next[1], next[2])))
            {
              return;
            }
            const float limit = rule::linkLimit(constraintOf(at), constraintOf(next));
            if (!std::isinf(limit))
            {
              // An element without memory has not moved; slot 0 says so.
              handles.push_back(handle);
              inner.push_back(this->bricks_.address(at[0], at[1], at[2]));
              outer.push_back(this->bricks_.address(next[0], next[1], next[2]));
              limits.push_back(limit);
            }
          });
      }
      if (limits.size() > linksPerTransfer)
      {
        addLinks();
      }
    }
    addLinks();
    for (const auto& [first, same] : alike)
    {
      for (int a = 0; a < 3; ++a)
      {
        results[same].force[a] = axes == 1 || a == component ? results[first].force[a] : results[same].force[a];
      }
    }
  }
}

RigidClusters& Simulation::Impl::rigidClusters()
{
  if (!this->clusters_)
  {
    this->clusters_.emplace(this->bricks_);
  }
  return *this->clusters_;
}

RelaxResult Simulation::Impl::relax(int iterations, double tolerance)
{
  if (iterations < 0 || !(tolerance >= 0.0))
  {
    throw InputError("The number of iterations and the tolerance of a relaxation must not be negative.");
  }
  return this->stoppable(
    [&]
    {
      if (iterations == 0)
      {
        return RelaxResult();
      }
      this->moved();
      const WavesUnderWay* waves = nullptr;
      if (this->waves_.underWay())
      {
        waves = this->waves_.relaxable();
        if (!waves)
        {
          return RelaxResult();
        }
        this->waves_.relaxed();
      }
      const auto checkpoint = [&](int done) { this->checkpoint(static_cast<double>(done) / iterations); };
      if (this->relaxationMethod_ == RelaxationMethod::Paper)
      {
        this->beyondLimits_ = true;
        return this->paperRelaxation_.run(this->elasticity_, waves, iterations, tolerance, checkpoint);
      }
      if (this->beyondLimits_ && !waves)
      {
        this->waves_.makeFeasible([&] { this->checkpoint(0.0); });
        this->beyondLimits_ = false;
      }
      bool coarse = false;
      if (this->sweep_ == 0)
      {
        coarse =
          this->startsCoarse_ && !waves &&
          this->coarseToFine_.run(this->rigidClusters(), this->elasticity_, tolerance, [&] { this->checkpoint(0.0); });
        this->reach_ = coarse ? Reach::Near : Reach::Far;
      }
      RelaxResult result;
      const auto sweep = [&](int most)
      {
        const RelaxResult before = result;
        this->rigidClusters().begin(this->handles_.voxels());
        result = this->relaxation_.run(*this->clusters_, this->elasticity_, waves, this->reach_, this->sweep_, most,
          tolerance, [&](int done) { checkpoint(before.iterations + done); });
        this->sweep_ += result.iterations;
        result.iterations += before.iterations;
        result.coarseStep = before.coarseStep;
      };
      if (coarse)
      {
        sweep(std::min(iterations, CoarseToFine::sweepsToJudge));
        result.coarseStep = this->coarseToFine_.judge(this->elasticity_);
        this->reach_ = result.coarseStep > 0.0 ? Reach::Near : Reach::Far;
        result.converged = result.converged && result.coarseStep == 1.0;
      }
      if (result.iterations < iterations && !result.converged)
      {
        sweep(iterations - result.iterations);
      }
      result.converged = result.converged && !waves;
      return result;
    });
}

Statistics Simulation::Impl::measure()
{
  Statistics statistics;
  for (const BrickFigures& figures : measureBricks(this->bricks_, this->elasticity_))
  {
    for (int a = 0; a < 3; ++a)
    {
      statistics.energy += figures.energy[a] * this->bricks_.model().grid().spacing[a];
    }
    statistics.maxLinkExcess = std::max(statistics.maxLinkExcess, static_cast<double>(figures.excess));
    statistics.displaced += static_cast<std::size_t>(figures.displaced);
  }
  statistics.allocated = static_cast<std::size_t>(this->bricks_.slots() - 1) * this->bricks_.elementsPerBrick();
  statistics.deviceBytes = this->bricks_.deviceBytes();
  if (this->reduction_)
  {
    statistics.energy *= this->reduction_->linksPerLink();
    statistics.allocated += static_cast<std::size_t>(this->voxels_.slots() - 1) * this->voxels_.elementsPerBrick();
    statistics.deviceBytes += this->voxels_.deviceBytes();
  }
  return statistics;
}

void Simulation::Impl::displacements(float* out, bool zeroed)
{
  const Grid& grid = this->model_->grid();
  Bricks& bricks = this->voxels();
  if (!zeroed)
  {
    std::fill(out, out + 3 * grid.voxels(), 0.0f);
  }
  bricks.readSlots<float>({ { bricks.displacement, 3 } }, bricks.touchedSlots(),
    [&](int slot, const Bricks::SlotValues<float>& u)
    {
      for (const Bricks::Row& row : bricks.rows(bricks.brick(slot)))
      {
        for (int i = 0; i < row.count; ++i)
        {
          for (std::size_t a = 0; a < 3; ++a)
          {
            out[3 * (row.voxel + i) + a] = static_cast<float>(u(a, row.local(i)) * grid.spacing[a]);
          }
        }
      }
    });
}

void Simulation::Impl::propagationTimes(float* out)
{
  if (!this->reduction_)
  {
    this->waves_.arrivals().readTimes(out);
    return;
  }
  std::vector<float> times(this->bricks_.model().grid().voxels() * this->model_->axes());
  this->waves_.arrivals().readTimes(times.data());
  for (float& time : times)
  {
    time *= time < 0.0f ? 1.0f : static_cast<float>(this->reduction_->voxelsPerElement());
  }
  this->reduction_->spread(times, -1.0f, out);
}

void Simulation::Impl::wavefronts(int* out, bool zeroed)
{
  if (!this->reduction_)
  {
    this->waves_.arrivals().readFronts(out, zeroed);
    return;
  }
  std::vector<int> fronts(this->bricks_.model().grid().voxels() * this->model_->axes());
  this->waves_.arrivals().readFronts(fronts.data(), true);
  this->reduction_->spread(fronts, 0, out);
}

void Simulation::Impl::clusters(int* out)
{
  const int axes = this->model_->axes();
  std::vector<int> labels;
  for (int a = 0; a < axes; ++a)
  {
    RigidClusters::label(this->voxels_, a, labels);
    for (std::size_t n = 0; n < labels.size(); ++n)
    {
      out[n * axes + a] = labels[n];
    }
  }
}

void Simulation::Impl::elements(std::uint8_t* out)
{
  const Grid& grid = this->model_->grid();
  const std::size_t axes = static_cast<std::size_t>(this->model_->axes());
  std::vector<float> row(grid.size[0] * axes);
  for (int k = 0; k < grid.size[2]; ++k)
  {
    for (int j = 0; j < grid.size[1]; ++j)
    {
      this->voxels_.row(0, j, k, grid.size[0], row.data());
      for (int i = 0; i < grid.size[0]; ++i)
      {
        out[grid.at(i, j, k)] = std::isinf(row[i * axes]) ? 0 : 1;
      }
    }
  }
}

void Simulation::Impl::links(std::uint8_t* out)
{
  const Grid& grid = this->model_->grid();
  const int axes = this->model_->axes();
  std::vector<float> row(static_cast<std::size_t>(grid.size[0]) * axes);
  for (int k = 0; k < grid.size[2]; ++k)
  {
    for (int j = 0; j < grid.size[1]; ++j)
    {
      this->voxels_.row(0, j, k, grid.size[0], row.data());
      for (int i = 0; i < grid.size[0]; ++i)
      {
        out[grid.at(i, j, k)] = std::isinf(row[static_cast<std::size_t>(i) * axes]) ? 0 : 64;
      }
    }
  }
  for (int k = 0; k < grid.size[2]; ++k)
  {
    for (int j = 0; j < grid.size[1]; ++j)
    {
      for (int i = 0; i < grid.size[0]; ++i)
      {
        std::uint8_t& bits = out[grid.at(i, j, k)];
        const std::uint8_t cut = bits == 0 ? 0 : this->voxels_.cutBits(i, j, k);
        for (int a = 0; bits != 0 && a < 3; ++a)
        {
          const Index3 next{ i + (a == 0), j + (a == 1), k + (a == 2) };
          if (next[a] < grid.size[a] && out[grid.at(next[0], next[1], next[2])] != 0 && (cut & (2 << (2 * a))) == 0)
          {
            bits = static_cast<std::uint8_t>(bits | (2 << (2 * a)));
            out[grid.at(next[0], next[1], next[2])] |= static_cast<std::uint8_t>(1 << (2 * a));
          }
        }
      }
    }
  }
  for (std::size_t n = 0; n < grid.voxels(); ++n)
  {
    out[n] &= 63;
  }
}

void Simulation::Impl::resample(const Index3& padding, const std::function<void(const ResampledBox&)>& visit)
{
  for (const int p : padding)
  {
    if (p < 0)
    {
      throw InputError("The padding of the output must not be negative.");
    }
  }
  this->voxels();
  this->resampling_.run(
    padding, [this](double share) { this->checkpoint(share); }, visit);
}

Simulation::Simulation(std::shared_ptr<const Model> model, const Settings& settings)
{
  this->impl_ = translated([&] { return std::make_unique<Impl>(std::move(model), settings); });
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Model& Simulation::model() const
{
  return *this->impl_->model_;
}

const std::string& Simulation::deviceName() const
{
  return this->impl_->context_->info().name;
}

Index3 Simulation::brickSize() const
{
  return this->impl_->bricks_.size();
}

std::size_t Simulation::takePeakDeviceBytes()
{
  return this->impl_->context_->takePeakBytes();
}

void Simulation::setProgress(Progress progress)
{
  this->impl_->progress_ = std::move(progress);
}

void Simulation::setPropagation(PropagationMethod method, ConflictPolicy policy)
{
  translated([&] { this->impl_->setPropagation(method, policy); });
}

void Simulation::setPropagationTimes(bool wanted)
{
  this->impl_->waves_.keepTimes(wanted);
}

void Simulation::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  translated([&] { this->impl_->setRelaxation(method, elasticRecovery); });
}

void Simulation::setCoarseToFine(bool wanted)
{
  this->impl_->startsCoarse_ = wanted;
}

void Simulation::reset()
{
  translated([&] { this->impl_->reset(); });
}

void Simulation::mend()
{
  translated([&] { this->impl_->mend(); });
}

std::size_t Simulation::cut(const Surface& surface)
{
  return translated([&] { return this->impl_->cut(surface); });
}

std::size_t Simulation::carve(const Surface& surface)
{
  return translated([&] { return this->impl_->carve(surface); });
}

void Simulation::hold(const std::vector<Probe>& probes)
{
  translated([&] { this->impl_->hold(probes); });
}

PropagateResult Simulation::propagate(int iterations)
{
  return translated([&] { return this->impl_->propagate(iterations); });
}

std::vector<ProbeResult> Simulation::pull(const std::vector<Probe>& probes)
{
  return translated(
    [&]
    {
      this->impl_->hold(probes);
      this->impl_->propagate(0);
      return this->impl_->handles_.reached();
    });
}

RelaxResult Simulation::relax(int iterations, double tolerance)
{
  return translated([&] { return this->impl_->relax(iterations, tolerance); });
}

std::vector<ProbeResult> Simulation::probes() const
{
  return translated([&] { return this->impl_->probes(); });
}

HeldBy Simulation::heldBy(std::size_t probe) const
{
  return translated([&] { return this->impl_->heldBy(probe); });
}

Statistics Simulation::measure() const
{
  return translated([&] { return this->impl_->measure(); });
}

void Simulation::displacements(float* out, bool zeroed) const
{
  translated([&] { this->impl_->displacements(out, zeroed); });
}

void Simulation::propagationTimes(float* out) const
{
  translated([&] { this->impl_->propagationTimes(out); });
}

void Simulation::wavefronts(int* out, bool zeroed) const
{
  translated([&] { this->impl_->wavefronts(out, zeroed); });
}

void Simulation::clusters(int* out) const
{
  this->impl_->clusters(out);
}

void Simulation::elements(std::uint8_t* out) const
{
  this->impl_->elements(out);
}

void Simulation::links(std::uint8_t* out) const
{
  this->impl_->links(out);
}

void Simulation::resample(const Index3& padding, const std::function<void(const ResampledBox&)>& visit) const
{
  translated([&] { this->impl_->resample(padding, visit); });
}

}
