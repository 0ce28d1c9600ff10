// Probes in conflict with policy Share, against Dijkstra's algorithm in double precision.

#include "Scene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// The rounding error of sums along a path of these scenes, for displacements of this size [voxels]: by float32, and by
/// the margin of 7e-7 for it at each link. A path has at most about 40 links. Half of it was measured.
double rounding(double displacement)
{
  return 3e-5 * std::max(1.0, displacement);
}

/// Probes on random elements with random targets. Every third has a radius, and every seventh is an anchor.
std::vector<Probe> contradictingProbes(const Scene& scene, std::size_t count, double reach, std::uint64_t seed)
{
  Random random(seed);
  std::vector<Probe> probes;
  while (probes.size() < count)
  {
    Vector3 displacement;
    for (double& d : displacement)
    {
      d = random(-reach, reach);
    }
    Probe probe =
      probeAt(scene, randomElement(scene, random), displacement, probes.size() % 3 == 1 ? random(1.0, 2.5) : 0.0);
    probe.anchor = probes.size() % 7 == 6;
    probes.push_back(probe);
  }
  return probes;
}

Simulation sharing(const Scene& scene, const Index3& brick = { 0, 0, 0 })
{
  Simulation simulation = simulate(scene, brick);
  simulation.setPropagation(PropagationMethod::Envelope, ConflictPolicy::Share);
  return simulation;
}

void expectNear(const std::vector<oracle::Vector3>& found, const std::vector<oracle::Vector3>& expected, double reach)
{
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t v = 0; v < found.size(); ++v)
  {
    for (int a = 0; a < 3; ++a)
    {
      ASSERT_NEAR(found[v][a], expected[v][a], rounding(reach)) << "voxel " << v << " axis " << a;
    }
  }
}

TEST(Share, IsTheMeanOfBothExtensionsAtAllBrickSizes)
{
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    Scene scene = randomScene({ 21, 14, 17 }, seed % 2 == 0 ? 1 : 3, 9100 + seed);
    scene.anchors.faces[0] = scene.anchors.faces[3] = seed < 4;
    scene.anchors.rigid = seed == 1;
    const double reach = seed == 5 ? 40.0 : 4.0;
    std::vector<Probe> probes = contradictingProbes(scene, seed == 3 ? 1 : 12, reach, 9200 + seed);
    const oracle::Block block = scene.block();
    const auto expected =
      oracle::share(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes)).state;
    std::vector<float> first;
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = sharing(scene, brick);
      simulation.pull(probes);
      expectNear(state(simulation), expected, reach);
      EXPECT_LE(simulation.measure().maxLinkExcess, 2e-7 * reach);
      const std::vector<float> u = displacements(simulation);
      first = first.empty() ? u : first;
      EXPECT_TRUE(sameBits(u, first)) << "seed " << seed;
    }
  }
}

TEST(Share, DoesNotDependOnTheOrderOfProbes)
{
  Scene scene = randomScene({ 16, 16, 16 }, 1, 9300);
  scene.anchors.faces.fill(true);
  std::vector<Probe> probes;
  for (Probe& probe : contradictingProbes(scene, 20, 3.0, 9301))
  {
    probe.radius = 0.0; // an element has one holder, the first
    probes.push_back(probe);
  }
  Simulation one = sharing(scene);
  one.pull(probes);
  std::reverse(probes.begin(), probes.end());
  Simulation other = sharing(scene);
  other.pull(probes);
  EXPECT_TRUE(sameBits(displacements(one), displacements(other)));
}

TEST(Share, ProbesThatFitTogetherGetWhatTheyAskFor)
{
  const Scene scene = randomScene({ 18, 15, 16 }, 1, 9400);
  const std::vector<Probe> probes = compatibleProbes(scene, 8, 2.0, 9401, 2.0);
  Simulation limits = simulate(scene);
  limits.pull(probes);
  Simulation shares = sharing(scene);
  shares.hold(probes);
  EXPECT_EQ(shares.propagate(0).shared, 0u);
  EXPECT_TRUE(sameBits(displacements(shares), displacements(limits)));
}

// A state that is not at rest, with cuts, and with probes that hold their tissue while others are added.
TEST(Share, GoesOnFromWhereTissueIs)
{
  for (std::uint64_t seed = 0; seed < 4; ++seed)
  {
    Scene scene = randomScene({ 20, 13, 15 }, 1, 9500 + seed, 0.1, 0.05);
    scene.anchors.faces[0] = true;
    Simulation simulation = sharing(scene);
    Surface blade;
    blade.points = { { 9.5, -1.0, -1.0 }, { 9.5, 20.0, -1.0 }, { 9.5, -1.0, 9.0 } };
    blade.triangles = { { 0, 1, 2 } };
    simulation.cut(blade);
    const std::vector<Probe> first = contradictingProbes(scene, 4, 2.0, 9600 + seed);
    simulation.pull(first);
    simulation.relax(3, 0.0);
    const std::vector<oracle::Vector3> before = state(simulation);
    oracle::Block block = scene.block();
    takeLinks(block, links(simulation));
    for (const oracle::Handle& handle : handles(block, first))
    {
      for (const std::size_t v : handle.elements)
      {
        block.anchored[v] = 1; // for later probes
      }
    }
    std::vector<Probe> all = first;
    std::vector<oracle::Handle> others;
    std::vector<char> taken = block.anchored;
    Random random(9700 + seed);
    while (others.size() < 6)
    {
      const Index3 p = randomElement(scene, random);
      const std::size_t v = scene.grid.at(p[0], p[1], p[2]);
      if (taken[v])
      {
        continue;
      }
      taken[v] = 1;
      oracle::Handle handle;
      handle.elements = { v };
      Probe probe = probeAt(scene, p, {});
      for (int a = 0; a < 3; ++a)
      {
        probe.position[a] += before[v][a]; // the current place of the element
        handle.target[a] = random(-5.0, 5.0);
        probe.displacement[a] = handle.target[a];
      }
      others.push_back(handle);
      all.push_back(probe);
    }
    const auto results = simulation.pull(all);
    expectNear(state(simulation), oracle::share(block, before, others).state, 5.0);
    EXPECT_LE(simulation.measure().maxLinkExcess, 2e-6 * 10.0);
  }
}

// A request that nothing can follow does not reduce the accuracy of the others.
TEST(Share, WhatIsFarOutOfReachDoesNotBlurTheRest)
{
  Scene scene = randomScene({ 21, 14, 17 }, 1, 9750);
  scene.anchors.faces[0] = scene.anchors.faces[3] = true;
  std::vector<Probe> probes = contradictingProbes(scene, 12, 4.0, 9761);
  const oracle::Block block = scene.block();
  for (const double far : { 1e3, 1e6, 5e8 })
  {
    probes[4].displacement = { far, 0.7 * far, -far };
    Simulation simulation = sharing(scene);
    simulation.pull(probes);
    expectNear(state(simulation),
      oracle::share(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes)).state, 20.0);
  }
}

// Thousands of probes on a surface, with targets further apart than their links allow: a few waves with every policy.
TEST(Share, ManyThatDoNotFitTakeFewWaves)
{
  for (const ConflictPolicy policy : { ConflictPolicy::Limit, ConflictPolicy::Latest })
  {
    Scene scene({ 48, 48, 24 }, 0.35f);
    scene.anchors.faces.fill(true);
    Random random(9800);
    std::vector<Probe> probes;
    for (int j = 2; j < 46; ++j)
    {
      for (int i = 2; i < 46; ++i)
      {
        probes.push_back(
          probeAt(scene, { i, j, 12 }, { random(-1.1, 1.1), random(-1.1, 1.1), 3.0 + random(-1.1, 1.1) }));
      }
    }
    const oracle::Block block = scene.block();
    const auto expected =
      oracle::share(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes)).state;
    Simulation simulation = simulate(scene);
    simulation.setPropagation(PropagationMethod::Envelope, policy);
    int launches = 0;
    simulation.setProgress([&](double) { return ++launches > 0; });
    simulation.hold(probes);
    const PropagateResult result = simulation.propagate(0);
    EXPECT_TRUE(result.finished);
    EXPECT_GT(result.shared, probes.size() / 2);
    EXPECT_LE(result.shared, probes.size());
    EXPECT_LE(launches, 200) << "halves of halves take thousands";
    expectNear(state(simulation), expected, 4.0);
  }
}

// A twisted block: with rotations the paths have rest offsets.
TEST(Share, HoldsInRotatedTissue)
{
  Scene scene = randomScene({ 14, 12, 13 }, 1, 9900, 0.05, 0.05);
  scene.anchors.faces[4] = true;
  Settings settings;
  settings.device = testDevice();
  settings.rotations = true;
  Simulation simulation(scene.model(), settings);
  simulation.setPropagation(PropagationMethod::Envelope, ConflictPolicy::Share);
  for (int step = 1; step <= 4; ++step)
  {
    std::vector<Probe> probes = contradictingProbes(scene, 10, 1.5 * step, 9901);
    const auto results = simulation.pull(probes);
    simulation.relax(5, 0.0);
    const Statistics statistics = simulation.measure();
    EXPECT_TRUE(std::isfinite(statistics.energy));
    EXPECT_LE(statistics.maxLinkExcess, 1e-4) << "step " << step;
    EXPECT_GT(statistics.displaced, 0u);
  }
}

TEST(Share, NeedsEnvelopes)
{
  const Scene scene({ 4, 4, 4 });
  Simulation simulation = simulate(scene);
  const std::string message =
    messageOf<InputError>([&] { simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Share); });
  EXPECT_TRUE(contains(message, "Envelope")) << message;
}

}
