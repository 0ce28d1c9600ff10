// Random sequences of updates of random rotating tissue, with bones, joints, a Poisson's ratio, cuts, drags of all
// kinds, and all policies of conflict. Probes have rotations, are soft, or hold a whole body. After every update
// numbers are finite, links keep within their limits, relaxation has not raised the energy, and the number of launches
// is bounded.
//
// A failure names its seed. CHAINMAIL_RANDOM_SEED=<seed> runs this seed alone. CHAINMAIL_RANDOM_SECONDS=<seconds>
// continues with further seeds for this time.

#include "RotationScene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

namespace
{

using namespace chainmail;

constexpr double pi = 3.14159265358979323846;

/// Calls of the progress callback, which are between launches, in one update. The maximum over some thousand scenes is
/// 1500.
constexpr int mostCalls = 15000;

/// Rigid voxels of two labels, in bars through the tissue.
void addBones(Scene& scene, std::vector<std::int32_t>& labels, Random& random)
{
  const Index3& n = scene.grid.size;
  for (int bar = random.between(1, 4); bar > 0; --bar)
  {
    const int along = random.below(3);
    Index3 at{ random.below(n[0]), random.below(n[1]), random.below(n[2]) };
    const int label = random.between(1, 2);
    for (; at[along] < n[along] && !random.oneIn(10); ++at[along])
    {
      scene.give(at[0], at[1], at[2], 0.0f);
      labels[scene.grid.at(at[0], at[1], at[2])] = label;
    }
  }
}

float randomConstraint(int kind, int i, int j, int k, Random& random)
{
  switch (kind)
  {
  case 0:
    return static_cast<float>(random.logarithmic(1e-7, 0.98));
  case 1:
    return static_cast<float>(random(0.02, 0.6));
  case 2:
    return static_cast<float>(random(0.02, 0.25) + ((i / 4 + j / 4 + k / 4) % 2 ? 0.2 : 0.0));
  case 3:
    return 0.9f;
  default:
    return static_cast<float>(random(0.1, 0.35));
  }
}

/// The path of probes from update to update.
class Drag
{
public:
  Drag(const Scene& scene, Random& random)
    : grid_(scene.grid)
    , kind_(random.below(4))
    , axis_(random.below(3))
    , step_(random(2.0, 40.0) * random.of({ -1.0, 1.0 }) * pi / 180.0)
    , radius_(random(1.0, 12.0))
  {
  }

  void advance(std::vector<Probe>& probes, Random& random)
  {
    this->angle_ += this->step_;
    for (Probe& probe : probes)
    {
      if (probe.rotates)
      {
        for (int a = 0; a < 3; ++a)
        {
          probe.rotation[a] += random(-1.0, 1.0) * this->step_;
          probe.displacement[a] += random(-0.5, 0.5);
        }
        continue;
      }
      switch (this->kind_)
      {
      case 0: // all in the same circle
        probe.displacement = { this->radius_ * std::sin(this->angle_), this->radius_ * (1.0 - std::cos(this->angle_)),
          0.0 };
        break;
      case 1: // a random walk
        for (double& part : probe.displacement)
        {
          part += random(-0.5, 0.5);
        }
        break;
      case 2: // far beyond the limits of tissue
        for (double& part : probe.displacement)
        {
          part = random(-100.0, 100.0);
        }
        break;
      default: // around the middle
        this->rotate(probe);
      }
    }
  }

private:
  void rotate(Probe& probe) const
  {
    const int b = (this->axis_ + 1) % 3, c = (this->axis_ + 2) % 3;
    const double y = probe.position[b] - this->grid_.size[b] / 2 * this->grid_.spacing[b];
    const double z = probe.position[c] - this->grid_.size[c] / 2 * this->grid_.spacing[c];
    const double sine = std::sin(this->angle_), cosine = std::cos(this->angle_);
    probe.displacement = {};
    probe.displacement[b] = y * cosine - z * sine - y;
    probe.displacement[c] = y * sine + z * cosine - z;
  }

  Grid grid_;
  int kind_;
  int axis_;
  double step_;
  double radius_;
  double angle_ = 0.0;
};

Surface randomBlade(const Scene& scene, Random& random)
{
  const double x = random(0.0, scene.grid.size[0]) * scene.grid.spacing[0];
  const double deep = random(0.0, scene.grid.size[2]) * scene.grid.spacing[2];
  Surface blade;
  blade.points = { { x, -50.0, -50.0 }, { x + 0.1, 50.0, -50.0 }, { x, -50.0, deep }, { x + 0.1, 50.0, deep } };
  blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
  return blade;
}

/// Makes a probe hold all voxels of a label, bone or not.
void holdBody(Probe& probe, int label, const std::vector<std::int32_t>& labels)
{
  std::vector<std::size_t> voxels;
  for (std::size_t n = 0; n < labels.size(); ++n)
  {
    if (labels[n] == label)
    {
      voxels.push_back(n);
    }
  }
  probe.voxels = std::make_shared<const std::vector<std::size_t>>(std::move(voxels));
  probe.body = static_cast<std::uint64_t>(label);
}

void changeProbes(
  std::vector<Probe>& probes, const Scene& scene, const std::vector<std::int32_t>& labels, Random& random)
{
  if (probes.empty() || (probes.size() < 5 && random.oneIn(6)))
  {
    probes.push_back(probeAt(scene, randomElement(scene, random), {}, random.oneIn(2) ? 0.0 : random(0.5, 3.0)));
    Probe& probe = probes.back();
    probe.anchor = random.oneIn(6);
    probe.rotates = random.oneIn(3);
    probe.tolerance = random.oneIn(5) ? random.logarithmic(1e-2, 10.0) : 0.0;
    for (int a = 0; a < 3; ++a)
    {
      probe.centre[a] = probe.position[a] + random(-2.0, 2.0);
    }
    if (random.oneIn(3))
    {
      holdBody(probe, random.between(1, 2), labels);
    }
  }
  else if (random.oneIn(12))
  {
    probes.erase(probes.begin() + random.below(static_cast<int>(probes.size())));
  }
}

/// The excess after an update: probes count as compatible up to 2e-6 of the largest displacement, and displacements are
/// rounded to 1.2e-7 of it. Several links may have some of either.
void expectInOrder(const Simulation& simulation, double energyBefore)
{
  const Vector3& spacing = simulation.model().grid().spacing;
  const double shortest = *std::min_element(spacing.begin(), spacing.end());
  double largest = 1.0;
  for (const float part : displacements(simulation))
  {
    ASSERT_TRUE(std::isfinite(part));
    largest = std::max(largest, std::fabs(part) / shortest);
  }
  const Statistics now = simulation.measure();
  ASSERT_TRUE(std::isfinite(now.energy));
  EXPECT_LE(now.maxLinkExcess, 1e-5 * largest);
  EXPECT_LE(now.energy, energyBefore * (1.0 + 1e-4) + 1e-6 * largest * largest);
}

void live(std::uint64_t seed)
{
  SCOPED_TRACE("CHAINMAIL_RANDOM_SEED=" + std::to_string(seed));
  Random random(seed);
  Scene scene({ random.between(1, 16), random.between(2, 16), random.between(2, 16) });
  scene.grid.spacing = { random(0.4, 2.5), random(0.4, 2.5), random(0.4, 2.5) };
  std::vector<std::int32_t> labels(scene.grid.voxels(), 0);
  const int kind = random.below(5);
  const double rigid = random.oneIn(2) ? 0.0 : random(0.0, 0.3);
  scene.each(
    [&](int i, int j, int k)
    {
      const float constraint = randomConstraint(kind, i, j, k, random);
      scene.give(i, j, k, random.chance(rigid) ? 0.0f : constraint);
      if (random.chance(0.03))
      {
        scene.air(i, j, k);
      }
    });
  if (random.oneIn(2))
  {
    addBones(scene, labels, random);
  }
  for (bool& face : scene.anchors.faces)
  {
    face = random.oneIn(5);
  }
  if (std::none_of(scene.scalar.begin(), scene.scalar.end(), [](float value) { return value != 0.0f; }))
  {
    return;
  }
  Joints joints;
  if (random.oneIn(3))
  {
    joints.labels.data = labels.data();
    joints.labels.type = ArrayView::Type::Int32;
    joints.size = random.of({ 0, 2 });
    joints.constraint = random.of({ 0.5, 1.0 });
    joints.margin = random.between(1, 4);
  }
  Settings settings;
  settings.device = testDevice();
  settings.rotations = true;
  settings.poissonRatio = random.oneIn(2) ? 0.0 : random(0.0, 0.49);
  settings.modelReduction = !joints.wanted() && random.oneIn(8) ? 2 : 1;
  Simulation simulation(scene.model(joints), settings);
  simulation.setCoarseToFine(random.oneIn(2));
  simulation.setPropagation(PropagationMethod::Envelope,
    random.of({ ConflictPolicy::Limit, ConflictPolicy::Limit, ConflictPolicy::Latest, ConflictPolicy::Share }));
  int calls = 0;
  simulation.setProgress([&](double) { return ++calls < mostCalls; });

  Drag drag(scene, random);
  std::vector<Probe> probes;
  for (int update = random.between(6, 30); update > 0; --update)
  {
    changeProbes(probes, scene, labels, random);
    drag.advance(probes, random);
    if (random.oneIn(15))
    {
      simulation.cut(randomBlade(scene, random));
    }
    calls = 0;
    try
    {
      simulation.pull(probes);
    }
    catch (const ProbeError&)
    {
      probes.clear(); // for example two probes at one place
      continue;
    }
    const double energy = simulation.measure().energy;
    simulation.relax(random.between(1, 60), random.of({ 0.0, 1e-3 }));
    expectInOrder(simulation, energy);
    for (std::size_t n = 0; n < probes.size(); ++n)
    {
      simulation.limiter(n);
    }
    if (testing::Test::HasFailure())
    {
      return;
    }
  }
}

std::optional<double> numberFrom(const char* variable)
{
  const char* text = std::getenv(variable);
  return text ? std::optional<double>(std::atof(text)) : std::nullopt;
}

TEST(RandomRotations, EveryUpdateEndsInOrder)
{
  if (const std::optional<double> seed = numberFrom("CHAINMAIL_RANDOM_SEED"))
  {
    live(static_cast<std::uint64_t>(*seed));
    return;
  }
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const double seconds = numberFrom("CHAINMAIL_RANDOM_SECONDS").value_or(0.0);
  const std::uint64_t fewest = CHAINMAIL_LONG ? 300 : 30;
  std::uint64_t seed = 1;
  for (; !HasFailure() && (seed <= fewest || std::chrono::duration<double>(Clock::now() - begin).count() < seconds);
       ++seed)
  {
    ASSERT_NO_THROW(live(seed)) << seed;
  }
  RecordProperty("scenes", static_cast<int>(seed - 1));
}

/// Twelve voxels with contradicting rotations: the engine stops the computation of bounds without an end after its
/// maximum of passes, which is larger than the number of voxels.
TEST(RandomRotations, TissueOfFewVoxelsMayHaveBoundsWithoutAnEnd)
{
  live(1800);
}

}
