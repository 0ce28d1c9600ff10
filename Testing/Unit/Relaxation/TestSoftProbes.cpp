// Soft probes, whose targets are not met exactly: against the certified optimum in double precision, and invariants.

#include "Blades.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// Adds the soft links of probes that grabbed at rest to the block.
void soften(oracle::Block& block, const std::vector<Probe>& probes)
{
  for (const Probe& probe : probes)
  {
    for (const std::size_t voxel : oracle::grab(block, probe.position, probe.radius))
    {
      if (probe.tolerance > 0.0)
      {
        oracle::Soft soft;
        soft.voxel = voxel;
        soft.tolerance = probe.tolerance;
        for (int a = 0; a < 3 && !probe.anchor; ++a)
        {
          soft.target[a] = probe.displacement[a] / block.spacing[a];
        }
        block.soft.push_back(soft);
      }
    }
  }
}

/// Soft probes on random elements. Some grip balls, and so the tissue of others.
std::vector<Probe> softProbes(const Scene& scene, int count, double reach, std::uint64_t seed)
{
  Random random(seed);
  std::vector<Probe> probes;
  for (int n = 0; n < count; ++n)
  {
    Probe probe = probeAt(scene, randomElement(scene, random),
      { random(-reach, reach), random(-reach, reach), random(-reach, reach) },
      n % 3 == 1 ? 1.3 + 0.1 * static_cast<double>(n) : 0.0);
    probe.tolerance = std::pow(10.0, random(-1.5, 0.5));
    probe.anchor = n % 5 == 4;
    probes.push_back(probe);
  }
  return probes;
}

/// Soft and hard probes, and the optimum of the tissue under them.
struct Case
{
  Scene scene;
  std::vector<Probe> probes;
  oracle::Optimum best;

  Case(Scene given, std::vector<Probe> all)
    : scene(std::move(given))
    , probes(std::move(all))
  {
    oracle::Block block = this->scene.block();
    soften(block, this->probes);
    std::vector<Probe> hard = this->probes;
    hard.erase(std::remove_if(hard.begin(), hard.end(), [](const Probe& probe) { return probe.isSoft(); }), hard.end());
    std::vector<oracle::Vector3> start(block.count());
    std::vector<char> held = block.anchored;
    if (!hard.empty())
    {
      const auto all = handles(block, hard);
      start = oracle::propagate(block, start, all).state;
      for (const oracle::Handle& handle : all)
      {
        for (const std::size_t voxel : handle.elements)
        {
          held[voxel] = 1;
        }
      }
    }
    this->best = oracle::minimise(block, held, start, 3e-6);
  }
};

/// Relaxes to convergence in several calls, and checks that the energy falls and links keep within their limits.
/// `budget`: most sweeps.
void settle(Simulation& simulation, int budget = 3000)
{
  double last = simulation.measure().energy;
  for (int done = 0; done < budget;)
  {
    const RelaxResult result = simulation.relax(done == 0 ? 20 : 250, 1e-7);
    done += std::max(1, result.iterations);
    const Statistics now = simulation.measure();
    EXPECT_LE(now.energy, last * (1.0 + 2e-6)) << "after " << done;
    EXPECT_LE(now.maxLinkExcess, 2e-6) << "after " << done;
    last = now.energy;
    if (result.converged)
    {
      return;
    }
  }
}

/// A block anchored on one side, with soft probes whose targets are within the limits of the links, or far beyond.
Case makeCase(int number)
{
  const bool far = number % 2 == 1;
  Scene scene = randomScene({ 11, 10, 9 }, number == 2 || number == 3 ? 3 : 1, 700 + static_cast<std::uint64_t>(number),
    0.1, number == 4 ? 0.0 : 0.08);
  scene.anchors.faces[0] = true;
  if (number >= 2)
  {
    scene.grid.spacing = { 0.5, 1.25, 2.0 };
  }
  std::vector<Probe> probes = softProbes(scene, 9, far ? 9.0 : 0.4, 800 + static_cast<std::uint64_t>(number));
  if (number == 4 || number == 5)
  {
    std::vector<Probe> hard = compatibleProbes(scene, 2, 0.4, 900);
    probes.insert(probes.begin() + 3, hard.begin(), hard.end());
  }
  return Case(std::move(scene), std::move(probes));
}

/// The energy above the optimum that remains where links at their limits block each other: measured 2.2 % on one grid
/// and 0.4 % after coarser ones. Elsewhere only rounding remains.
double allowed(bool far, bool coarse)
{
  return !far ? 1e-5 : coarse ? 0.01 : 0.04;
}

TEST(SoftProbes, ReachTheProvenOptimum)
{
  for (int number = 0; number < 6; ++number)
  {
    SCOPED_TRACE(testing::Message() << "case " << number);
    const Case made = makeCase(number);
    ASSERT_LT(made.best.gap(), 1e-4);
    for (const bool coarse : { false, true })
    {
      SCOPED_TRACE(coarse ? "with coarser grids" : "one grid");
      Simulation simulation = simulate(made.scene);
      simulation.setCoarseToFine(coarse);
      simulation.pull(made.probes);
      EXPECT_GT(simulation.measure().energy, 1.05 * made.best.energy) << "nothing to relax: a poor test";
      settle(simulation);
      const double energy = simulation.measure().energy;
      EXPECT_GE(energy, made.best.bound * (1.0 - 2e-6));
      EXPECT_LE(energy, made.best.energy * (1.0 + allowed(number % 2 == 1, coarse)));
      if (number % 2 == 0)
      {
        EXPECT_LT(largestDifference(made.scene.block(), state(simulation), made.best.state), 2e-4);
      }
    }
  }
}

// Coarser grids have soft probes, too: a few sweeps after them reduce the energy like hundreds without.
TEST(SoftProbes, CoarserGridsGetThereInFewSweeps)
{
  Scene scene = randomScene({ 40, 34, 30 }, 1, 750, 0.05, 0.05);
  scene.anchors.faces[4] = true;
  const std::vector<Probe> probes = softProbes(scene, 12, 1.5, 751);
  double energies[3];
  int n = 0;
  for (const auto& [coarse, sweeps] : { std::pair(true, 20), std::pair(false, 20), std::pair(false, 1500) })
  {
    Simulation simulation = simulate(scene);
    simulation.setCoarseToFine(coarse);
    simulation.hold(probes);
    const RelaxResult result = simulation.relax(sweeps, 0.0);
    if (coarse)
    {
      EXPECT_GT(result.coarseStep.value_or(0.0), 0.0);
    }
    energies[n++] = simulation.measure().energy;
  }
  EXPECT_LT(energies[0], 1.02 * energies[2]);
  EXPECT_LT(energies[0], energies[1]);
}

/// Runs f(simulation) after hold() at all brick sizes, and expects the same bits.
template <typename F> void expectSameBits(const Scene& scene, bool rotations, const std::vector<Probe>& probes, F&& f)
{
  std::vector<float> first;
  std::vector<ProbeResult> firstResults;
  for (const Index3& brick : brickSizes())
  {
    Settings settings;
    settings.device = testDevice();
    settings.brickSize = brick;
    settings.rotations = rotations;
    Simulation simulation(scene.model(), settings);
    simulation.pull(probes);
    f(simulation);
    const std::vector<float> u = displacements(simulation);
    const std::vector<ProbeResult> results = simulation.probes();
    firstResults = first.empty() ? results : firstResults;
    first = first.empty() ? u : first;
    EXPECT_TRUE(std::any_of(u.begin(), u.end(), [](float value) { return value != 0.0f; }));
    EXPECT_TRUE(sameBits(u, first));
    for (std::size_t n = 0; n < results.size(); ++n)
    {
      EXPECT_EQ(results[n].reached, firstResults[n].reached);
      EXPECT_EQ(results[n].force, firstResults[n].force);
    }
  }
}

TEST(SoftProbes, BitsDoNotDependOnBricks)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 21, 14, 17 }, axes, 760, 0.1, 0.15);
    scene.anchors.faces[1] = true;
    scene.grid.spacing = { 0.7, 1.0, 1.6 };
    std::vector<Probe> probes = softProbes(scene, 10, 3.0, 761);
    const std::vector<Probe> hard = compatibleProbes(scene, 2, 0.5, 762);
    probes.insert(probes.end(), hard.begin(), hard.end());
    for (const bool rotations : { false, true })
    {
      SCOPED_TRACE(testing::Message() << axes << " axes, " << (rotations ? "with" : "without") << " rotations");
      expectSameBits(scene, rotations, probes, [](Simulation& simulation) { simulation.relax(70, 1e-4); });
    }
  }
}

// The forces of soft probes balance those of all links on tissue at rest, and each pulls towards its target.
TEST(SoftProbes, ForcesAreInBalance)
{
  for (const int number : { 2, 4 })
  {
    const Case made = makeCase(number);
    Simulation simulation = simulate(made.scene);
    simulation.pull(made.probes);
    settle(simulation);
    const std::vector<ProbeResult> results = simulation.probes();
    const std::vector<oracle::Vector3> u = state(simulation);
    const oracle::Block block = made.scene.block();
    for (std::size_t n = 0; n < made.probes.size(); ++n)
    {
      const Probe& probe = made.probes[n];
      if (!probe.isSoft())
      {
        continue;
      }
      const std::vector<std::size_t> grip = oracle::grab(block, probe.position, probe.radius);
      ASSERT_EQ(results[n].elements, grip.size());
      for (int a = 0; a < 3; ++a)
      {
        double mean = 0.0;
        for (const std::size_t voxel : grip)
        {
          mean += u[voxel][a] * block.spacing[a] / static_cast<double>(grip.size());
        }
        const double target = probe.anchor ? 0.0 : probe.displacement[a];
        EXPECT_NEAR(results[n].reached[a], mean, 1e-6);
        const double force = 2.0 * (target - mean) * static_cast<double>(grip.size()) / probe.tolerance;
        EXPECT_NEAR(results[n].force[a], force, 1e-4 * std::max(1.0, std::fabs(force)));
      }
    }
  }
}

// --- Holding, moving and releasing

/// A block anchored below, and a soft probe on its top.
Scene blockScene()
{
  Scene scene({ 9, 9, 9 }, 0.4f);
  scene.anchors.faces[4] = true;
  return scene;
}

Probe onTop(const Scene& scene, double tolerance)
{
  Probe probe = probeAt(scene, { 4, 4, 8 }, { 0.3, 0.0, 0.5 });
  probe.tolerance = tolerance;
  return probe;
}

TEST(SoftProbes, MoveNothingWithoutARelaxation)
{
  const Scene scene = blockScene();
  Simulation simulation = simulate(scene);
  simulation.hold({ onTop(scene, 0.1) });
  const PropagateResult propagated = simulation.propagate();
  EXPECT_TRUE(propagated.finished);
  EXPECT_EQ(propagated.iterations, 0);
  EXPECT_EQ(simulation.measure().displaced, 0u);
  EXPECT_NEAR(simulation.measure().energy, (0.09 + 0.25) / 0.1, 1e-6);
  EXPECT_EQ(simulation.limiter(0).what, Limiter::What::Nothing);
  simulation.relax(0, 0.0);
  EXPECT_EQ(simulation.measure().displaced, 0u);
  simulation.relax(1, 0.0);
  EXPECT_GT(simulation.measure().displaced, 0u);
}

// The smaller the tolerance, the nearer the tissue is to the target. With a tolerance near 0 the result is that of a
// hard probe.
TEST(SoftProbes, ComeNearerTheLessTheirTolerance)
{
  const Scene scene = blockScene();
  double last = 0.0;
  for (const double tolerance : { 100.0, 1.0, 0.1, 0.01, 1e-4, 1e-12 })
  {
    Simulation simulation = simulate(scene);
    simulation.hold({ onTop(scene, tolerance) });
    settle(simulation);
    const double reached = simulation.probes()[0].reached[2];
    EXPECT_GT(reached, last) << tolerance;
    last = reached;
  }
  EXPECT_NEAR(last, 0.5, 1e-5);
  Simulation hard = simulate(scene);
  hard.pull({ onTop(scene, 0.0) });
  settle(hard);
  Simulation soft = simulate(scene);
  soft.hold({ onTop(scene, 1e-4) });
  settle(soft);
  // A force of 7 displaces by 7 / 2 tolerances.
  EXPECT_LT(largestDifference(scene.block(), state(hard), state(soft)), 4e-4);
  for (int a = 0; a < 3; ++a)
  {
    const double force = hard.probes()[0].force[a];
    EXPECT_NEAR(soft.probes()[0].force[a], force, 1e-3 * std::fabs(force) + 1e-3);
  }
}

// Probes that become soft, become hard, change or go keep the tissue that they gripped.
TEST(SoftProbes, StayTheSameProbes)
{
  const Scene scene = blockScene();
  Simulation simulation = simulate(scene);
  Probe probe = onTop(scene, 0.0);
  probe.radius = 1.2;
  simulation.pull({ probe });
  simulation.relax(100, 1e-6);
  EXPECT_NEAR(simulation.probes()[0].reached[2], 0.5, 1e-6);
  const double stiff = simulation.measure().energy;

  probe.tolerance = 0.5; // releases the tissue, except for the soft links
  simulation.pull({ probe });
  EXPECT_NEAR(simulation.probes()[0].reached[2], 0.5, 1e-6) << "nothing has moved yet";
  EXPECT_NEAR(simulation.measure().energy, stiff, 1e-4 * stiff);
  settle(simulation);
  const double soft = simulation.probes()[0].reached[2];
  EXPECT_GT(soft, 0.1);
  EXPECT_LT(soft, 0.48);

  probe.tolerance = 0.2; // a change continues from the current state
  simulation.hold({ probe });
  settle(simulation);
  EXPECT_GT(simulation.probes()[0].reached[2], soft + 0.01);

  probe.displacement[2] = -0.5;
  simulation.hold({ probe });
  settle(simulation);
  EXPECT_LT(simulation.probes()[0].reached[2], -0.1);

  probe.tolerance = 0.0; // relative to the place where it first grabbed
  probe.displacement[2] = 0.25;
  simulation.pull({ probe });
  EXPECT_NEAR(simulation.probes()[0].reached[2], 0.25, 1e-6);
  simulation.relax(100, 1e-6);
  EXPECT_NEAR(simulation.probes()[0].reached[2], 0.25, 1e-6) << "it is held";

  probe.tolerance = 0.5;
  simulation.pull({ probe });
  simulation.hold({});
  settle(simulation);
  EXPECT_LT(simulation.measure().energy, 1e-6);

  simulation.hold({ probe });
  settle(simulation);
  EXPECT_GT(simulation.measure().energy, 0.1);
  simulation.reset();
  EXPECT_EQ(simulation.measure().energy, 0.0);
  simulation.relax(10, 0.0);
  EXPECT_EQ(simulation.measure().displaced, 0u);
  EXPECT_TRUE(simulation.probes().empty());
}

// Tissue that a hard probe holds and soft probes grip moves with the hard probe.
TEST(SoftProbes, GripWhatOthersHold)
{
  const Scene scene = blockScene();
  Probe hard = onTop(scene, 0.0);
  Probe soft = onTop(scene, 0.1);
  soft.position[0] += 0.01; // another probe
  soft.displacement = { 0.0, 0.0, -2.0 };
  std::vector<float> first;
  for (const auto& probes : { std::vector<Probe>{ soft, hard }, std::vector<Probe>{ hard, soft } })
  {
    const std::size_t isHard = probes[0].isSoft() ? 1 : 0;
    Simulation simulation = simulate(scene);
    simulation.pull(probes);
    settle(simulation);
    for (std::size_t n = 0; n < 2; ++n)
    {
      EXPECT_EQ(simulation.probes()[n].elements, 1u);
      EXPECT_NEAR(simulation.probes()[n].reached[2], 0.5, 1e-6);
    }
    // The hard probe pulls against the tissue and against the soft probe.
    Simulation alone = simulate(scene);
    alone.pull({ hard });
    settle(alone);
    EXPECT_TRUE(sameBits(displacements(alone), displacements(simulation)));
    EXPECT_NEAR(simulation.probes()[isHard].force[2], alone.probes()[0].force[2] + 2.0 * (0.5 + 2.0) / 0.1, 1e-3);
    EXPECT_NEAR(simulation.measure().energy, alone.measure().energy + (2.5 * 2.5 + 0.3 * 0.3) / 0.1, 1e-3);
    EXPECT_EQ(simulation.bodies().size(), 0u);
    simulation.hold({ soft }); // the soft probe remains
    settle(simulation);
    EXPECT_LT(simulation.probes()[0].reached[2], -0.2);
  }
}

// Several soft probes on one element act like one with the sum of their weights and the weighted mean of their targets.
TEST(SoftProbes, AddUpOnOneElement)
{
  const Scene scene = blockScene();
  Probe one = onTop(scene, 0.2);
  Probe other = onTop(scene, 0.05);
  other.position[1] += 0.01;
  other.displacement = { -0.4, 0.2, 0.1 };
  Probe both = onTop(scene, 0.04);
  for (int a = 0; a < 3; ++a)
  {
    both.displacement[a] = 0.2 * one.displacement[a] + 0.8 * other.displacement[a];
  }
  Simulation two = simulate(scene);
  two.hold({ one, other });
  Simulation mean = simulate(scene);
  mean.hold({ both });
  double square = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    square += std::pow(one.displacement[a] - other.displacement[a], 2);
  }
  const double least = square / 0.25; // w v / (w + v) of weights 5 and 20
  EXPECT_NEAR(two.measure().energy, mean.measure().energy + least, 1e-5);
  settle(two);
  settle(mean);
  EXPECT_LT(largestDifference(scene.block(), state(two), state(mean)), 1e-5);
  EXPECT_NEAR(two.measure().energy, mean.measure().energy + least, 1e-5);
}

TEST(SoftProbes, LoseCarvedTissue)
{
  const Scene scene = blockScene();
  Probe probe = onTop(scene, 0.1);
  probe.radius = 1.2;
  Simulation simulation = simulate(scene);
  simulation.hold({ probe });
  settle(simulation);
  EXPECT_EQ(simulation.probes()[0].elements, 6u);
  simulation.carve(sphere({ 5.2, 4.0, 8.4 }, 0.6, 12, 16));
  EXPECT_EQ(simulation.probes()[0].elements, 5u);
  settle(simulation);
  EXPECT_GT(simulation.probes()[0].reached[2], 0.2);
  simulation.carve(sphere({ 4.0, 4.0, 8.0 }, 3.0, 12, 16));
  EXPECT_EQ(simulation.probes()[0].elements, 0u);
  settle(simulation);
  EXPECT_LT(simulation.measure().energy, 1e-6);
}

TEST(SoftProbes, BadTolerancesAreRefused)
{
  const Scene scene = blockScene();
  Simulation simulation = simulate(scene);
  simulation.hold({ onTop(scene, 0.1) });
  const double before = simulation.measure().energy;
  for (const double tolerance : { -1.0, std::nan(""), std::numeric_limits<double>::infinity() })
  {
    const std::string message = messageOf<ProbeError>(
      [&] {
        simulation.hold({ onTop(scene, 0.1), onTop(scene, tolerance) });
      });
    EXPECT_TRUE(contains(message, "tolerance")) << message;
    EXPECT_EQ(simulation.measure().energy, before);
  }
}

// Also with the published relaxation, which ignores limits: no link reaches its limit here.
TEST(SoftProbes, PullWithThePublishedRelaxation)
{
  Probe probe = onTop(blockScene(), 0.1);
  probe.radius = 1.2;
  const Case made(blockScene(), { probe });
  Simulation simulation = simulate(made.scene);
  simulation.setRelaxation(RelaxationMethod::Paper, 1.0);
  simulation.hold(made.probes);
  simulation.relax(4000, 1e-7);
  EXPECT_NEAR(simulation.measure().energy, made.best.energy, 1e-5 * made.best.energy);
}

// A slice: on coarser grids a link stands for links side by side in two directions, not three.
TEST(SoftProbes, HoldInASlice)
{
  Scene scene({ 48, 48, 1 }, 0.35f);
  scene.anchors.faces[0] = true;
  Probe probe = probeAt(scene, { 40, 24, 0 }, { 1.0, 0.5, 0.0 }, 3.2);
  probe.tolerance = 0.5;
  double energies[2];
  for (const bool coarse : { true, false })
  {
    Simulation simulation = simulate(scene);
    simulation.setCoarseToFine(coarse);
    simulation.hold({ probe });
    simulation.relax(coarse ? 20 : 3000, 0.0);
    energies[coarse ? 0 : 1] = simulation.measure().energy;
  }
  EXPECT_LT(energies[0], 1.02 * energies[1]);
  EXPECT_GT(energies[0], energies[1] * (1.0 - 1e-5));
}

}
