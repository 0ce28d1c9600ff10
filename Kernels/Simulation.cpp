#include "Simulation.h"

#include "Carving.h"
#include "Cutting.h"
#include "Error.h"
#include "Measurement.h"
#include "PaperRelaxation.h"
#include "Propagation.h"
#include "Relaxation.h"
#include "Resampling.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace chainmail
{

namespace
{

using Float3 = std::array<float, 3>;

std::string text(const Vector3& v)
{
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), "(%.6g, %.6g, %.6g)", v[0], v[1], v[2]);
  return buffer;
}

/// Elements that a probe holds.
struct Hold
{
  std::uint32_t place = 0; ///< address of the element whose displacement is the probe's
  std::vector<std::size_t> voxels;
  std::vector<std::uint32_t> addresses;
  std::vector<int> bricks;
};

/// Two holds that strain a link by less than this are compatible: float rounding of displacements of this size.
float tolerance(float displacement)
{
  return 2e-6f * std::max(1.0f, std::fabs(displacement));
}

}

class Simulation::Impl
{
public:
  Impl(std::shared_ptr<const Model> model, const Settings& settings)
    : model_(std::move(model))
    , context_(Context::of(settings.device))
    , bricks_(this->context_, this->model_, settings.brickSize)
    , propagation_(this->bricks_)
    , relaxation_(this->bricks_)
    , paperRelaxation_(this->bricks_)
    , resampling_(this->bricks_)
  {
  }

  void setRelaxation(RelaxationMethod method, double elasticRecovery);
  void reset();
  void mend();
  std::size_t cut(const Surface& surface);
  std::size_t carve(const Surface& surface);
  std::vector<ProbeResult> pull(const std::vector<Probe>& probes);
  RelaxResult relax(int iterations, double tolerance);
  std::vector<ProbeResult> probes();
  Statistics measure();
  void displacements(float* out);
  void clusters(int* out);
  void links(std::uint8_t* out);
  void resample(const Index3& padding, const std::function<void(const ResampledBox&)>& visit);

  std::shared_ptr<const Model> model_;
  std::shared_ptr<Context> context_;
  Progress progress_;
  Bricks bricks_;

private:
  std::vector<std::size_t> grab(const Probe& probe, std::size_t number) const;
  Hold holdOf(const std::vector<std::size_t>& voxels);
  void setHeld(const Hold& hold, bool held);
  void release();
  void letGo(const std::vector<std::size_t>& removed);
  Float3 toFraction(const Vector3& length) const;
  void move(const Hold& hold, const Float3& to);
  void place(const Hold& hold, const std::vector<float>& values);
  bool pullTogether(const std::vector<Probe>& probes);
  void pullInTurn(std::size_t number, const Probe& probe);
  void checkpoint(double share);
  std::vector<ProbeResult> reached();
  Vector3 forceAt(const std::vector<std::size_t>& held);
  RigidClusters& rigidClusters();
  Propagation::Conflict propagate(const std::vector<int>& bricks, double enough);

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

  Propagation propagation_;
  Relaxation relaxation_;
  PaperRelaxation paperRelaxation_;
  RelaxationMethod relaxationMethod_ = RelaxationMethod::Projected;
  Elasticity elasticity_;
  Resampling resampling_;
  std::optional<RigidClusters> clusters_;
  std::vector<Hold> holds_;
  int sweep_ = 0; ///< since the last pull
};

void Simulation::Impl::checkpoint(double share)
{
  if (this->progress_ && !this->progress_(share))
  {
    throw Aborted();
  }
}

void Simulation::Impl::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  if (!(elasticRecovery >= 0.0 && elasticRecovery <= 1.0))
  {
    throw InputError("The elastic recovery must be a number from 0 to 1.");
  }
  this->elasticity_.slack = static_cast<float>(1.0 - elasticRecovery);
  this->relaxationMethod_ = method;
  if (method != RelaxationMethod::Paper)
  {
    this->paperRelaxation_.release();
  }
  this->sweep_ = 0;
}

void Simulation::Impl::reset()
{
  this->release();
  this->bricks_.clearDisplacements();
  this->sweep_ = 0;
}

void Simulation::Impl::mend()
{
  this->reset();
  this->bricks_.mend();
  this->clusters_.reset();
}

std::size_t Simulation::Impl::cut(const Surface& surface)
{
  const std::size_t removed = cutLinks(this->bricks_, surface);
  if (removed > 0)
  {
    this->clusters_.reset();
    this->sweep_ = 0;
  }
  return removed;
}

std::size_t Simulation::Impl::carve(const Surface& surface)
{
  const std::vector<std::size_t> removed = carveElements(this->bricks_, { surface, this->model_->grid() });
  if (!removed.empty())
  {
    this->letGo(removed);
    this->clusters_.reset();
    this->sweep_ = 0;
  }
  return removed.size();
}

std::vector<std::size_t> Simulation::Impl::grab(const Probe& probe, std::size_t number) const
{
  const Grid& grid = this->model_->grid();
  const std::string name =
    "Probe " + std::to_string(number) + " at " + text(probe.position) + " mm along the image's axes";
  for (int a = 0; a < 3; ++a)
  {
    if (!std::isfinite(probe.position[a]))
    {
      throw ProbeError(number, name, "has a position that is not finite.");
    }
    if (!probe.anchor && !std::isfinite(probe.displacement[a]))
    {
      throw ProbeError(number, name, "has a displacement that is not finite.");
    }
  }
  if (!(probe.radius >= 0.0) || !std::isfinite(probe.radius))
  {
    throw ProbeError(number, name, "has a radius that is negative or not finite.");
  }

  // The nearest element is one within reach of the voxel's own corners.
  double reach2 = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    reach2 += 0.25 * grid.spacing[a] * grid.spacing[a];
  }
  reach2 *= 1.0 + 1e-9;
  const double radius2 = probe.radius * probe.radius * (1.0 + 1e-9);
  const double farthest = std::sqrt(std::max(reach2, radius2));
  Index3 first;
  Index3 last;
  for (int a = 0; a < 3; ++a)
  {
    const double low = std::ceil((probe.position[a] - farthest) / grid.spacing[a]);
    const double high = std::floor((probe.position[a] + farthest) / grid.spacing[a]);
    first[a] = static_cast<int>(std::min(std::max(low, 0.0), static_cast<double>(grid.size[a])));
    last[a] = static_cast<int>(std::max(std::min(high, grid.size[a] - 1.0), -1.0));
  }

  std::vector<std::size_t> within;
  std::size_t nearest = 0;
  double nearest2 = std::numeric_limits<double>::infinity();
  std::vector<float> row;
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1] && first[0] <= last[0]; ++j)
    {
      const int axes = this->model_->axes();
      row.resize(static_cast<std::size_t>(last[0] - first[0] + 1) * axes);
      this->bricks_.row(first[0], j, k, last[0] - first[0] + 1, row.data());
      for (int i = first[0]; i <= last[0]; ++i)
      {
        if (std::isinf(row[static_cast<std::size_t>(i - first[0]) * axes]))
        {
          continue;
        }
        const double x = i * grid.spacing[0] - probe.position[0];
        const double y = j * grid.spacing[1] - probe.position[1];
        const double z = k * grid.spacing[2] - probe.position[2];
        const double distance2 = x * x + y * y + z * z;
        if (probe.radius > 0.0 && distance2 <= radius2)
        {
          within.push_back(grid.at(i, j, k));
        }
        if (distance2 < nearest2)
        {
          nearest2 = distance2;
          nearest = grid.at(i, j, k);
        }
      }
    }
  }
  if (!within.empty())
  {
    return within;
  }
  if (nearest2 > reach2)
  {
    throw ProbeError(number, name,
      "holds no tissue: there is none within its radius of " + std::to_string(probe.radius) +
        " mm. Move it onto tissue, enlarge its radius, or lower the tissue threshold.");
  }
  return { nearest };
}

Hold Simulation::Impl::holdOf(const std::vector<std::size_t>& voxels)
{
  const Grid& grid = this->model_->grid();
  Hold hold;
  hold.voxels = voxels;
  std::vector<Index3> places;
  for (const std::size_t voxel : voxels)
  {
    places.push_back(grid.indexOf(voxel));
    hold.bricks.push_back(this->bricks_.brickAt(places.back()[0], places.back()[1], places.back()[2]));
  }
  std::sort(hold.bricks.begin(), hold.bricks.end());
  hold.bricks.erase(std::unique(hold.bricks.begin(), hold.bricks.end()), hold.bricks.end());
  this->bricks_.require(hold.bricks);
  for (const Index3& at : places)
  {
    hold.addresses.push_back(this->bricks_.address(at[0], at[1], at[2]));
  }
  hold.place = hold.addresses.empty() ? 0 : hold.addresses.front();
  return hold;
}

void Simulation::Impl::setHeld(const Hold& hold, bool held)
{
  const Grid& grid = this->model_->grid();
  const int axes = this->model_->axes();
  std::vector<float> values(hold.voxels.size() * axes);
  for (std::size_t n = 0; n < hold.voxels.size(); ++n)
  {
    const Index3 at = grid.indexOf(hold.voxels[n]);
    float* c = values.data() + n * axes;
    this->bricks_.row(at[0], at[1], at[2], 1, c);
    for (int a = 0; held && a < axes; ++a)
    {
      c[a] = -std::fabs(c[a]);
    }
  }
  this->bricks_.setConstraints(hold.addresses, values);
}

void Simulation::Impl::release()
{
  for (const Hold& hold : this->holds_)
  {
    this->setHeld(hold, false);
  }
  this->holds_.clear();
}

/// Takes elements that are no more (ascending) out of all hands.
void Simulation::Impl::letGo(const std::vector<std::size_t>& removed)
{
  for (Hold& hold : this->holds_)
  {
    std::vector<std::size_t> left;
    std::set_difference(
      hold.voxels.begin(), hold.voxels.end(), removed.begin(), removed.end(), std::back_inserter(left));
    if (left.size() < hold.voxels.size())
    {
      const std::uint32_t place = hold.place;
      hold = this->holdOf(left);
      hold.place = left.empty() ? place : hold.place;
    }
  }
}

Float3 Simulation::Impl::toFraction(const Vector3& length) const
{
  const Vector3& spacing = this->model_->grid().spacing;
  Float3 fraction;
  for (int a = 0; a < 3; ++a)
  {
    fraction[a] = static_cast<float>(length[a] / spacing[a]);
  }
  return fraction;
}

void Simulation::Impl::move(const Hold& hold, const Float3& to)
{
  std::vector<float> values;
  values.reserve(3 * hold.addresses.size());
  for (std::size_t n = 0; n < hold.addresses.size(); ++n)
  {
    values.insert(values.end(), to.begin(), to.end());
  }
  this->place(hold, values);
}

/// Puts each held element at a displacement of its own, 3 interleaved values each.
void Simulation::Impl::place(const Hold& hold, const std::vector<float>& values)
{
  this->bricks_.setDisplacements(hold.addresses, values);
  for (const int brick : hold.bricks)
  {
    this->bricks_.touch(this->bricks_.slot(brick));
  }
}

Propagation::Conflict Simulation::Impl::propagate(const std::vector<int>& bricks, double enough)
{
  // How many launches it takes is not known beforehand: the share approaches 1.
  int launches = 0;
  return this->propagation_.run(bricks, enough,
    [&]
    {
      ++launches;
      this->checkpoint(launches / (launches + 50.0));
    });
}

/// All probes in one wave. False, and nothing changed, where they are not compatible.
bool Simulation::Impl::pullTogether(const std::vector<Probe>& probes)
{
  this->bricks_.saveBefore();
  std::vector<int> bricks;
  float largest = 0.0f;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    const Hold& hold = this->holds_[n];
    this->setHeld(hold, true);
    if (!probes[n].anchor)
    {
      const Float3 to = this->toFraction(probes[n].displacement);
      this->move(hold, to);
      for (const float t : to)
      {
        largest = std::max(largest, std::fabs(t));
      }
    }
    bricks.insert(bricks.end(), hold.bricks.begin(), hold.bricks.end());
  }
  if (this->propagate(bricks, tolerance(largest)).largest() <= tolerance(largest))
  {
    return true;
  }
  this->bricks_.restoreBefore();
  for (const Hold& hold : this->holds_)
  {
    this->setHeld(hold, false);
  }
  return false;
}

/// One probe after those before it, shortened per axis to what they and the anchors allow. Where the wave meets one of
/// them, the conflict is by how much the probe goes too far, or less if the wave has not yet come the shortest way. On
/// an axis on which others hold the probe's elements too far apart to be in one place, they stay where they are.
void Simulation::Impl::pullInTurn(std::size_t number, const Probe& probe)
{
  const Hold& hold = this->holds_[number];
  this->setHeld(hold, true);
  if (probe.anchor || hold.addresses.empty())
  {
    return;
  }
  this->bricks_.saveBefore();
  const std::vector<float> before = this->bricks_.displacements(hold.addresses);
  Float3 to = this->toFraction(probe.displacement);
  std::array<bool, 3> stays{};
  for (int attempt = 0; attempt < 50; ++attempt)
  {
    // A wave that is much too long would run through all tissue: it ends where it meets a large conflict.
    double enough = 0.0;
    for (const float t : to)
    {
      enough = std::max({ enough, 0.2 * std::fabs(t), static_cast<double>(tolerance(t)) });
    }
    std::vector<float> values = before;
    for (std::size_t n = 0; n < values.size(); ++n)
    {
      values[n] = stays[n % 3] ? before[n] : to[n % 3];
    }
    this->place(hold, values);
    const Propagation::Conflict conflict = this->propagate(hold.bricks, enough);
    bool compatible = true;
    for (int a = 0; a < 3; ++a)
    {
      const float rounding = tolerance(to[a]);
      const bool tooHigh = conflict.tooHigh[a] > rounding;
      const bool tooLow = conflict.tooLow[a] > rounding;
      compatible = compatible && !tooHigh && !tooLow;
      if (tooHigh && tooLow)
      {
        stays[a] = true;
      }
      else if (tooHigh || tooLow)
      {
        // The conflict of a long wave is known less exactly, so a large step stops short of it.
        const double excess = tooHigh ? conflict.tooHigh[a] : conflict.tooLow[a];
        const double step = excess - (excess > 0.1 * std::fabs(to[a]) ? rounding : 0.0);
        to[a] = static_cast<float>(to[a] + (tooHigh ? -step : step));
        to[a] = std::fabs(to[a]) <= rounding ? 0.0f : to[a];
      }
    }
    if (compatible)
    {
      return;
    }
    this->bricks_.restoreBefore();
  }
  // The last resort, feasible because nothing moves.
  this->place(hold, before);
}

std::vector<ProbeResult> Simulation::Impl::pull(const std::vector<Probe>& probes)
{
  std::vector<std::vector<std::size_t>> grabbed;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    grabbed.push_back(this->grab(probes[n], n));
  }

  return this->stoppable(
    [&]
    {
      this->release();
      this->sweep_ = 0;

      // An element has one holder: an anchor, else the first probe that grabs it. The others take what is left, and are
      // compatible with its holder only if the links between allow it.
      std::vector<std::size_t> taken;
      const Grid& grid = this->model_->grid();
      for (const std::vector<std::size_t>& voxels : grabbed)
      {
        std::vector<std::size_t> mine;
        std::set_difference(voxels.begin(), voxels.end(), taken.begin(), taken.end(), std::back_inserter(mine));
        mine.erase(std::remove_if(mine.begin(), mine.end(),
                     [&](std::size_t voxel)
                     {
                       const Index3 at = grid.indexOf(voxel);
                       float c[3];
                       this->bricks_.row(at[0], at[1], at[2], 1, c);
                       return std::signbit(c[0]);
                     }),
          mine.end());
        std::vector<std::size_t> both;
        std::set_union(taken.begin(), taken.end(), mine.begin(), mine.end(), std::back_inserter(both));
        taken.swap(both);
        this->holds_.push_back(this->holdOf(mine));
        if (mine.empty())
        {
          this->holds_.back().place = this->holdOf({ voxels.front() }).place;
        }
      }

      if (!probes.empty() && !this->pullTogether(probes))
      {
        for (std::size_t n = 0; n < probes.size(); ++n)
        {
          this->pullInTurn(n, probes[n]);
        }
      }

      return this->reached();
    });
}

std::vector<ProbeResult> Simulation::Impl::reached()
{
  const Vector3& spacing = this->model_->grid().spacing;
  std::vector<std::uint32_t> addresses;
  for (const Hold& hold : this->holds_)
  {
    addresses.push_back(hold.place);
  }
  const std::vector<float> displacements = this->bricks_.displacements(addresses);
  std::vector<ProbeResult> results(this->holds_.size());
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    results[n].elements = this->holds_[n].voxels.size();
    for (int a = 0; a < 3; ++a)
    {
      results[n].reached[a] = displacements[3 * n + a] * spacing[a];
    }
  }
  return results;
}

std::vector<ProbeResult> Simulation::Impl::probes()
{
  std::vector<ProbeResult> results = this->reached();
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    results[n].force = this->forceAt(this->holds_[n].voxels);
  }
  return results;
}

/// Gradient of the energy where these voxels, with the bone they are part of, move together.
Vector3 Simulation::Impl::forceAt(const std::vector<std::size_t>& held)
{
  const Grid& grid = this->model_->grid();
  const int axes = this->model_->axes();
  Vector3 force{};
  for (int component = 0; component < axes; ++component)
  {
    const std::vector<std::size_t> voxels = this->rigidClusters().withClusters(held, component);
    const auto constraintOf = [&](const Index3& at)
    {
      float c[3];
      this->bricks_.row(at[0], at[1], at[2], 1, c);
      return std::fabs(c[component]);
    };
    std::vector<std::uint32_t> inner;
    std::vector<std::uint32_t> outer;
    std::vector<float> limits;
    for (const std::size_t voxel : voxels)
    {
      const Index3 at = grid.indexOf(voxel);
      const std::uint8_t cut = this->bricks_.cutBits(at[0], at[1], at[2]);
      for (int d = 0; d < 6; ++d)
      {
        Index3 next = at;
        next[d / 2] += d % 2 == 0 ? -1 : 1;
        if ((cut & (1 << d)) != 0 || !grid.contains(next[0], next[1], next[2]) ||
            std::binary_search(voxels.begin(), voxels.end(), grid.at(next[0], next[1], next[2])))
        {
          continue;
        }
        const float limit = 0.5f * (constraintOf(at) + constraintOf(next));
        if (!std::isinf(limit))
        {
          // An element without memory has not moved; slot 0 says so.
          inner.push_back(this->bricks_.address(at[0], at[1], at[2]));
          outer.push_back(this->bricks_.address(next[0], next[1], next[2]));
          limits.push_back(limit);
        }
      }
    }
    const std::vector<float> ui = this->bricks_.displacements(inner);
    const std::vector<float> uj = this->bricks_.displacements(outer);
    for (int a = 0; a < 3; ++a)
    {
      for (std::size_t m = 0; (axes == 1 || a == component) && m < limits.size(); ++m)
      {
        // d/du of weight * pull^2 in physical units; spacings cancel.
        const double pull = this->elasticity_.pull(ui[3 * m + a], uj[3 * m + a], limits[m]);
        force[a] -= 2.0 * Elasticity::weight(limits[m]) * pull;
      }
    }
  }
  return force;
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
      const auto checkpoint = [&](int done) { this->checkpoint(static_cast<double>(done) / iterations); };
      if (this->relaxationMethod_ == RelaxationMethod::Paper)
      {
        return this->paperRelaxation_.run(this->elasticity_, nullptr, iterations, tolerance, checkpoint);
      }
      std::vector<std::size_t> held;
      for (const Hold& hold : this->holds_)
      {
        held.insert(held.end(), hold.voxels.begin(), hold.voxels.end());
      }
      this->rigidClusters().begin(held);
      const RelaxResult result = this->relaxation_.run(
        *this->clusters_, this->elasticity_, nullptr, this->sweep_, iterations, tolerance, checkpoint);
      this->sweep_ += result.iterations;
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
      statistics.energy += figures.energy[a] * this->model_->grid().spacing[a];
    }
    statistics.maxLinkExcess = std::max(statistics.maxLinkExcess, static_cast<double>(figures.excess));
    statistics.displaced += static_cast<std::size_t>(figures.displaced);
  }
  statistics.allocated = static_cast<std::size_t>(this->bricks_.slots() - 1) * this->bricks_.elementsPerBrick();
  statistics.deviceBytes = this->bricks_.deviceBytes();
  return statistics;
}

void Simulation::Impl::displacements(float* out)
{
  const Grid& grid = this->model_->grid();
  const Index3 size = this->bricks_.size();
  const std::size_t count = this->bricks_.elementsPerBrick();
  std::fill(out, out + 3 * grid.voxels(), 0.0f);
  std::vector<float> values;
  for (int slot = 1; slot < this->bricks_.slots(); ++slot)
  {
    if (!this->bricks_.touched(slot))
    {
      continue;
    }
    this->bricks_.readSlot(slot, values);
    const Index3 first = this->bricks_.origin(this->bricks_.brick(slot));
    for (int k = first[2]; k < std::min(first[2] + size[2], grid.size[2]); ++k)
    {
      for (int j = first[1]; j < std::min(first[1] + size[1], grid.size[1]); ++j)
      {
        for (int i = first[0]; i < std::min(first[0] + size[0], grid.size[0]); ++i)
        {
          const std::uint32_t local = this->bricks_.local(i, j, k);
          for (std::size_t a = 0; a < 3; ++a)
          {
            out[3 * grid.at(i, j, k) + a] = static_cast<float>(values[a * count + local] * grid.spacing[a]);
          }
        }
      }
    }
  }
}

void Simulation::Impl::clusters(int* out)
{
  const int axes = this->model_->axes();
  std::vector<int> labels;
  for (int a = 0; a < axes; ++a)
  {
    RigidClusters::label(this->bricks_, a, labels);
    for (std::size_t n = 0; n < labels.size(); ++n)
    {
      out[n * axes + a] = labels[n];
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
      this->bricks_.row(0, j, k, grid.size[0], row.data());
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
        const std::uint8_t cut = bits == 0 ? 0 : this->bricks_.cutBits(i, j, k);
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

void Simulation::setProgress(Progress progress)
{
  this->impl_->progress_ = std::move(progress);
}

void Simulation::setRelaxation(RelaxationMethod method, double elasticRecovery)
{
  translated([&] { this->impl_->setRelaxation(method, elasticRecovery); });
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

std::vector<ProbeResult> Simulation::pull(const std::vector<Probe>& probes)
{
  return translated([&] { return this->impl_->pull(probes); });
}

RelaxResult Simulation::relax(int iterations, double tolerance)
{
  return translated([&] { return this->impl_->relax(iterations, tolerance); });
}

std::vector<ProbeResult> Simulation::probes() const
{
  return translated([&] { return this->impl_->probes(); });
}

Statistics Simulation::measure() const
{
  return translated([&] { return this->impl_->measure(); });
}

void Simulation::displacements(float* out) const
{
  translated([&] { this->impl_->displacements(out); });
}

void Simulation::clusters(int* out) const
{
  this->impl_->clusters(out);
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
