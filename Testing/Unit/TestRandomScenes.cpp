// Some hundred random sequences of updates of random tissue, with invariants that are checked after every step: see
// Watch.
//
// A failure names its seed. CHAINMAIL_RANDOM_SEED=<seed> runs this seed alone and prints its steps.
// CHAINMAIL_RANDOM_SCENES=<number> sets the number of scenes of each of the ten tests.

#include "Blades.h"
#include "Picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

namespace
{

using namespace chainmail;
using Values = std::vector<oracle::Vector3>; // one for every voxel, fractions of the spacing

// --- What happens

/// One call of the engine.
struct Step
{
  enum Kind
  {
    Hold,
    Propagate,
    Relax,
    Cut,
    Carve,
    Reset,
    RestoreTopology,
    SetPropagation,
    SetRelaxation,
    SetTimes,
    SetCoarseToFine,
    Resample
  };

  Kind kind = Reset;
  std::vector<Probe> probes;
  Surface surface;
  int iterations = 0;  ///< for Resample the padding, for SetTimes and SetCoarseToFine whether to switch it on
  double number = 0.0; ///< tolerance and error of a relaxation, or elastic recovery
  PropagationMethod propagation = PropagationMethod::Envelope;
  ConflictPolicy policy = ConflictPolicy::Limit;
  RelaxationMethod relaxation = RelaxationMethod::Projected;
};

std::string text(const Step& step)
{
  static const char* const names[] = { "hold", "propagate", "relax", "cut", "carve", "reset", "mend", "setPropagation",
    "setRelaxation", "setPropagationTimes", "setCoarseToFine", "resample" };
  static const char* const propagations[] = { "Envelope", "Timestamp" };
  static const char* const policies[] = { "Limit", "Latest", "Share" };
  static const char* const relaxations[] = { "Projected", "Paper" };
  std::ostringstream out;
  out.precision(17);
  out << names[step.kind];
  switch (step.kind)
  {
  case Step::Propagate:
  case Step::Resample:
  case Step::SetTimes:
  case Step::SetCoarseToFine:
    out << ' ' << step.iterations;
    break;
  case Step::Relax:
    out << ' ' << step.iterations << " to " << step.number;
    break;
  case Step::Cut:
  case Step::Carve:
    out << ' ' << step.surface.triangles.size() << " triangles";
    break;
  case Step::SetPropagation:
    out << ' ' << propagations[static_cast<int>(step.propagation)] << ' ' << policies[static_cast<int>(step.policy)];
    break;
  case Step::SetRelaxation:
    out << ' ' << relaxations[static_cast<int>(step.relaxation)] << ' ' << step.number;
    break;
  default:
    break;
  }
  for (const Probe& p : step.probes)
  {
    out << "\n    at " << p.position[0] << ' ' << p.position[1] << ' ' << p.position[2] << " radius " << p.radius;
    if (p.anchor)
    {
      out << " anchor";
    }
    if (p.isSoft())
    {
      out << " soft " << p.tolerance;
    }
    out << " by " << p.displacement[0] << ' ' << p.displacement[1] << ' ' << p.displacement[2];
  }
  return out.str();
}

/// The results of a step.
struct Answer
{
  bool refused = false;
  std::size_t removed = 0;
  PropagateResult propagated;
  RelaxResult relaxed;
  std::vector<float> offsets;
};

Answer apply(Simulation& simulation, const Step& step)
{
  Answer answer;
  OutputDetail detail;
  switch (step.kind)
  {
  case Step::Hold:
    try
    {
      simulation.hold(step.probes);
    }
    catch (const ProbeError&)
    {
      answer.refused = true;
    }
    break;
  case Step::Propagate:
    answer.propagated = simulation.propagate(step.iterations);
    break;
  case Step::Relax:
    answer.relaxed = simulation.relax(step.iterations, step.number, step.number);
    break;
  case Step::Cut:
    answer.removed = simulation.cut(step.surface);
    break;
  case Step::Carve:
    answer.removed = simulation.carve(step.surface);
    break;
  case Step::Reset:
    simulation.reset();
    break;
  case Step::RestoreTopology:
    simulation.restoreTopology();
    break;
  case Step::SetPropagation:
    simulation.setPropagation(step.propagation, step.policy);
    break;
  case Step::SetRelaxation:
    simulation.setRelaxation(step.relaxation, step.number);
    break;
  case Step::SetTimes:
    simulation.setPropagationTimes(step.iterations != 0);
    break;
  case Step::SetCoarseToFine:
    simulation.setCoarseToFine(step.iterations != 0);
    break;
  case Step::Resample:
    detail.finer = 1 + step.iterations % 2;
    answer.offsets = resample(simulation, { step.iterations, 0, 1 }, CutSurfaces::Stepped, detail).offset;
    break;
  }
  return answer;
}

/// All results of a simulation, to compare their bits.
struct Reading
{
  std::vector<float> u; ///< [mm]
  std::vector<std::uint8_t> links;
  std::vector<std::uint8_t> elements;
  std::vector<float> times;
  std::vector<int> fronts;
  std::vector<ProbeResult> probes;
};

Reading read(const Simulation& simulation)
{
  const std::size_t voxels = simulation.model().grid().voxels();
  const std::size_t values = voxels * simulation.model().axes();
  Reading reading{ displacements(simulation), links(simulation), std::vector<std::uint8_t>(voxels),
    std::vector<float>(values), std::vector<int>(values), simulation.probes() };
  simulation.elements(reading.elements.data());
  simulation.propagationTimes(reading.times.data());
  simulation.wavefronts(reading.fronts.data());
  return reading;
}

bool same(const Reading& a, const Reading& b)
{
  bool equal = sameBits(a.u, b.u) && a.links == b.links && a.elements == b.elements && sameBits(a.times, b.times) &&
               a.fronts == b.fronts && a.probes.size() == b.probes.size();
  for (std::size_t p = 0; equal && p < a.probes.size(); ++p)
  {
    equal = a.probes[p].reached == b.probes[p].reached && a.probes[p].force == b.probes[p].force &&
            a.probes[p].elements == b.probes[p].elements;
  }
  return equal;
}

// --- What must hold

/// Follows a simulation and checks invariants after every step, in double and with an implementation of its own:
/// - all numbers are finite, air and carved tissue have displacement 0, anchored tissue never moves;
/// - between waves every link is within its limit (unless the published relaxation ignored limits before);
/// - only cuts and carves remove links and elements, and only restoreTopology() brings them back;
/// - a wave is formula (P*): the state before it, clamped between the cones of the tissue that is held after it;
/// - under Limit, a single moved probe reaches the nearest displacement that anchors and other probes allow;
/// - a handle keeps its place until its probe moves or, under Latest, another wave drags it along; anchors always do;
/// - a projected relaxation never raises the energy, which includes that of soft probes; soft probes hold nothing;
/// - reset() and restoreTopology() give exactly the state at rest;
/// - measure() and probes() agree with the state.
class Watch
{
public:
  Watch(const Scene& scene, const Reading& first)
    : scene_(scene)
    , block_(scene.block())
    , now_(first)
    , settled_(first)
    , whole_(first)
  {
  }

  const Reading& now() const { return this->now_; }

  /// Whether the bits of the state must not depend on the brick size. They may while envelopes are under way, and after
  /// a probe was shortened, because its displacement is then computed iteratively.
  bool brickless() const { return this->brickless_ && !this->underWay_; }

  void check(const Step& step, const Answer& answer, const Simulation& simulation);

  /// The largest value of each figure over all scenes, as a share of its bound.
  static std::map<std::string, double>& worst()
  {
    static std::map<std::string, double> shares;
    return shares;
  }

private:
  struct Held
  {
    Probe probe;
    std::vector<std::size_t> voxels;
    Values grabbed;    ///< displacements when the probe grabbed, of each element
    bool moved = true; ///< whether the probe has moved since all waves were finished
  };

  oracle::Vector3 at(const Reading& reading, std::size_t voxel) const
  {
    const Vector3& h = this->scene_.grid.spacing;
    const float* u = reading.u.data() + 3 * voxel;
    return { u[0] / h[0], u[1] / h[1], u[2] / h[2] };
  }
  Values values(const Reading& reading) const
  {
    Values v(this->block_.count());
    for (std::size_t n = 0; n < v.size(); ++n)
    {
      v[n] = this->at(reading, n);
    }
    return v;
  }

  double energy(const Values& v, double* rounding = nullptr) const;
  std::vector<std::size_t> grab(const Probe& probe, double& margin) const;
  void take(const Step& step, const Answer& answer);
  void wavesEnded(const Reading& before);
  void checkFormula();
  void checkReach(const Held& held, const Values& before);
  void checkTopology(const Step& step, const Answer& answer, const Reading& before);
  void checkRelaxation(const Step& step, const Answer& answer, const Reading& before);
  void checkRest();
  void checkState(const Simulation& simulation);

  void within(const char* what, double figure, double allowed)
  {
    EXPECT_LE(figure, allowed) << what;
    double& worst = Watch::worst()[what];
    worst = std::max(worst, allowed > 0.0 ? figure / allowed : 0.0);
  }

  const Scene& scene_;
  oracle::Block block_; ///< the model with all cuts and carves
  Reading now_;
  Reading settled_; ///< the state before the waves that are under way
  Reading whole_;
  std::vector<Held> held_;
  bool underWay_ = false;
  bool plain_ = true;     ///< the waves under way are those of a single hold(), without any other call
  bool strained_ = false; ///< the published relaxation may have put links beyond their limits
  bool brickless_ = true;
  PropagationMethod propagation_ = PropagationMethod::Envelope;
  ConflictPolicy policy_ = ConflictPolicy::Limit;
  RelaxationMethod relaxation_ = RelaxationMethod::Projected;
  double slack_ = 0.0;
  double furthest_ = 1.0; ///< largest displacement since rest, at least 1; rounding is relative to it
};

/// The energy, and its largest change by the rounding of displacements to float32.
double Watch::energy(const Values& v, double* rounding) const
{
  double sum = 0.0;
  const double unit = 1.2e-7 * this->furthest_;
  for (const oracle::Link& link : oracle::links(this->block_))
  {
    for (int a = 0; a < 3; ++a)
    {
      const double limit = oracle::limit(this->block_, link, a);
      const double strain = std::abs(v[link.from][a] - v[link.to][a]) - this->slack_ * limit;
      const double pull = std::max(0.0, strain);
      const double weight = this->scene_.grid.spacing[a] / (limit + 1e-6);
      sum += weight * pull * pull;
      if (rounding && strain > -unit && v[link.from] != v[link.to])
      {
        *rounding += weight * (2.0 * pull + unit) * unit;
      }
    }
  }
  for (const Held& held : this->held_)
  {
    for (std::size_t n = 0; held.probe.isSoft() && n < held.voxels.size(); ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double h = this->scene_.grid.spacing[a];
        const double target = held.grabbed[n][a] + (held.probe.anchor ? 0.0 : held.probe.displacement[a] / h);
        const double distance = std::abs(v[held.voxels[n]][a] - target);
        const double weight = h * h / held.probe.tolerance;
        sum += weight * distance * distance;
        if (rounding)
        {
          const double step = std::max(unit, 1.2e-7 * std::abs(target));
          *rounding += weight * (2.0 * distance + step) * step;
        }
      }
    }
  }
  return sum;
}

/// The elements that a probe grabs in the state before this step, and the margin of this choice [mm].
std::vector<std::size_t> Watch::grab(const Probe& probe, double& margin) const
{
  const Vector3& h = this->scene_.grid.spacing;
  const double reach = 0.5 * std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  std::vector<std::size_t> within;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity(), second = least;
  margin = least;
  for (std::size_t v = 0; v < this->block_.count(); ++v)
  {
    if (!this->block_.tissue[v])
    {
      continue;
    }
    const Index3 p = this->scene_.grid.indexOf(v);
    double square = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const double d = p[a] * h[a] + static_cast<double>(this->now_.u[3 * v + a]) - probe.position[a];
      square += d * d;
    }
    const double distance = std::sqrt(square);
    if (probe.radius > 0.0)
    {
      margin = std::min(margin, std::abs(distance - probe.radius));
      if (distance <= probe.radius)
      {
        within.push_back(v);
      }
    }
    second = std::min(second, std::max(distance, least));
    if (distance < least)
    {
      least = distance;
      nearest = v;
    }
  }
  if (within.empty())
  {
    margin = std::min({ margin, second - least, std::abs(least - reach) });
    if (least <= reach)
    {
      within.push_back(nearest);
    }
  }
  return within;
}

/// Simulation::hold(), reimplemented.
void Watch::take(const Step& step, const Answer& answer)
{
  std::vector<Held> next(step.probes.size());
  std::vector<char> known(step.probes.size(), 0), used(this->held_.size(), 0), taken(this->block_.count(), 0);
  std::vector<std::vector<std::size_t>> grabbed(step.probes.size());
  bool nothing = false;
  for (std::size_t n = 0; n < step.probes.size(); ++n)
  {
    for (std::size_t m = 0; !known[n] && m < this->held_.size(); ++m)
    {
      if (!used[m] && this->held_[m].probe.position == step.probes[n].position &&
          this->held_[m].probe.radius == step.probes[n].radius)
      {
        used[m] = known[n] = 1;
        next[n] = this->held_[m];
        for (const std::size_t v : next[n].voxels)
        {
          taken[v] = taken[v] || (!next[n].probe.isSoft() && !step.probes[n].isSoft()) ? 1 : 0;
        }
      }
    }
    if (!known[n])
    {
      double margin;
      grabbed[n] = this->grab(step.probes[n], margin);
      ASSERT_GT(margin, 1e-9) << "an unlucky draw: which element the probe holds is a matter of rounding";
      nothing = nothing || grabbed[n].empty();
    }
  }
  EXPECT_EQ(answer.refused, nothing);
  if (nothing)
  {
    return;
  }
  bool moves = false;
  for (std::size_t n = 0; n < next.size(); ++n)
  {
    if (!known[n] || !next[n].probe.isSoft() || step.probes[n].isSoft())
    {
      continue;
    }
    // A probe that becomes hard takes the elements that no other holds.
    for (std::size_t m = next[n].voxels.size(); m-- > 0;)
    {
      if (taken[next[n].voxels[m]] || this->block_.anchored[next[n].voxels[m]])
      {
        next[n].voxels.erase(next[n].voxels.begin() + m);
        next[n].grabbed.erase(next[n].grabbed.begin() + m);
      }
    }
    for (const std::size_t v : next[n].voxels)
    {
      taken[v] = 1;
    }
    next[n].moved = true;
    moves = moves || !step.probes[n].anchor;
  }
  for (const bool anchors : { true, false })
  {
    for (std::size_t n = 0; n < next.size(); ++n)
    {
      if (known[n] || step.probes[n].anchor != anchors)
      {
        continue;
      }
      for (const std::size_t v : grabbed[n])
      {
        const bool soft = step.probes[n].isSoft();
        if (soft || (!taken[v] && !this->block_.anchored[v]))
        {
          taken[v] = taken[v] || !soft ? 1 : 0;
          next[n].voxels.push_back(v);
          next[n].grabbed.push_back(this->at(this->now_, v));
        }
      }
      next[n].moved = true;
      moves = moves || (!anchors && !step.probes[n].isSoft());
    }
  }
  for (std::size_t n = 0; n < next.size(); ++n)
  {
    const Probe& before = next[n].probe;
    if (known[n] && !step.probes[n].anchor && !step.probes[n].isSoft() &&
        (before.anchor || before.displacement != step.probes[n].displacement))
    {
      next[n].moved = moves = true;
    }
    next[n].probe = step.probes[n];
  }
  if (this->underWay_)
  {
    this->plain_ = false;
    this->brickless_ = this->brickless_ && this->propagation_ == PropagationMethod::Timestamp;
  }
  else
  {
    this->plain_ = true;
    this->settled_ = this->now_;
  }
  this->underWay_ = this->underWay_ || moves;
  this->held_ = std::move(next);
}

void Watch::checkFormula()
{
  const Values before = this->values(this->settled_), after = this->values(this->now_);
  std::vector<const Held*> movers;
  for (const Held& held : this->held_)
  {
    if (held.moved && !held.probe.anchor && !held.probe.isSoft())
    {
      movers.push_back(&held);
    }
  }
  // Under Latest a wave ignores other probes; of several waves, the last one prevails where they overlap.
  if (this->policy_ == ConflictPolicy::Latest && movers.size() != 1)
  {
    return;
  }
  for (int a = 0; a < 3; ++a)
  {
    std::vector<std::pair<std::size_t, double>> up, down;
    const auto hold = [&](std::size_t v)
    {
      up.push_back({ v, after[v][a] });
      down.push_back({ v, -after[v][a] });
    };
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      if (this->block_.tissue[v] && this->block_.anchored[v])
      {
        hold(v);
      }
    }
    for (const Held& held : this->held_)
    {
      if (!held.probe.isSoft() && (this->policy_ != ConflictPolicy::Latest || held.probe.anchor || held.moved))
      {
        std::for_each(held.voxels.begin(), held.voxels.end(), hold);
      }
    }
    const std::vector<double> upper = oracle::shortest(this->block_, a, up);
    const std::vector<double> lower = oracle::shortest(this->block_, a, down);
    double worst = 0.0;
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      if (this->block_.tissue[v])
      {
        const double expected = std::min(std::max(before[v][a], -lower[v]), upper[v]);
        worst = std::max(worst, std::abs(after[v][a] - expected));
      }
    }
    // Sums in float32 along paths of about fifty links, and the strain that two compatible handles may cause.
    this->within("formula", worst, 5e-6 * this->furthest_);
  }
  if (movers.size() == 1 && this->policy_ == ConflictPolicy::Limit)
  {
    this->checkReach(*movers[0], before);
  }
}

/// A single probe reaches its target, or the nearest displacement that other holders allow for all its elements.
void Watch::checkReach(const Held& mover, const Values& before)
{
  const Values after = this->values(this->now_);
  for (int a = 0; a < 3 && !mover.voxels.empty(); ++a)
  {
    std::vector<std::pair<std::size_t, double>> up, down;
    const auto hold = [&](std::size_t v)
    {
      up.push_back({ v, before[v][a] });
      down.push_back({ v, -before[v][a] });
    };
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      if (this->block_.tissue[v] && this->block_.anchored[v])
      {
        hold(v);
      }
    }
    for (const Held& held : this->held_)
    {
      if (&held != &mover && !held.probe.isSoft())
      {
        std::for_each(held.voxels.begin(), held.voxels.end(), hold);
      }
    }
    const std::vector<double> upper = oracle::shortest(this->block_, a, up);
    const std::vector<double> lower = oracle::shortest(this->block_, a, down);
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t n = 0; n < mover.voxels.size(); ++n)
    {
      low = std::max(low, -lower[mover.voxels[n]] - mover.grabbed[n][a]);
      high = std::min(high, upper[mover.voxels[n]] - mover.grabbed[n][a]);
    }
    const double asked = mover.probe.displacement[a] / this->scene_.grid.spacing[a];
    const double reached = after[mover.voxels[0]][a] - mover.grabbed[0][a];
    const double rounding = 6e-6 * std::max(this->furthest_, std::abs(asked));
    if (high - low > rounding)
    {
      this->within("reach", std::abs(reached - std::min(std::max(asked, low), high)), rounding);
    }
  }
}

/// All waves are finished; `before` is the state before this step.
void Watch::wavesEnded(const Reading& before)
{
  (void)before;
  for (Held& held : this->held_)
  {
    for (std::size_t n = 0; !held.probe.isSoft() && n < held.voxels.size(); ++n)
    {
      const std::size_t v = held.voxels[n];
      const bool stays =
        held.probe.anchor ? !held.moved || this->plain_ : !held.moved && this->policy_ != ConflictPolicy::Latest;
      for (int a = 0; stays && a < 3; ++a)
      {
        ASSERT_EQ(this->now_.u[3 * v + a], this->settled_.u[3 * v + a]) << "what is held moved";
      }
      for (int a = 0; !held.probe.anchor && a < 3; ++a)
      {
        const double asked = held.probe.displacement[a] / this->scene_.grid.spacing[a];
        const double reached = this->at(this->now_, v)[a] - held.grabbed[n][a];
        if (std::abs(reached - asked) > 1e-6 * std::max(this->furthest_, std::abs(asked)))
        {
          this->brickless_ = false;
        }
      }
    }
  }
  if (this->plain_ && !this->strained_)
  {
    this->checkFormula();
  }
  for (Held& held : this->held_)
  {
    held.moved = false;
  }
  this->underWay_ = false;
  this->plain_ = true;
}

void Watch::checkTopology(const Step& step, const Answer& answer, const Reading& before)
{
  if (step.kind == Step::RestoreTopology)
  {
    EXPECT_EQ(this->now_.links, this->whole_.links);
    EXPECT_EQ(this->now_.elements, this->whole_.elements);
    this->block_ = this->scene_.block();
    return;
  }
  if (step.kind != Step::Cut && step.kind != Step::Carve)
  {
    EXPECT_EQ(this->now_.links, before.links);
    EXPECT_EQ(this->now_.elements, before.elements);
    return;
  }
  std::size_t removedLinks = 0, removedElements = 0, wrong = 0;
  for (std::size_t v = 0; v < this->block_.count(); ++v)
  {
    const unsigned gone = before.links[v] & ~this->now_.links[v];
    wrong += (this->now_.links[v] & ~before.links[v]) != 0 || (this->now_.elements[v] > before.elements[v]);
    removedElements += before.elements[v] - this->now_.elements[v];
    for (const unsigned bit : { 2u, 8u, 32u })
    {
      removedLinks += (gone & bit) != 0;
    }
    if (!this->now_.elements[v])
    {
      this->block_.tissue[v] = this->block_.anchored[v] = 0;
    }
  }
  takeLinks(this->block_, this->now_.links);
  EXPECT_EQ(wrong, 0u) << "something came back";
  EXPECT_EQ(oracle::linkBits(this->block_), this->now_.links) << "a link that only one end knows of";
  EXPECT_EQ(step.kind == Step::Cut ? removedLinks : removedElements, answer.removed);
  EXPECT_TRUE(step.kind == Step::Carve || removedElements == 0u);
  for (Held& held : this->held_)
  {
    for (std::size_t n = held.voxels.size(); n-- > 0;)
    {
      if (!this->block_.tissue[held.voxels[n]])
      {
        held.voxels.erase(held.voxels.begin() + n);
        held.grabbed.erase(held.grabbed.begin() + n);
      }
    }
  }
}

void Watch::checkRelaxation(const Step& step, const Answer& answer, const Reading& before)
{
  if (this->underWay_ && this->propagation_ == PropagationMethod::Envelope)
  {
    EXPECT_EQ(answer.relaxed.iterations, 0);
    EXPECT_TRUE(sameBits(this->now_.u, before.u));
    return;
  }
  EXPECT_LE(answer.relaxed.iterations, step.iterations);
  if (answer.relaxed.iterations == 0)
  {
    EXPECT_TRUE(sameBits(this->now_.u, before.u));
    return;
  }
  EXPECT_TRUE(answer.relaxed.converged || answer.relaxed.iterations == step.iterations || this->underWay_);
  for (const Held& held : this->held_)
  {
    for (const std::size_t v : held.probe.isSoft() ? std::vector<std::size_t>() : held.voxels)
    {
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_EQ(this->now_.u[3 * v + a], before.u[3 * v + a]) << "a relaxation moved what is held";
      }
    }
  }
  if (this->underWay_)
  {
    this->plain_ = false;
    this->strained_ = this->strained_ || this->relaxation_ == RelaxationMethod::Paper;
    return;
  }
  if (this->relaxation_ == RelaxationMethod::Projected && !this->strained_)
  {
    double rounding = 0.0;
    const double was = this->energy(this->values(before), &rounding), is = this->energy(this->values(this->now_));
    this->within("rise of energy", is - was, rounding);
  }
  // A projected relaxation first projects the state of the published one to a feasible one.
  this->strained_ = this->relaxation_ == RelaxationMethod::Paper;
}

void Watch::checkRest()
{
  for (const float u : this->now_.u)
  {
    ASSERT_EQ(u, 0.0f) << "not at rest";
  }
  for (std::size_t n = 0; n < this->now_.times.size(); ++n)
  {
    ASSERT_EQ(this->now_.times[n], -1.0f);
    ASSERT_EQ(this->now_.fronts[n], 0);
  }
  this->held_.clear();
  this->underWay_ = this->strained_ = false;
  this->plain_ = this->brickless_ = true;
  this->furthest_ = 1.0;
}

void Watch::checkState(const Simulation& simulation)
{
  const Values v = this->values(this->now_);
  std::size_t displaced = 0;
  for (std::size_t n = 0; n < v.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      ASSERT_TRUE(std::isfinite(this->now_.u[3 * n + a]));
      ASSERT_TRUE(this->now_.u[3 * n + a] == 0.0f || (this->block_.tissue[n] && !this->block_.anchored[n]))
        << "air, carved or anchored tissue moved";
    }
    displaced += v[n] != oracle::Vector3{};
  }
  for (std::size_t n = 0; n < this->now_.times.size(); ++n)
  {
    ASSERT_EQ(this->now_.times[n] >= 0.0f, this->now_.fronts[n] > 0);
    ASSERT_TRUE(std::isfinite(this->now_.times[n]));
  }

  const double excess = oracle::maxLinkExcess(this->block_, v);
  if (!this->underWay_ && !this->strained_)
  {
    // The engine's tolerance for compatible handles is 2e-6 of displacements.
    this->within("excess", excess, 4e-6 * this->furthest_);
  }
  const Statistics statistics = simulation.measure();
  double rounding = 0.0;
  const double energy = this->energy(v, &rounding);
  EXPECT_EQ(statistics.displaced, displaced);
  EXPECT_NEAR(statistics.maxLinkExcess, excess, 1e-6 * this->furthest_);
  this->within("measured energy", std::abs(statistics.energy - energy), 2.0 * rounding + 1e-5 * energy);

  ASSERT_EQ(this->now_.probes.size(), this->held_.size());
  for (std::size_t p = 0; p < this->held_.size(); ++p)
  {
    const Held& held = this->held_[p];
    const ProbeResult& result = this->now_.probes[p];
    EXPECT_EQ(result.elements, held.voxels.size()) << "probe " << p;
    for (int a = 0; a < 3; ++a)
    {
      const double h = this->scene_.grid.spacing[a];
      ASSERT_TRUE(std::isfinite(result.reached[a]) && std::isfinite(result.force[a]));
      if (!held.voxels.empty())
      {
        const std::size_t count = held.probe.isSoft() ? held.voxels.size() : 1;
        double reached = 0.0;
        for (std::size_t n = 0; n < count; ++n)
        {
          reached += (v[held.voxels[n]][a] - held.grabbed[n][a]) / static_cast<double>(count);
        }
        EXPECT_NEAR(result.reached[a] / h, reached, 1e-6 * this->furthest_) << "probe " << p;
      }
    }
  }
}

void Watch::check(const Step& step, const Answer& answer, const Simulation& simulation)
{
  const Reading before = std::move(this->now_);
  if (step.kind == Step::Hold)
  {
    this->now_ = before;
    this->take(step, answer);
  }
  this->now_ = read(simulation);
  if (step.kind == Step::Cut || step.kind == Step::Carve)
  {
    // These calls first complete the waves.
    if (this->underWay_)
    {
      this->plain_ = false;
    }
    this->checkTopology(step, answer, before);
  }
  for (const float u : this->now_.u)
  {
    this->furthest_ =
      std::max(this->furthest_, static_cast<double>(std::abs(u)) / *std::min_element(this->scene_.grid.spacing.begin(),
                                                                     this->scene_.grid.spacing.end()));
  }
  switch (step.kind)
  {
  case Step::Hold:
  case Step::SetRelaxation:
  case Step::SetTimes:
  case Step::SetCoarseToFine:
  case Step::Resample:
    EXPECT_TRUE(sameBits(this->now_.u, before.u)) << "moved something";
    break;
  case Step::Relax:
    this->checkRelaxation(step, answer, before);
    break;
  case Step::Reset:
  case Step::RestoreTopology:
    this->checkRest();
    break;
  case Step::Propagate:
    EXPECT_TRUE(answer.propagated.finished || step.iterations > 0);
    EXPECT_TRUE(this->underWay_ || (answer.propagated.finished && answer.propagated.iterations == 0));
    if (this->underWay_ && answer.propagated.finished)
    {
      this->wavesEnded(before);
    }
    break;
  case Step::SetPropagation:
  case Step::Cut:
  case Step::Carve:
    if (this->underWay_)
    {
      this->wavesEnded(before);
    }
    break;
  }
  if (step.kind != Step::Cut && step.kind != Step::Carve)
  {
    this->checkTopology(step, answer, before);
  }
  if (!this->underWay_)
  {
    this->settled_ = this->now_;
  }
  if (step.kind == Step::SetPropagation)
  {
    this->propagation_ = step.propagation;
    this->policy_ = step.policy;
  }
  if (step.kind == Step::SetRelaxation)
  {
    this->relaxation_ = step.relaxation;
    this->slack_ = static_cast<float>(1.0 - step.number);
  }
  this->checkState(simulation);
}

// --- Random lives

/// Draws a random scene, then random steps one after the other.
class Story
{
public:
  explicit Story(std::uint64_t seed)
    : random_(seed * 7919 + 13)
    , softRandom_(seed * 104729 + 7)
    , soft_(this->softRandom_.chance(0.4) ? 0.4 : 0.0)
    , scene_(this->drawScene())
    , fromRest_(this->random_.chance(0.4))
    , paper_(this->random_.chance(0.15))
  {
  }

  const Scene& scene() const { return this->scene_; }
  const Index3& brick() const { return this->brick_; }
  const Index3& otherBrick() const { return this->otherBrick_; }

  /// The steps of one update by a user, for the current places of the tissue.
  std::vector<Step> next(const Reading& now);

private:
  Vector3 displacement();
  Scene drawScene();
  Index3 drawSize();
  void drawMaterial(Scene& scene);
  std::optional<Probe> drawProbe(const Reading& now, bool atRest);
  Surface drawBlade();
  Surface drawClosed();
  Step drawTopology();

  double drawTolerance();

  Random random_;
  Random softRandom_; ///< a generator of its own, so all other random numbers are the same as without soft probes
  double soft_;       ///< probability of soft probes
  Scene scene_;
  Index3 brick_{};
  Index3 otherBrick_{};
  bool fromRest_;
  bool paper_;
  std::vector<Probe> probes_;
};

Index3 Story::drawSize()
{
  const int kind = this->random_.below(10);
  Index3 size{ 1, 1, 1 };
  if (kind == 0)
  {
    size[this->random_.below(3)] = this->random_.between(1, 60);
  }
  else if (kind <= 2)
  {
    const int flat = this->random_.below(3);
    for (int a = 0; a < 3; ++a)
    {
      size[a] = a == flat ? 1 : this->random_.between(2, 24);
    }
  }
  else
  {
    for (int& n : size)
    {
      n = this->random_.between(2, kind == 9 ? 20 : 12);
    }
  }
  return size;
}

void Story::drawMaterial(Scene& scene)
{
  const int kind = this->random_.below(7);
  const float common = static_cast<float>(this->random_.logarithmic(0.01, 0.99));
  const int soft = this->random_.below(3);
  scene.each(
    [&](int i, int j, int k)
    {
      const Index3 p{ i, j, k };
      for (int c = 0; c < scene.components; ++c)
      {
        float value = common;
        switch (kind)
        {
        case 0: // homogeneous
          break;
        case 1: // patches
          value = static_cast<float>(this->random_(0.02, 0.25) + ((i / 4 + j / 4 + k / 4 + c) % 2 ? 0.2 : 0.0));
          break;
        case 2: // noise
          value = static_cast<float>(this->random_(0.0, 0.99));
          break;
        case 3: // rigid except for soft sheets
          value = p[soft] % 4 == 1 ? common : 0.0f;
          break;
        case 4: // rods of bone
          value = p[soft] % 5 == 2 && p[(soft + 1) % 3] % 4 == 1 ? 0.0f : common;
          break;
        case 5: // layers with constraints of ratio 1 : 1000
          value = p[soft] / 2 % 2 == 0 ? common : 0.001f * common;
          break;
        default: // noise with a share of rigid elements
          value = this->random_.chance(0.2) ? 0.0f : static_cast<float>(this->random_(0.05, 0.6));
          break;
        }
        scene.constraint[scene.grid.at(i, j, k) * scene.components + c] = value;
      }
    });
}

Scene Story::drawScene()
{
  Scene scene(this->drawSize(), 0.3f, this->random_.chance(0.3) ? 3 : 1);
  this->drawMaterial(scene);
  const double airs[] = { 0.0, 0.0, 0.1, 0.3, 0.6 };
  const double air = airs[this->random_.below(5)];
  const int sheets = this->random_.chance(0.15) ? this->random_.below(3) : -1;
  scene.each(
    [&](int i, int j, int k)
    {
      const Index3 p{ i, j, k };
      if (this->random_.chance(air) || (sheets >= 0 && p[sheets] % 3 == 2))
      {
        scene.air(i, j, k);
      }
    });
  scene.scalar[scene.grid.voxels() / 2] = 1.0f;
  if (this->random_.chance(0.6))
  {
    for (double& h : scene.grid.spacing)
    {
      h = this->random_.logarithmic(0.2, 5.0);
    }
  }
  for (bool& face : scene.anchors.faces)
  {
    face = this->random_.chance(0.15);
  }
  scene.anchors.rigid = this->random_.chance(0.1);
  const Index3 bricks[] = { { 4, 2, 2 }, { 8, 4, 8 }, { 32, 16, 4 }, { 4, 8, 2 }, { 16, 4, 4 } };
  const int brick = this->random_.below(5);
  this->brick_ = bricks[brick];
  this->otherBrick_ = bricks[(brick + this->random_.between(1, 4)) % 5];
  return scene;
}

Vector3 Story::displacement()
{
  const double reach = this->random_.chance(0.05) ? 100.0 : this->random_.logarithmic(0.02, 6.0);
  Vector3 d;
  for (int a = 0; a < 3; ++a)
  {
    d[a] = this->random_.chance(0.15) ? 0.0 : this->random_(-reach, reach) * this->scene_.grid.spacing[a];
  }
  return d;
}

double Story::drawTolerance()
{
  const Vector3& h = this->scene_.grid.spacing;
  return this->softRandom_.chance(this->soft_) ? this->softRandom_.logarithmic(1e-3, 10.0) * (h[0] + h[1] + h[2]) / 3.0
                                               : 0.0;
}

/// On an element at its current place, or at its place at rest.
std::optional<Probe> Story::drawProbe(const Reading& now, bool atRest)
{
  std::vector<std::size_t> elements;
  for (std::size_t v = 0; v < now.elements.size(); ++v)
  {
    if (now.elements[v])
    {
      elements.push_back(v);
    }
  }
  if (elements.empty())
  {
    return {};
  }
  const std::size_t voxel = elements[this->random_.below(static_cast<int>(elements.size()))];
  const Index3 p = this->scene_.grid.indexOf(voxel);
  Probe probe = probeAt(this->scene_, p, this->displacement());
  const Vector3& h = this->scene_.grid.spacing;
  for (int a = 0; a < 3; ++a)
  {
    probe.position[a] += this->random_(-0.3, 0.3) * h[a] + (atRest ? 0.0 : now.u[3 * voxel + a]);
  }
  probe.radius = this->random_.chance(0.5) ? 0.0 : this->random_(0.2, 2.5) * (h[0] + h[1] + h[2]) / 3.0;
  probe.anchor = this->random_.chance(0.15);
  probe.tolerance = this->drawTolerance();
  return probe;
}

Surface Story::drawBlade()
{
  const Grid& grid = this->scene_.grid;
  Surface surface;
  for (int n = 0; n < 3 + this->random_.below(3); ++n)
  {
    Vector3 point;
    for (int a = 0; a < 3; ++a)
    {
      point[a] = (this->random_(-0.6, 1.6) * grid.size[a] - 0.5) * grid.spacing[a];
    }
    surface.points.push_back(point);
    if (n >= 2)
    {
      surface.triangles.push_back({ n - 2, n - 1, n });
    }
  }
  return surface;
}

Surface Story::drawClosed()
{
  const Grid& grid = this->scene_.grid;
  Vector3 centre, half;
  double radius = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    const double length = grid.size[a] * grid.spacing[a];
    centre[a] = this->random_(-0.1, 1.1) * length;
    half[a] = this->random_(0.05, 0.35) * length + 0.3 * grid.spacing[a];
    radius = std::max(radius, 0.5 * half[a]);
  }
  if (this->random_.chance(0.5))
  {
    return sphere(centre, radius, this->random_.between(4, 9), this->random_.between(5, 11));
  }
  return box({ centre[0] - half[0], centre[1] - half[1], centre[2] - half[2] },
    { centre[0] + half[0], centre[1] + half[1], centre[2] + half[2] });
}

Step Story::drawTopology()
{
  Step step;
  const bool carves = this->random_.chance(0.35);
  step.kind = carves ? Step::Carve : Step::Cut;
  step.surface = carves ? this->drawClosed() : this->random_.chance(0.8) ? this->drawBlade() : this->drawClosed();
  return step;
}

std::vector<Step> Story::next(const Reading& now)
{
  std::vector<Step> steps;
  const auto add = [&](Step::Kind kind) -> Step&
  {
    steps.emplace_back();
    steps.back().kind = kind;
    return steps.back();
  };
  if (this->random_.chance(0.2))
  {
    Step& step = add(Step::SetPropagation);
    step.propagation = this->random_.chance(0.5) ? PropagationMethod::Envelope : PropagationMethod::Timestamp;
    step.policy = this->random_.chance(0.6) ? ConflictPolicy::Limit : ConflictPolicy::Latest;
    if (step.propagation == PropagationMethod::Envelope && this->random_.chance(0.3))
    {
      step.policy = ConflictPolicy::Share;
    }
  }
  if (this->random_.chance(0.1))
  {
    add(Step::SetTimes).iterations = this->random_.below(2);
  }
  if (this->random_.chance(0.2))
  {
    Step& step = add(Step::SetRelaxation);
    step.relaxation = this->paper_ && this->random_.chance(0.5) ? RelaxationMethod::Paper : RelaxationMethod::Projected;
    step.number = this->random_.chance(0.5) ? 1.0 : this->random_(0.0, 1.0);
  }
  if (this->random_.chance(0.15))
  {
    add(Step::SetCoarseToFine).iterations = this->random_.below(2);
  }
  if (this->random_.chance(0.06))
  {
    add(Step::RestoreTopology);
  }
  const bool rests =
    this->fromRest_ || this->random_.chance(0.1) || (!steps.empty() && steps.back().kind == Step::RestoreTopology);
  if (rests)
  {
    if (steps.empty() || steps.back().kind != Step::RestoreTopology)
    {
      add(Step::Reset);
    }
    if (!this->fromRest_)
    {
      this->probes_.clear();
    }
  }
  if (this->random_.chance(0.25))
  {
    steps.push_back(this->drawTopology());
  }

  // Some probes are removed, some are moved, some are new.
  for (std::size_t p = this->probes_.size(); p-- > 0;)
  {
    if (this->random_.chance(0.15))
    {
      this->probes_.erase(this->probes_.begin() + p);
    }
    else if (this->random_.chance(0.4))
    {
      this->probes_[p].displacement = this->displacement();
      this->probes_[p].tolerance = this->softRandom_.chance(0.3) ? this->drawTolerance() : this->probes_[p].tolerance;
    }
  }
  const int added = this->random_.below(this->probes_.size() < 5 ? 4 : 1);
  for (int n = 0; n < added; ++n)
  {
    if (const std::optional<Probe> probe = this->drawProbe(now, rests))
    {
      this->probes_.push_back(*probe);
    }
  }
  if (this->random_.chance(0.2))
  {
    std::rotate(this->probes_.begin(), this->probes_.begin() + this->probes_.size() / 2, this->probes_.end());
  }
  add(Step::Hold).probes = this->probes_;

  // Interactive use: a few iterations of both again and again. Otherwise each runs to its end.
  if (this->random_.chance(0.3))
  {
    for (int n = this->random_.between(1, 4); n > 0; --n)
    {
      add(Step::Propagate).iterations = this->random_.between(1, 5);
      if (this->random_.chance(0.5))
      {
        add(Step::Relax).iterations = this->random_.between(1, 3);
      }
    }
  }
  if (this->random_.chance(0.85))
  {
    add(Step::Propagate).iterations = 0;
  }
  if (this->random_.chance(0.15))
  {
    steps.push_back(this->drawTopology());
  }
  for (int n = this->random_.below(3); n > 0; --n)
  {
    Step& step = add(Step::Relax);
    step.iterations = this->random_.chance(0.1) ? this->random_.between(20, 80) : this->random_.between(1, 6);
    step.number = this->random_.chance(0.5) ? 0.0 : this->random_.logarithmic(1e-6, 1e-2);
  }
  if (this->random_.chance(0.15))
  {
    add(Step::Resample).iterations = this->random_.below(3);
  }
  return steps;
}

/// Runs one sequence, then again, which must give the same bits, and once with another brick size.
void live(std::uint64_t seed, bool verbose)
{
  SCOPED_TRACE("CHAINMAIL_RANDOM_SEED=" + std::to_string(seed));
  Story story(seed);
  const Scene& scene = story.scene();
  std::vector<Step> steps;
  std::vector<Reading> readings;
  std::vector<Answer> answers;
  std::vector<char> brickless;
  {
    Simulation simulation = simulate(scene, story.brick());
    Watch watch(scene, read(simulation));
    for (int update = 0; update < 5; ++update)
    {
      for (const Step& step : story.next(watch.now()))
      {
        SCOPED_TRACE("step " + std::to_string(steps.size()) + ": " + text(step));
        if (verbose)
        {
          std::cout << "step " << steps.size() << ": " << text(step) << std::endl;
        }
        answers.push_back(apply(simulation, step));
        watch.check(step, answers.back(), simulation);
        if (testing::Test::HasFailure())
        {
          return;
        }
        steps.push_back(step);
        readings.push_back(watch.now());
        brickless.push_back(watch.brickless());
      }
    }
  }
  for (const bool other : { false, true })
  {
    SCOPED_TRACE(other ? "other bricks" : "once more");
    Simulation simulation = simulate(scene, other ? story.otherBrick() : story.brick());
    for (std::size_t n = 0; n < steps.size(); ++n)
    {
      SCOPED_TRACE("step " + std::to_string(n) + ": " + text(steps[n]));
      const Answer answer = apply(simulation, steps[n]);
      if (other && !brickless[n])
      {
        continue;
      }
      ASSERT_TRUE(same(read(simulation), readings[n]));
      EXPECT_EQ(answer.relaxed.iterations, answers[n].relaxed.iterations);
      EXPECT_EQ(answer.relaxed.largestMove, answers[n].relaxed.largestMove);
      ASSERT_EQ(answer.offsets.size(), answers[n].offsets.size());
      for (std::size_t o = 0; o < answer.offsets.size(); ++o)
      {
        ASSERT_TRUE(answer.offsets[o] == answers[n].offsets[o] ||
                    (std::isnan(answer.offsets[o]) && std::isnan(answers[n].offsets[o])));
      }
    }
  }
}

class RandomScenes : public testing::TestWithParam<int>
{
};

TEST_P(RandomScenes, KeepWhatIsPromised)
{
  if (const char* seed = std::getenv("CHAINMAIL_RANDOM_SEED"))
  {
    if (this->GetParam() == 0)
    {
      live(std::strtoull(seed, nullptr, 10), true);
    }
    return;
  }
  const char* number = std::getenv("CHAINMAIL_RANDOM_SCENES");
  const int scenes = number ? std::atoi(number) : CHAINMAIL_LONG ? 52 : 13;
  for (int n = 0; n < scenes && !HasFailure(); ++n)
  {
    live(static_cast<std::uint64_t>(this->GetParam()) * 1000000 + n, false);
  }
  for (const auto& [what, share] : Watch::worst())
  {
    std::cout << what << ": at most " << share << " of what is allowed\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Tenth, RandomScenes, testing::Range(0, 10));

}
