// Propagation against Dijkstra's algorithm and formula (P*) of the project's mathematics, exact up to float rounding.

#include "Scene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

// A path of some fifty links of 0.3 in float32 rounds to about 50 * 1e-7. A wrong link limit would differ by more than
// 1e-2.
constexpr double tolerance = 1e-5; // fractions of the spacing

// The engine computes the largest displacement of an incompatible probe from the overshoot of its wave. So its error is
// the rounding of float32 sums along the wave, relative to the requested displacement.
constexpr double overshootTolerance = 3e-6; // relative to the requested displacement

/// Probes on displaced tissue with the targets of probes for the tissue at rest.
std::vector<Probe> inDeformedTissue(
  const oracle::Block& block, const std::vector<oracle::Vector3>& now, std::vector<Probe> probes)
{
  const auto handle = handles(block, probes);
  for (std::size_t p = 0; p < probes.size(); ++p)
  {
    for (int a = 0; a < 3 && !handle[p].elements.empty(); ++a)
    {
      const double u = now[handle[p].elements.front()][a] * block.spacing[a];
      probes[p].position[a] += u;
      probes[p].displacement[a] -= u;
    }
  }
  return probes;
}

/// Pulls, and compares the state, the probes' results and the figures with the oracle, from the state `before` on.
void expectFormula(Simulation& simulation, const oracle::Block& block, const std::vector<Probe>& probes,
  const char* what, double near = tolerance)
{
  SCOPED_TRACE(what);
  const std::vector<oracle::Vector3> before = state(simulation);
  const auto handle = handles(block, probes);
  const oracle::Propagated expected = oracle::propagate(block, before, handle);
  const std::vector<ProbeResult> results = simulation.pull(inDeformedTissue(block, before, probes));
  const std::vector<oracle::Vector3> got = state(simulation);
  EXPECT_LT(largestDifference(block, got, expected.state), near);
  EXPECT_LT(oracle::maxLinkExcess(block, got), tolerance);
  const Statistics statistics = simulation.measure();
  EXPECT_LE(statistics.maxLinkExcess, tolerance);
  EXPECT_NEAR(statistics.energy, oracle::energy(block, got), 1e-4 * oracle::energy(block, got) + 1e-12);
  ASSERT_EQ(results.size(), probes.size());
  std::size_t displaced = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    displaced += block.tissue[v] && (got[v][0] != 0.0 || got[v][1] != 0.0 || got[v][2] != 0.0);
  }
  EXPECT_EQ(statistics.displaced, displaced);
  for (std::size_t p = 0; p < probes.size(); ++p)
  {
    EXPECT_EQ(results[p].elements, handle[p].elements.size()) << "probe " << p;
    for (int a = 0; a < 3; ++a)
    {
      const double h = block.spacing[a];
      if (!handle[p].elements.empty())
      {
        const double grabbed = before[handle[p].elements.front()][a];
        EXPECT_NEAR(results[p].reached[a], (expected.reached[p][a] - grabbed) * h, near * h)
          << "probe " << p << " axis " << a;
      }
    }
  }
}

// Fig. 4: three elements, links 1.5 and 3: times 0, 1.5, 4.5.
TEST(Propagate, Figure4OfThePaper)
{
  Scene scene({ 3, 1, 1 });
  scene.grid.spacing = { 10.0, 10.0, 10.0 };
  scene.constraint = { 0.1f, 0.2f, 0.4f };
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 10.0, -10.0, 4.0 }) });
  const std::vector<float> u = displacements(simulation);
  // Displacement = pull minus time, in mm. Where the time is longer than the pull the wave does not arrive.
  const float expected[] = { 10.0f, -10.0f, 4.0f, 8.5f, -8.5f, 2.5f, 5.5f, -5.5f, 0.0f };
  for (int n = 0; n < 9; ++n)
  {
    EXPECT_NEAR(u[n], expected[n], 1e-5) << n; // 1e-6 of the spacing
  }
  EXPECT_EQ(u[8], 0.0f);
}

// Fig. 5: a ring, elastic on top, rigid at the sides and the bottom. The top left element is moved; the bottom right
// must follow the rigid branch, and so must the top right, against the elastic one.
TEST(Propagate, Figure5OfThePaper)
{
  const int n = 6;
  Scene scene({ n, n, 1 }, 0.0f);
  scene.each(
    [&](int i, int j, int)
    {
      if (i > 0 && i < n - 1 && j > 0 && j < n - 1)
      {
        scene.air(i, j, 0);
      }
      if (i > 0 && i < n - 1 && j == n - 1)
      {
        scene.give(i, j, 0, 0.4f);
      }
    });
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    simulation.pull({ probeAt(scene, { 0, n - 1, 0 }, { 3.0, -2.0, 0.0 }) });
    const std::vector<float> u = displacements(simulation);
    const auto at = [&](int i, int j, int a) { return u[3 * scene.grid.at(i, j, 0) + a]; };
    scene.each(
      [&](int i, int j, int)
      {
        if (scene.tissue(scene.grid.at(i, j, 0)) && (j < n - 1 || i == 0 || i == n - 1))
        {
          EXPECT_EQ(at(i, j, 0), 3.0f) << i << ' ' << j; // rigid: exactly the same displacement
          EXPECT_EQ(at(i, j, 1), -2.0f) << i << ' ' << j;
        }
      });
    // On the elastic side the waves from both ends leave the limits: links of 0.2, 0.4, 0.4 to the middle.
    EXPECT_NEAR(at(1, n - 1, 0), 2.8, 1e-6);
    EXPECT_NEAR(at(2, n - 1, 0), 2.4, 1e-6);
    EXPECT_NEAR(at(3, n - 1, 0), 2.4, 1e-6);
    EXPECT_NEAR(at(4, n - 1, 1), -1.8, 1e-6);
  }
}

TEST(Propagate, OneProbeInRandomTissueIsTheFormula)
{
  for (int seed = 0; seed < 6; ++seed)
  {
    const int axes = seed % 2 == 0 ? 1 : 3;
    Scene scene = randomScene({ 23, 17, 14 }, axes, 100 + seed);
    scene.grid.spacing = { 0.7, 1.3, 2.9 };
    scene.anchors.faces[seed] = seed > 1;
    scene.anchors.rigid = false;
    const oracle::Block block = scene.block();
    Random random(seed);
    Index3 p = randomElement(scene, random);
    while (block.anchored[scene.grid.at(p[0], p[1], p[2])])
    {
      p = randomElement(scene, random);
    }
    Simulation simulation = simulate(scene);
    // Mixed signs. On one axis the pull is so small that the wave stops after a few links.
    expectFormula(simulation, block, { probeAt(scene, p, { 2.1, -3.9, 1.5 }) }, "from rest");
    EXPECT_GT(simulation.measure().displaced, 0u);
  }
}

TEST(Propagate, FiveCompatibleProbesAtOnceAreTheFormula)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 25, 22, 19 }, axes, 40 + axes);
    scene.grid.spacing = { 0.5, 0.5, 1.25 };
    scene.anchors.faces[4] = true;
    Simulation simulation = simulate(scene);
    expectFormula(simulation, scene.block(), compatibleProbes(scene, 5, 2.0, 9), "five probes");
  }
}

TEST(Propagate, OnePassForAllProbesEqualsOneAfterTheOther)
{
  // All earlier probes are pulled again, at the current places of their tissue.
  Scene scene = randomScene({ 20, 16, 12 }, 1, 3);
  const std::vector<Probe> probes = compatibleProbes(scene, 4, 1.5, 4);
  Simulation once = simulate(scene), steps = simulate(scene);
  once.pull(probes);
  for (std::size_t n = 1; n <= probes.size(); ++n)
  {
    steps.pull({ probes.begin(), probes.begin() + n });
  }
  EXPECT_LT(largestDifference(scene.block(), state(once), state(steps)), tolerance);
}

TEST(Propagate, BitsDependNeitherOnBricksNorOnTheOrderOfProbes)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 37, 21, 18 }, axes, 7 + axes);
    scene.anchors.faces[0] = true;
    std::vector<Probe> probes = compatibleProbes(scene, 5, 2.5, 8);
    std::vector<float> first;
    for (const Index3& brick : brickSizes())
    {
      for (int order = 0; order < 3; ++order)
      {
        Simulation simulation = simulate(scene, brick);
        EXPECT_EQ(simulation.brickSize(), brick);
        simulation.pull(probes);
        const std::vector<float> u = displacements(simulation);
        if (first.empty())
        {
          first = u;
          EXPECT_GT(*std::max_element(u.begin(), u.end()), 0.1f);
        }
        EXPECT_TRUE(sameBits(u, first)) << "brick " << brick[0] << ' ' << brick[1] << ' ' << brick[2] << ", order "
                                        << order;
        if (order == 0)
        {
          std::rotate(probes.begin(), probes.begin() + 2, probes.end());
        }
        else
        {
          std::reverse(probes.begin(), probes.end());
        }
      }
    }
  }
}

TEST(Propagate, MirroredSceneGivesTheMirroredBits)
{
  Scene scene = randomScene({ 19, 11, 10 }, 1, 21);
  const int nx = scene.grid.size[0];
  Scene mirrored = scene;
  scene.each(
    [&](int i, int j, int k)
    {
      mirrored.constraint[scene.grid.at(nx - 1 - i, j, k)] = scene.constraint[scene.grid.at(i, j, k)];
      mirrored.scalar[scene.grid.at(nx - 1 - i, j, k)] = scene.scalar[scene.grid.at(i, j, k)];
    });
  Random random(5);
  const Index3 p = randomElement(scene, random);
  Simulation a = simulate(scene), b = simulate(mirrored);
  a.pull({ probeAt(scene, p, { 1.5, 0.75, -2.0 }) });
  b.pull({ probeAt(scene, { nx - 1 - p[0], p[1], p[2] }, { -1.5, 0.75, -2.0 }) });
  const std::vector<float> u = displacements(a), v = displacements(b);
  scene.each(
    [&](int i, int j, int k)
    {
      const std::size_t m = 3 * scene.grid.at(i, j, k), n = 3 * scene.grid.at(nx - 1 - i, j, k);
      ASSERT_EQ(u[m], -v[n]);
      ASSERT_EQ(u[m + 1], v[n + 1]);
      ASSERT_EQ(u[m + 2], v[n + 2]);
    });
}

TEST(Propagate, LengthsTimesAPowerOfTwoScaleExactly)
{
  Scene scene = randomScene({ 15, 14, 13 }, 1, 22);
  Scene large = scene;
  large.grid.spacing = { 4.0, 4.0, 4.0 };
  Random random(6);
  const Index3 p = randomElement(scene, random);
  Simulation a = simulate(scene), b = simulate(large);
  a.pull({ probeAt(scene, p, { 1.5, 0.7, -2.0 }) });
  b.pull({ probeAt(large, p, { 6.0, 2.8, -8.0 }) });
  std::vector<float> u = displacements(a);
  const std::vector<float> v = displacements(b);
  for (float& value : u)
  {
    value *= 4.0f;
  }
  EXPECT_TRUE(sameBits(u, v));
}

TEST(Propagate, SecondPullStartsFromTheDeformedState)
{
  Scene scene = randomScene({ 18, 18, 12 }, 1, 31);
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  expectFormula(simulation, block, compatibleProbes(scene, 2, 2.0, 32), "first");
  expectFormula(simulation, block, compatibleProbes(scene, 3, 2.0, 33), "second, from the deformed state");
  simulation.relax(15, 0.0);
  expectFormula(simulation, block, compatibleProbes(scene, 2, 1.0, 34), "third, from a relaxed state");
  simulation.relax(3, 0.0);
  expectFormula(simulation, block, {}, "released: nothing moves");
}

TEST(Propagate, ASecondWaveArrivesOnlyWhereItCame)
{
  // A chain is pulled taut. Then its end returns by less than all links need to follow.
  const Scene scene({ 24, 1, 1 }, 0.25f);
  for (const Index3& brick : brickSizes())
  {
    for (const int moved : { 3, 7 })
    {
      Simulation simulation = simulate(scene, brick);
      simulation.setPropagationTimes(true);
      simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 20.0, 0.0, 0.0 }) });
      const std::vector<float> taut = displacements(simulation);
      simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 20.0 - (0.5 * moved + 0.25), 0.0, 0.0 }) });
      const std::vector<float> u = displacements(simulation);
      std::vector<float> times(scene.grid.voxels());
      std::vector<int> fronts(scene.grid.voxels());
      simulation.propagationTimes(times.data());
      simulation.wavefronts(fronts.data());
      for (int n = 0; n < 24; ++n)
      {
        ASSERT_EQ(u[3 * n] != taut[3 * n], n <= moved) << n;
        ASSERT_EQ(fronts[n], n <= moved + 1 ? 2 : 1)
          << n; // the wave also reaches the first element that it does not move
        ASSERT_EQ(times[n], 0.25f * n) << n;
      }
    }
  }
}

TEST(Propagate, DisplacementIsFromWhereItGrabbedNotFromTheLastPlace)
{
  Scene scene({ 8, 4, 4 });
  Simulation simulation = simulate(scene);
  for (const double t : { 1.0, 1.0, -0.5, 2.0 })
  {
    const auto results = simulation.pull({ probeAt(scene, { 4, 2, 2 }, { t, 0.0, 0.0 }) });
    EXPECT_EQ(results[0].reached[0], t);
    EXPECT_EQ(displacements(simulation)[3 * scene.grid.at(4, 2, 2)], static_cast<float>(t));
  }
}

TEST(Propagate, ReleasedTissueStaysWhereItIs)
{
  Scene scene = randomScene({ 12, 10, 9 }, 1, 51);
  Simulation simulation = simulate(scene);
  simulation.pull(compatibleProbes(scene, 2, 1.5, 52));
  const std::vector<float> before = displacements(simulation);
  EXPECT_TRUE(simulation.pull({}).empty());
  EXPECT_TRUE(sameBits(displacements(simulation), before));
  EXPECT_TRUE(simulation.probes().empty());
}

// --- Conflicts: policy Limit

TEST(Propagate, LaterProbesGiveWayToEarlierOnesAndToAnchors)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 20, 15, 14 }, axes, 60 + axes, 0.1, 0.05);
    scene.anchors.faces[0] = true;
    const oracle::Block block = scene.block();
    std::vector<Probe> probes = compatibleProbes(scene, 2, 1.0, 61);
    Random random(62);
    for (int n = 0; n < 3; ++n)
    {
      // Far more than the tissue between them can stretch.
      probes.push_back(
        probeAt(scene, randomElement(scene, random), { random(-30, 30), random(-30, 30), random(-30, 30) }));
    }
    Simulation simulation = simulate(scene);
    expectFormula(simulation, block, probes, "conflict", tolerance + overshootTolerance * 30.0);
    // Held tissue does not move at all.
    const std::vector<float> u = displacements(simulation);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      for (int a = 0; block.anchored[v] && a < 3; ++a)
      {
        ASSERT_EQ(u[3 * v + a], 0.0f);
      }
    }
    for (int p = 0; p < 2; ++p)
    {
      const std::size_t v = oracle::grab(block, probes[p].position, 0.0)[0];
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_EQ(u[3 * v + a], static_cast<float>(probes[p].displacement[a])); // spacing 1
      }
    }
  }
}

TEST(Propagate, AnAnchoredProbeHoldsItsTissueWhereItIs)
{
  Scene scene({ 17, 5, 5 }, 0.25f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 2, 2, 2 }, { 1.0, 0.0, 0.0 }) });
  Probe anchor = probeAt(scene, { 2, 2, 2 }, { 9.0, 9.0, 9.0 });
  anchor.anchor = true;
  // Twelve links of 0.25 from the anchor: 1 + 3 at most.
  const Probe far = probeAt(scene, { 14, 2, 2 }, { 100.0, 0.5, -100.0 });
  const auto results = simulation.pull({ anchor, far });
  EXPECT_EQ(results[0].reached, (Vector3{ 1.0, 0.0, 0.0 }));
  EXPECT_NEAR(results[1].reached[0], 4.0, overshootTolerance * 100.0);
  EXPECT_EQ(results[1].reached[1], 0.5);
  EXPECT_NEAR(results[1].reached[2], -3.0, overshootTolerance * 100.0);
  EXPECT_LE(results[1].reached[0], 4.0 + tolerance) << "further than the tissue stretches";
  const std::vector<float> u = displacements(simulation);
  EXPECT_EQ(u[3 * scene.grid.at(2, 2, 2)], 1.0f);
  EXPECT_EQ(u[3 * scene.grid.at(14, 2, 2)], static_cast<float>(results[1].reached[0]));
}

TEST(Propagate, AProbeOnAnchoredTissueDoesNotMoveIt)
{
  Scene scene({ 9, 7, 7 }, 0.3f);
  scene.anchors.faces[0] = true;
  Simulation simulation = simulate(scene);
  const auto results = simulation.pull({ probeAt(scene, { 0, 3, 3 }, { 2.0, 0.0, 0.0 }) });
  EXPECT_EQ(results[0].reached, (Vector3{ 0.0, 0.0, 0.0 }));
  for (const float u : displacements(simulation))
  {
    ASSERT_EQ(u, 0.0f);
  }
}

TEST(Propagate, TwoProbesOnOneElementTheFirstWins)
{
  Scene scene({ 9, 7, 7 }, 0.3f);
  Simulation simulation = simulate(scene);
  const auto results = simulation.pull(
    { probeAt(scene, { 4, 3, 3 }, { 1.0, 0.0, 0.0 }), probeAt(scene, { 4, 3, 3 }, { -1.0, 2.0, 0.0 }) });
  EXPECT_EQ(results[0].reached, (Vector3{ 1.0, 0.0, 0.0 }));
  EXPECT_EQ(results[1].reached, (Vector3{ 1.0, 0.0, 0.0 }));
}

// --- What a probe grabs

TEST(Propagate, RadiusGrabsAllElementsWithinAndMovesThemTogether)
{
  Scene scene = randomScene({ 16, 14, 12 }, 1, 71, 0.2, 0.1);
  scene.grid.spacing = { 1.0, 0.8, 1.7 };
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Random random(72);
  for (const double radius : { 0.3, 1.1, 2.4, 3.6 })
  {
    Index3 p = randomElement(scene, random);
    p[0] = std::max(p[0], 8);
    Probe probe = probeAt(scene, p, { 1.2, -0.9, 0.6 }, radius);
    probe.position[0] += 0.21; // off the centre
    probe.position[2] -= 0.33;
    const auto grabbed = oracle::grab(block, probe.position, radius);
    if (grabbed.empty())
    {
      continue;
    }
    Simulation simulation = simulate(scene);
    expectFormula(simulation, block, { probe }, "radius");
    const std::vector<float> u = displacements(simulation);
    for (const std::size_t v : grabbed)
    {
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_EQ(u[3 * v + a], u[3 * grabbed[0] + a]);
      }
    }
  }
}

TEST(Propagate, NearestElementWithinHalfAVoxelDiagonal)
{
  Scene scene({ 6, 6, 6 }, 0.3f);
  scene.grid.spacing = { 1.0, 2.0, 3.0 };
  scene.air(3, 3, 3);
  Simulation simulation = simulate(scene);
  Probe probe = probeAt(scene, { 3, 3, 3 }, { 0.5, 0.0, 0.0 });
  // In the middle of an air voxel the nearest tissue is one spacing away along x, well within half a diagonal (1.87).
  probe.position[0] += 0.1;
  EXPECT_EQ(simulation.pull({ probe })[0].elements, 1u);
  EXPECT_EQ(displacements(simulation)[3 * scene.grid.at(4, 3, 3)], 0.5f);
  // Slightly outside of the grid it still grabs tissue; further away it does not.
  probe.position = { -0.9, 0.0, 0.0 };
  EXPECT_EQ(simulation.pull({ probe })[0].elements, 1u);
  probe.position = { -1.9, 0.0, 0.0 };
  const std::string message = messageOf<InputError>(
    [&] {
      simulation.pull({ probeAt(scene, { 1, 1, 1 }, {}), probe });
    });
  EXPECT_TRUE(contains(message, "robe")) << message;
}

// --- Rigid tissue

TEST(Propagate, AGrabbedBoneMovesAsAWhole)
{
  Scene scene({ 24, 12, 12 }, 0.3f);
  for (int i = 3; i < 21; ++i)
  {
    scene.give(i, 6, 6, 0.0f);
    scene.give(i, 7, 6, 0.0f);
  }
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    expectFormula(simulation, scene.block(), { probeAt(scene, { 4, 6, 6 }, { 0.37, -2.11, 1.3 }) }, "bone");
    const std::vector<float> u = displacements(simulation);
    for (int i = 3; i < 21; ++i)
    {
      for (int j : { 6, 7 })
      {
        const std::size_t v = 3 * scene.grid.at(i, j, 6);
        EXPECT_EQ(u[v], 0.37f);
        EXPECT_EQ(u[v + 1], -2.11f);
        EXPECT_EQ(u[v + 2], 1.3f);
      }
    }
  }
}

TEST(Propagate, ABoneThatTheWaveReachesMovesAsAWhole)
{
  Scene scene({ 24, 12, 12 }, 0.2f);
  for (int i = 5; i < 21; ++i)
  {
    scene.give(i, 6, 6, 0.0f);
  }
  Simulation simulation = simulate(scene, { 4, 2, 2 });
  expectFormula(simulation, scene.block(), { probeAt(scene, { 1, 5, 5 }, { 3.0, 2.0, -2.5 }) }, "bone");
  const std::vector<float> u = displacements(simulation);
  EXPECT_GT(u[3 * scene.grid.at(5, 6, 6)], 1.0f);
  for (int i = 6; i < 21; ++i)
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_EQ(u[3 * scene.grid.at(i, 6, 6) + a], u[3 * scene.grid.at(5, 6, 6) + a]);
    }
  }
}

TEST(Propagate, RigidOnOneAxisOnly)
{
  Scene scene({ 14, 8, 8 }, 0.25f, 3);
  for (std::size_t v = 0; v < scene.grid.voxels(); ++v)
  {
    scene.constraint[3 * v + 1] = 0.0f; // nothing gives along y
  }
  Simulation simulation = simulate(scene);
  expectFormula(simulation, scene.block(), { probeAt(scene, { 7, 4, 4 }, { 1.0, 3.0, -0.5 }) }, "one axis");
  const std::vector<float> u = displacements(simulation);
  for (std::size_t v = 0; v < scene.grid.voxels(); ++v)
  {
    ASSERT_EQ(u[3 * v + 1], 3.0f);
  }
  EXPECT_EQ(u[0], 0.0f);
}

// --- Extent of the work

TEST(Propagate, WhatTheWaveDoesNotReachTakesNoMemory)
{
  Scene scene({ 96, 96, 96 }, 0.5f);
  Simulation simulation = simulate(scene, { 8, 8, 8 });
  EXPECT_EQ(simulation.measure().displaced, 0u);
  simulation.pull({ probeAt(scene, { 48, 48, 48 }, { 1.6, 0.0, 0.0 }) });
  const Statistics statistics = simulation.measure();
  // City-block ball of radius 3 (1.6 / 0.5 rounded down): 63 elements.
  EXPECT_EQ(statistics.displaced, 63u);
  EXPECT_GE(statistics.allocated, 63u);
  EXPECT_LT(statistics.allocated, scene.grid.voxels() / 8);
}

// The work of a launch within a brick is limited, so tissue that winds through a brick needs several launches. All
// numbers are sums of powers of two, and exact.
TEST(Propagate, TissueThatWindsThroughABrick)
{
  // Rows along x, connected at alternating ends, in two layers.
  Scene scene({ 32, 16, 4 }, 0.125f);
  std::size_t elements = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const bool row = k % 2 == 0 && j % 2 == 0 && j < 15;
      const bool bend = k % 2 == 0 && j % 2 == 1 && j < 15 && i == (j % 4 == 1 ? 31 : 0);
      const bool climb = k == 1 && j == 14 && i == 0;
      if (row || bend || climb)
      {
        ++elements;
      }
      else
      {
        scene.air(i, j, k);
      }
    });
  std::vector<Index3> bricks = brickSizes();
  bricks.push_back({ 0, 0, 0 });
  for (const Index3& brick : bricks)
  {
    Simulation simulation = simulate(scene, brick);
    simulation.setPropagationTimes(true);
    simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 80.0, 0.0, -40.0 }) });
    const std::vector<float> u = displacements(simulation);
    std::vector<float> times(scene.grid.voxels());
    simulation.propagationTimes(times.data());
    EXPECT_EQ(*std::max_element(times.begin(), times.end()), 0.125f * (elements - 1));
    for (std::size_t v = 0; v < scene.grid.voxels(); ++v)
    {
      ASSERT_EQ(times[v] >= 0.0f, scene.tissue(v) && (v == 0 || times[v] > 0.0f));
      ASSERT_EQ(u[3 * v], scene.tissue(v) ? 80.0f - times[v] : 0.0f);
      ASSERT_EQ(u[3 * v + 2], scene.tissue(v) ? std::min(0.0f, times[v] - 40.0f) : 0.0f);
    }

    // On a coarser grid the rows are connected, so their displacements come back far beyond the limits.
    Probe end = probeAt(scene, { 0, 0, 2 }, { 0.0, 0.0, 0.0 });
    end.anchor = true;
    Simulation settling = simulate(scene, brick);
    settling.setCoarseToFine(true);
    settling.pull({ end, probeAt(scene, { 0, 0, 0 }, { 60.0, 0.0, 0.0 }) });
    settling.relax(3, 0.0);
    EXPECT_LE(settling.measure().maxLinkExcess, tolerance);
  }
}

TEST(Propagate, SingleSliceAndSingleVoxel)
{
  Scene slice = randomScene({ 30, 25, 1 }, 1, 81);
  Simulation simulation = simulate(slice);
  expectFormula(simulation, slice.block(), compatibleProbes(slice, 3, 2.0, 82), "slice");

  for (const Index3& thin : { Index3{ 1, 20, 9 }, Index3{ 40, 1, 1 }, Index3{ 1, 1, 33 } })
  {
    Scene scene = randomScene(thin, 1, 83, 0.0, 0.2);
    Simulation s = simulate(scene);
    expectFormula(s, scene.block(), compatibleProbes(scene, 2, 2.0, 84), "thin");
  }

  Scene voxel({ 1, 1, 1 }, 0.3f);
  Simulation alone = simulate(voxel);
  alone.pull({ probeAt(voxel, { 0, 0, 0 }, { 5.0, -6.0, 7.0 }) });
  EXPECT_EQ(displacements(alone), (std::vector<float>{ 5.0f, -6.0f, 7.0f }));
}

}
