#include "Simulation.h"

#include "Carving.h"
#include "Continuation.h"
#include "Cutting.h"
#include "Error.h"
#include "Measurement.h"
#include "MultiscaleRelaxation.h"
#include "PaperRelaxation.h"
#include "ProbeSelection.h"
#include "Process.h"
#include "Readout.h"
#include "Resampling.h"
#include "Waves.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <unordered_set>

namespace chainmail
{

namespace
{

RotationSettings rotatingOf(const Settings& settings)
{
  const double ratio = settings.poissonRatio;
  if (!(ratio >= 0.0 && ratio <= 0.49) || (ratio != 0.0 && !settings.rotations))
  {
    throw InputError("Poisson's ratio must be a number from 0 to 0.49, and 0 without rotations.");
  }
  return { settings.rotations, settings.poissonRatio };
}

/// Between two waves, tissue that moves less than this in a sweep can wait for the sweeps after the last wave
/// [fractions of the spacing].
constexpr double still = 0.005;

std::uint64_t nextNumber()
{
  static std::atomic<std::uint64_t> last{ 0 };
  return ++last;
}

}

class Simulation::Impl
{
public:
  Impl(std::shared_ptr<const Model> model, const Settings& settings)
    : model_(std::move(model))
    , context_(Context::of(settings.device))
    , voxels_(this->context_, this->model_, settings.brickSize,
        settings.modelReduction == 1 ? rotatingOf(settings) : RotationSettings())
    , reduction_(settings.modelReduction == 1
                   ? nullptr
                   : new ModelReduction(this->voxels_, settings.modelReduction, rotatingOf(settings)))
    , bricks_(this->reduction_ ? this->reduction_->bricks() : this->voxels_)
    , readout_(this->voxels_, this->bricks_, this->reduction_.get())
    , handles_(this->bricks_, this->reduction_ ? this->reduction_->origin() : Vector3(),
        [this](const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers)
        { return this->grab(probes, numbers); })
    , waves_(this->bricks_, this->handles_,
        [this](const std::vector<Handles::Pointer>& handles) { return this->sharedBodies(handles); })
    , relaxation_(this->bricks_, this->handles_)
    , resampling_(this->voxels_, this->reduction_.get())
    , paperRelaxation_(this->bricks_)
  {
  }

  void setPropagation(PropagationMethod method, ConflictPolicy policy);
  void setRelaxation(RelaxationMethod method, double elasticRecovery);
  void reset();
  void restoreTopology();
  std::size_t cut(const Surface& surface);
  std::size_t carve(const Surface& surface, SurfaceParts* parts);
  void hold(const std::vector<Probe>& probes);
  PropagateResult propagate(int iterations);
  RelaxResult relax(int iterations, double tolerance, double error);
  UpdateResult update(const Update& update, const std::function<bool(UpdatePart)>& begins);
  std::vector<ProbeResult> probes();
  Limiter limiter(std::size_t probe);
  RigidClusters& rigidClusters();
  Statistics measure();
  double energy();
  Resampled resample(
    const Index3& padding, const BoxVisitor& visit, std::uint64_t since, CutSurfaces cuts, const OutputDetail& detail);
  void exportTissue(const Index3& padding, CutSurfaces cuts, const std::vector<TissueReceiver>& receivers,
    const std::function<void(std::size_t, const std::vector<char>&)>& take);
  Bricks& voxels();

  /// Runs a public call.
  template <typename Body> auto called(Body&& body) -> decltype(body())
  {
    requireOwnOpenCL();
    const WhileCompiling report([this] { this->compiling_&& this->compiling_(); });
    return translated(std::forward<Body>(body));
  }

  std::shared_ptr<const Model> model_;
  std::shared_ptr<Context> context_;
  Progress progress_;
  std::function<bool()> compiling_;
  Bricks voxels_;                             ///< an element for every voxel
  std::unique_ptr<ModelReduction> reduction_; ///< null where the model is not reduced
  Bricks& bricks_;                            ///< the elements that deform: the voxels, or those of the reduction
  Readout readout_;
  Handles handles_;
  Waves waves_;
  MultiscaleRelaxation relaxation_;
  Resampling resampling_;

private:
  void checkOutput(const Index3& padding, const OutputDetail& detail) const;
  void checkpoint(double share);
  void reportCompiling(bool mayStop);
  void moved();
  std::vector<Handles::Grabbed> grab(const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers);
  void softChanged();
  std::vector<std::size_t> withFreeNotches(std::vector<std::size_t> body);
  std::vector<Handles::SharedBody> sharedBodies(const std::vector<Handles::Pointer>& handles);
  template <typename F> void settleAround(const F& sweep, bool thoroughly);
  Relaxer& relaxer();
  void tissueChanged();

  /// Runs a public call that a progress callback may stop, which puts tissue at rest.
  template <typename Body> auto stoppable(Body&& body) -> decltype(body())
  {
    try
    {
      const WhileCompiling report([this] { this->reportCompiling(true); });
      return body();
    }
    catch (const Aborted&)
    {
      this->reset();
      throw;
    }
  }

  PaperRelaxation paperRelaxation_;
  RelaxationMethod relaxationMethod_ = RelaxationMethod::Projected;
  Elasticity elasticity_;
  bool beyondLimits_ = false; ///< whether links may exceed their limits, because the published method has relaxed
  std::optional<RigidClusters> clusters_;
  const std::uint64_t number_ = nextNumber(); ///< of this simulation, unique in this process
};

void Simulation::Impl::checkpoint(double share)
{
  if (this->progress_ && !this->progress_(share))
  {
    throw Aborted();
  }
}

void Simulation::Impl::reportCompiling(bool mayStop)
{
  if (this->compiling_ && !this->compiling_() && mayStop)
  {
    throw Aborted();
  }
}

/// The voxels, at their current places.
Bricks& Simulation::Impl::voxels()
{
  if (this->reduction_)
  {
    this->reduction_->expand();
  }
  return this->voxels_;
}

/// To be called when elements may have moved.
void Simulation::Impl::moved()
{
  if (this->reduction_)
  {
    this->reduction_->moved();
  }
}

std::vector<Handles::Grabbed> Simulation::Impl::grab(
  const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers)
{
  std::vector<Handles::Grabbed> grabbed;
  for (std::vector<std::size_t>& voxels : elementsAround(this->voxels(), probes, numbers))
  {
    Handles::Grabbed one;
    one.elements = this->reduction_ ? this->reduction_->elementsOf(voxels) : std::move(voxels);
    if (this->reduction_)
    {
      one.share = static_cast<double>(voxels.size()) /
                  (static_cast<double>(one.elements.size()) * this->reduction_->linksPerLink());
    }
    if (probes[grabbed.size()].rotates)
    {
      one.elements = this->rigidClusters().withClusters(one.elements, 0);
      if (!probes[grabbed.size()].isSoft())
      {
        one.elements = withNotches(this->bricks_, std::move(one.elements));
      }
    }
    grabbed.push_back(std::move(one));
  }
  return grabbed;
}

/// To be called when the pull of soft probes has changed.
void Simulation::Impl::softChanged()
{
  this->bricks_.setSoftLinks(this->handles_.softLinks());
  this->relaxer().restart(true);
}

/// A body, and the stiff tissue in its notches that no probe holds.
std::vector<std::size_t> Simulation::Impl::withFreeNotches(std::vector<std::size_t> body)
{
  std::unordered_set<std::size_t> held;
  for (const Handles::Pointer& handle : this->handles_.all())
  {
    if (!handle->isSoft())
    {
      held.insert(handle->voxels.begin(), handle->voxels.end());
    }
  }
  for (const std::size_t voxel : body)
  {
    held.erase(voxel);
  }
  body = withNotches(this->bricks_, std::move(body));
  body.erase(
    std::remove_if(body.begin(), body.end(), [&](std::size_t voxel) { return held.count(voxel) > 0; }), body.end());
  return body;
}

/// The free bodies that at least two of these handles hold, and nothing else.
std::vector<Handles::SharedBody> Simulation::Impl::sharedBodies(const std::vector<Handles::Pointer>& handles)
{
  RigidClusters& clusters = this->rigidClusters();
  constexpr int none = -1;
  constexpr int several = -2;
  const auto bodyOf = [&clusters](const Handle& handle)
  {
    int body = none;
    for (const std::size_t voxel : handle.voxels)
    {
      const int own = clusters.clusterOf(voxel, 0);
      body = own < 0 || own == body ? body : body == none ? own : several;
    }
    return body;
  };
  std::map<int, Handles::SharedBody> bodies;
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    const int body = handles[n]->rotates() ? none : bodyOf(*handles[n]);
    if (body >= 0 && !clusters.isAnchored(body))
    {
      Handles::SharedBody& shared = bodies[body];
      shared.handles.push_back(n);
      shared.voxels.insert(shared.voxels.end(), handles[n]->voxels.begin(), handles[n]->voxels.end());
    }
  }
  std::vector<Handles::SharedBody> found;
  for (auto& [body, shared] : bodies)
  {
    const bool isOthers =
      shared.handles.size() < 2 || std::any_of(this->handles_.all().begin(), this->handles_.all().end(),
                                     [&, id = body](const Handles::Pointer& other)
                                     {
                                       return !other->isSoft() &&
                                              std::find(handles.begin(), handles.end(), other) == handles.end() &&
                                              std::any_of(other->voxels.begin(), other->voxels.end(),
                                                [&](std::size_t voxel) { return clusters.clusterOf(voxel, 0) == id; });
                                     });
    if (!isOthers)
    {
      std::sort(shared.voxels.begin(), shared.voxels.end());
      shared.voxels = this->withFreeNotches(clusters.withClusters(shared.voxels, 0));
      found.push_back(std::move(shared));
    }
  }
  return found;
}

void Simulation::Impl::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  if (!(elasticRecovery >= 0.0 && elasticRecovery <= 1.0))
  {
    throw InputError("The elastic recovery must be a number from 0 to 1.");
  }
  if (this->bricks_.rotations() && method != RelaxationMethod::Projected)
  {
    throw InputError("Rotations need the relaxation method Projected.");
  }
  if (this->bricks_.rotations() && elasticRecovery != 1.0)
  {
    throw InputError("Rotations need elastic tissue: an elastic recovery of 1.");
  }
  const float slack = static_cast<float>(1.0 - elasticRecovery);
  if (slack == this->elasticity_.slack && method == this->relaxationMethod_)
  {
    return;
  }
  this->elasticity_.slack = slack;
  if (method != this->relaxationMethod_)
  {
    this->relaxer().release();
    this->relaxationMethod_ = method;
  }
  this->relaxer().restart(true);
}

void Simulation::Impl::reset()
{
  this->waves_.clear();
  this->handles_.clear();
  this->bricks_.setSoftLinks({});
  this->bricks_.clearDisplacements();
  this->moved();
  this->relaxer().restart(true);
  this->beyondLimits_ = false;
}

void Simulation::Impl::restoreTopology()
{
  this->reset();
  if (this->reduction_)
  {
    this->reduction_->restoreTopology();
  }
  else
  {
    this->bricks_.restoreTopology();
  }
  this->tissueChanged();
}

std::size_t Simulation::Impl::cut(const Surface& surface)
{
  fixedPoints(surface, this->model_->grid(), "cut"); // refuses a bad surface before anything moves
  this->propagate(0);                                // a wave under way relies on the links that it has passed
  const std::size_t removed = cutLinks(this->voxels(), surface);
  if (removed > 0)
  {
    if (this->reduction_)
    {
      this->reduction_->applyTopology();
    }
    this->tissueChanged();
  }
  return removed;
}

std::size_t Simulation::Impl::carve(const Surface& surface, SurfaceParts* parts)
{
  const ClosedSurface closed(surface, this->model_->grid());
  if (parts)
  {
    *parts = closed.found;
  }
  this->propagate(0); // a wave under way relies on the tissue that it has passed
  const std::vector<std::size_t> removed = carveElements(this->voxels(), closed);
  if (!removed.empty())
  {
    this->handles_.forget(this->reduction_ ? this->reduction_->applyTopology() : removed);
    this->softChanged();
    this->tissueChanged();
  }
  return removed.size();
}

void Simulation::Impl::setPropagation(PropagationMethod method, ConflictPolicy policy)
{
  if (this->bricks_.rotations() && method != PropagationMethod::Envelope)
  {
    throw InputError("Rotations need the propagation method Envelope.");
  }
  if (policy == ConflictPolicy::Share && method != PropagationMethod::Envelope)
  {
    throw InputError("The conflict policy Share needs the propagation method Envelope.");
  }
  this->propagate(0);
  this->waves_.configure(method, policy);
}

void Simulation::Impl::hold(const std::vector<Probe>& probes)
{
  const Handles::Change change = this->handles_.take(probes);
  this->waves_.add(change);
  if (!change.released.empty())
  {
    this->relaxer().restart(true); // what these held goes back now
  }
  if (change.soft)
  {
    this->softChanged();
  }
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
  this->relaxer().restart(true);
  this->moved();
  return this->stoppable(
    [&]
    {
      // The number of launches is not known beforehand, so the share approaches 1.
      int launches = 0;
      const Checkpoint checkpoint = [&]
      {
        ++launches;
        this->checkpoint(launches / (launches + 50.0));
      };
      PropagateResult result = this->waves_.run(iterations, checkpoint);
      if (iterations == 0 && this->bricks_.rotations())
      {
        // Once coarser grids lower the energy little, sweeps of the finest one rotate bones as far in less time.
        bool coarse = true;
        double tolerance = 0.0; // not all pulls have another wave, so the first settling is thorough
        const auto sweep = [&](int sweeps, double tolerance)
        {
          const RelaxationTask task{ [this]() -> RigidClusters& { return this->rigidClusters(); }, this->elasticity_,
            nullptr, sweeps, tolerance, 0.0, [&](int) { checkpoint(); } };
          return this->relaxer().run(task);
        };
        const auto settle = [&](bool anyRotates, bool thoroughly)
        {
          if (anyRotates)
          {
            this->settleAround(sweep, thoroughly);
            return;
          }
          // These sweeps rotate bones about as far as a wave moves them. Fewer are needed where coarser grids have
          // rotated bones before.
          constexpr int few = 4;
          constexpr double leastDrop = 0.3;
          this->relaxer().restart(coarse);
          const RelaxResult start = sweep(few, tolerance);
          if (!(start.coarseStep > 0.0))
          {
            sweep(few, tolerance);
          }
          coarse = start.coarseStep > 0.0 && start.coarseDrop >= leastDrop;
          tolerance = still;
        };
        const Continued further = continueWaves(this->waves_, this->handles_, settle, checkpoint);
        result.iterations += further.iterations;
        if (further.travelled)
        {
          this->relaxer().restart(false); // a last wave leaves little for coarser grids
        }                                 // else the sweeps that follow continue those of settling
      }
      return result;
    });
}

/// Relaxes the tissue around rotating probes by `sweep(sweeps, tolerance)`, until further sweeps lower the energy
/// little. The energy falls near the probes, so coarser grids help little. After a wave that gained nothing
/// (`thoroughly`), coarser grids take part and no tissue waits.
template <typename F> void Simulation::Impl::settleAround(const F& sweep, bool thoroughly)
{
  constexpr int first = 8;
  constexpr int more = 16;
  constexpr int mostRounds = 8;
  constexpr double little = 0.1;
  const double tolerance = thoroughly ? 0.0 : still;
  this->relaxer().restart(thoroughly);
  sweep(first, tolerance);
  double energy = this->energy();
  for (int round = 0; round < mostRounds; ++round)
  {
    const double before = energy;
    sweep(more, tolerance);
    energy = this->energy();
    if (energy >= (1.0 - little) * before)
    {
      break;
    }
  }
}

std::vector<ProbeResult> Simulation::Impl::probes()
{
  std::vector<ProbeResult> results = this->handles_.reached();
  if (!results.empty())
  {
    this->readout_.addForces(results, this->handles_, this->rigidClusters(), this->elasticity_);
  }
  return results;
}

Limiter Simulation::Impl::limiter(std::size_t probe)
{
  if (probe >= this->handles_.all().size())
  {
    throw InputError("There is no probe " + std::to_string(probe) + " in the last update.");
  }
  return this->waves_.underWay()
           ? Limiter()
           : findLimiter(this->bricks_, *this->model_, this->reduction_.get(), this->handles_, probe);
}

RigidClusters& Simulation::Impl::rigidClusters()
{
  if (!this->clusters_)
  {
    this->clusters_.emplace(this->bricks_);
  }
  return *this->clusters_;
}

/// The relaxation of the chosen method.
Relaxer& Simulation::Impl::relaxer()
{
  switch (this->relaxationMethod_)
  {
  case RelaxationMethod::Paper:
    return this->paperRelaxation_;
  case RelaxationMethod::Projected:
    break;
  }
  return this->relaxation_;
}

/// To be called when links or elements have been removed or restored.
void Simulation::Impl::tissueChanged()
{
  this->clusters_.reset();
  this->relaxation_.tissueChanged();
  this->paperRelaxation_.tissueChanged();
}

RelaxResult Simulation::Impl::relax(int iterations, double tolerance, double error)
{
  if (iterations < 0 || !(tolerance >= 0.0) || !(error >= 0.0))
  {
    throw InputError("The number of iterations, the tolerance and the error of a relaxation must be 0 or more.");
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
      Relaxer& relaxer = this->relaxer();
      if (!relaxer.keepsLimits())
      {
        this->beyondLimits_ = true;
      }
      else if (this->beyondLimits_ && !waves)
      {
        this->waves_.projectToFeasible([&] { this->checkpoint(0.0); });
        this->beyondLimits_ = false;
      }
      return relaxer.run({ [this]() -> RigidClusters& { return this->rigidClusters(); }, this->elasticity_, waves,
        iterations, tolerance, error, [&](int done) { this->checkpoint(static_cast<double>(done) / iterations); } });
    });
}

UpdateResult Simulation::Impl::update(const Update& update, const std::function<bool(UpdatePart)>& begins)
{
  const auto begin = [&](UpdatePart part)
  {
    this->stoppable(
      [&]
      {
        if (begins && !begins(part))
        {
          throw Aborted();
        }
      });
  };
  const Method& method = update.method;
  UpdateResult result;
  begin(UpdatePart::Propagate);
  if (update.fromRest)
  {
    this->reset();
  }
  if (!this->waves_.isConfigured(method.propagation, method.conflict))
  {
    this->setPropagation(method.propagation, method.conflict);
  }
  this->setRelaxation(method.relaxation, method.elasticRecovery);
  this->relaxation_.startCoarse(method.coarseToFine);
  this->waves_.keepTimes(update.propagationTimes);
  this->hold(update.probes);
  result.propagation = this->propagate(method.propagationIterations);
  begin(UpdatePart::Relax);
  result.relaxation = this->relax(method.relaxationIterations, method.relaxationTolerance, method.relaxationError);
  result.probes = this->probes();
  begin(UpdatePart::Measure);
  result.statistics = this->measure();
  return result;
}

double Simulation::Impl::energy()
{
  return energyOf(this->bricks_, measureBricks(this->bricks_, this->elasticity_));
}

Statistics Simulation::Impl::measure()
{
  Statistics statistics;
  const std::vector<BrickFigures> all = measureBricks(this->bricks_, this->elasticity_);
  statistics.energy = energyOf(this->bricks_, all);
  for (const BrickFigures& figures : all)
  {
    statistics.maxLinkExcess = std::max(statistics.maxLinkExcess, static_cast<double>(figures.excess));
    statistics.displaced += static_cast<std::size_t>(figures.displaced);
  }
  statistics.allocated = static_cast<std::size_t>(this->bricks_.states() - 1) * this->bricks_.elementsPerBrick();
  statistics.deviceBytes = this->bricks_.deviceBytes();
  if (const SoftLinks* soft = this->bricks_.softLinks())
  {
    statistics.energy += soft->least();
  }
  if (this->reduction_)
  {
    statistics.energy *= this->reduction_->linksPerLink();
    statistics.allocated += static_cast<std::size_t>(this->voxels_.states() - 1) * this->voxels_.elementsPerBrick();
    statistics.deviceBytes += this->voxels_.deviceBytes();
  }
  return statistics;
}

/// Throws InputError where an output cannot be made.
void Simulation::Impl::checkOutput(const Index3& padding, const OutputDetail& detail) const
{
  if (detail.finer < 1 || detail.finer > OutputDetail::most)
  {
    throw InputError("The output can be 1 to " + std::to_string(OutputDetail::most) +
                     " times as fine as the image, not " + std::to_string(detail.finer) + " times.");
  }
  for (int a = 0; a < 3; ++a)
  {
    if (padding[a] < 0)
    {
      throw InputError("The padding of the output must not be negative.");
    }
    const std::int64_t most = detail.finer * (std::int64_t(this->model_->grid().size[a]) + padding[a]);
    if (most > std::numeric_limits<int>::max())
    {
      throw InputError("The output has too many voxels along an axis. Lower OutputPadding or OutputMagnification.");
    }
  }
}

Resampled Simulation::Impl::resample(
  const Index3& padding, const BoxVisitor& visit, std::uint64_t since, CutSurfaces cuts, const OutputDetail& detail)
{
  this->checkOutput(padding, detail);
  const WhileCompiling report([this] { this->reportCompiling(true); });
  return this->resampling_.run(
    padding, since, cuts, detail, [this](double share) { this->checkpoint(share); }, visit);
}

void Simulation::Impl::exportTissue(const Index3& padding, CutSurfaces cuts,
  const std::vector<TissueReceiver>& receivers, const std::function<void(std::size_t, const std::vector<char>&)>& take)
{
  for (const TissueReceiver& receiver : receivers)
  {
    this->checkOutput(padding, receiver.detail);
  }
  const WhileCompiling report([this] { this->reportCompiling(true); });
  this->resampling_.exportTissue(padding, cuts, this->number_, receivers, take);
}

Simulation::Simulation(std::shared_ptr<const Model> model, const Settings& settings)
{
  this->impl_.reset(translated([&] { return new Impl(std::move(model), settings); }));
}

void Simulation::Release::operator()(Impl* impl) const
{
  if (!isForkedFromOpenCL()) // in a forked process it is left to the end of the process
  {
    delete impl;
  }
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

void Simulation::setCompiling(std::function<bool()> compiling)
{
  this->impl_->compiling_ = std::move(compiling);
}

void Simulation::setPropagation(PropagationMethod method, ConflictPolicy policy)
{
  this->impl_->called([&] { this->impl_->setPropagation(method, policy); });
}

void Simulation::setPropagationTimes(bool wanted)
{
  this->impl_->waves_.keepTimes(wanted);
}

void Simulation::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  this->impl_->called([&] { this->impl_->setRelaxation(method, elasticRecovery); });
}

void Simulation::setCoarseToFine(bool wanted)
{
  this->impl_->relaxation_.startCoarse(wanted);
}

void Simulation::reset()
{
  this->impl_->called([&] { this->impl_->reset(); });
}

void Simulation::restoreTopology()
{
  this->impl_->called([&] { this->impl_->restoreTopology(); });
}

std::size_t Simulation::cut(const Surface& surface)
{
  return this->impl_->called([&] { return this->impl_->cut(surface); });
}

std::size_t Simulation::carve(const Surface& surface, SurfaceParts* parts)
{
  return this->impl_->called([&] { return this->impl_->carve(surface, parts); });
}

void Simulation::hold(const std::vector<Probe>& probes)
{
  this->impl_->called([&] { this->impl_->hold(probes); });
}

PropagateResult Simulation::propagate(int iterations)
{
  return this->impl_->called([&] { return this->impl_->propagate(iterations); });
}

std::vector<ProbeResult> Simulation::pull(const std::vector<Probe>& probes)
{
  return this->impl_->called(
    [&]
    {
      this->impl_->hold(probes);
      this->impl_->propagate(0);
      return this->impl_->handles_.reached();
    });
}

RelaxResult Simulation::relax(int iterations, double tolerance, double error)
{
  return this->impl_->called([&] { return this->impl_->relax(iterations, tolerance, error); });
}

UpdateResult Simulation::update(const Update& update, const std::function<bool(UpdatePart)>& begins)
{
  return this->impl_->called([&] { return this->impl_->update(update, begins); });
}

std::vector<ProbeResult> Simulation::probes() const
{
  return this->impl_->called([&] { return this->impl_->probes(); });
}

Limiter Simulation::limiter(std::size_t probe) const
{
  return this->impl_->called([&] { return this->impl_->limiter(probe); });
}

std::vector<RigidBody> Simulation::bodies() const
{
  Impl& impl = *this->impl_;
  return impl.called([&] { return impl.readout_.bodies(impl.handles_, impl.rigidClusters()); });
}

Statistics Simulation::measure() const
{
  return this->impl_->called([&] { return this->impl_->measure(); });
}

void Simulation::displacements(const VoxelBox& box, float* out, bool zeroed) const
{
  this->impl_->called([&] { this->impl_->readout_.displacements(box, out, zeroed); });
}

void Simulation::propagationTimes(const VoxelBox& box, float* out) const
{
  this->impl_->called([&] { this->impl_->readout_.propagationTimes(this->impl_->waves_.arrivals(), box, out); });
}

void Simulation::wavefronts(const VoxelBox& box, int* out, bool zeroed) const
{
  this->impl_->called([&] { this->impl_->readout_.wavefronts(this->impl_->waves_.arrivals(), box, out, zeroed); });
}

void Simulation::clusters(const VoxelBox& box, int* out) const
{
  this->impl_->readout_.clusters(box, out);
}

void Simulation::elements(const VoxelBox& box, std::uint8_t* out) const
{
  this->impl_->readout_.elements(box, out);
}

void Simulation::links(const VoxelBox& box, std::uint8_t* out, bool ofPictures) const
{
  this->impl_->readout_.links(box, out, ofPictures);
}

Resampled Simulation::resample(const Index3& padding, const BoxVisitor& visit, std::uint64_t since, CutSurfaces cuts,
  const OutputDetail& detail) const
{
  return this->impl_->called([&] { return this->impl_->resample(padding, visit, since, cuts, detail); });
}

void Simulation::exportTissue(const Index3& padding, CutSurfaces cuts, const std::vector<TissueReceiver>& receivers,
  const std::function<void(std::size_t, const std::vector<char>&)>& take) const
{
  this->impl_->called([&] { this->impl_->exportTissue(padding, cuts, receivers, take); });
}

std::optional<std::vector<OutputDetail>> Simulation::portions(
  const Index3& padding, CutSurfaces cuts, const OutputDetail& part) const
{
  return this->impl_->called([&] { return this->impl_->resampling_.portions(padding, cuts, part); });
}

Sources Simulation::sources(const Index3& padding, CutSurfaces cuts, const OutputDetail& detail) const
{
  return this->impl_->called([&] { return this->impl_->resampling_.sources(padding, cuts, detail); });
}

}
