// Probes in conflict with each other or with the tissue that they grab, in cases where rounding and the order of waves
// matter.

#include "Scene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// The excess of links that the engine attributes to the rounding of displacements of this size.
double rounding(double displacement)
{
  return 4e-6 * std::max(1.0, displacement);
}

Scene noise(const Index3& size, std::uint64_t seed)
{
  Scene scene(size, 0.0f);
  Random random(seed);
  scene.each([&](int i, int j, int k) { scene.give(i, j, k, static_cast<float>(random(0.1, 0.9))); });
  return scene;
}

Probe anchorAt(const Scene& scene, const Simulation& simulation, const Index3& p)
{
  const std::vector<float> u = displacements(simulation);
  Probe anchor = probeAt(scene, p, {});
  for (int a = 0; a < 3; ++a)
  {
    anchor.position[a] += u[3 * scene.grid.at(p[0], p[1], p[2]) + a];
  }
  anchor.anchor = true;
  return anchor;
}

// The wave passes through a brick twice, on two sides of a wall of air. In between, an anchor is added on the second
// side.
TEST(Conflicts, AnAnchorThatComesWhileAWaveIsUnderWayHolds)
{
  Scene scene({ 64, 8, 8 }, 0.2f);
  for (int k = 0; k < 8; ++k)
  {
    for (int i = 0; i < 60; ++i)
    {
      scene.air(i, 4, k);
    }
  }
  Simulation simulation = simulate(scene, { 16, 8, 8 });
  const Probe probe = probeAt(scene, { 4, 2, 4 }, { 20.0, 0.0, 0.0 });
  simulation.hold({ probe });
  simulation.propagate(2);
  const Index3 place{ 40, 6, 4 };
  ASSERT_GT(state(simulation)[scene.grid.at(40, 2, 4)][0], 0.0) << "the wave has not come to the brick";
  ASSERT_EQ(state(simulation)[scene.grid.at(place[0], place[1], place[2])][0], 0.0) << "the wave has come too far";
  Probe anchor = probeAt(scene, place, {});
  anchor.anchor = true;
  simulation.hold({ probe, anchor });
  while (!simulation.propagate(1).finished)
  {
  }
  EXPECT_EQ(state(simulation)[scene.grid.at(place[0], place[1], place[2])][0], 0.0);
  EXPECT_GT(state(simulation)[scene.grid.at(4, 2, 4)][0], 15.0);
  EXPECT_LE(simulation.measure().maxLinkExcess, rounding(20.0));
}

// Probes that are shortened leave links whose excess is rounding. An anchor next to such a link must not count as
// displaced tissue. Otherwise its probe would seem to be held from both sides.
TEST(Conflicts, AProbeComesBackAsFarAsAnchorsLetIt)
{
  for (std::uint64_t seed = 0; seed < 12; ++seed)
  {
    SCOPED_TRACE(seed);
    const Scene scene = noise({ 7, 5, 6 }, 2000 + seed);
    const oracle::Block block = scene.block();
    Simulation simulation = simulate(scene);
    Probe probe = probeAt(scene, { 1, 1, 1 }, { 27.0, -18.0, 19.0 });
    simulation.pull({ probe, probeAt(scene, { 4, 3, 2 }, {}), probeAt(scene, { 5, 1, 4 }, { 0.1, 0.0, -0.2 }) });
    const auto before = state(simulation);
    const Index3 places[] = { { 4, 3, 2 }, { 4, 2, 2 }, { 5, 1, 3 }, { 5, 2, 4 } };
    std::vector<Probe> probes;
    std::vector<std::pair<std::size_t, double>> up[3], down[3];
    for (const Index3& p : places)
    {
      probes.push_back(anchorAt(scene, simulation, p));
      const std::size_t v = scene.grid.at(p[0], p[1], p[2]);
      for (int a = 0; a < 3; ++a)
      {
        up[a].push_back({ v, before[v][a] });
        down[a].push_back({ v, -before[v][a] });
      }
    }
    probe.displacement = { 0.1, 0.2, 0.0 };
    probes.push_back(probe);
    const auto results = simulation.pull(probes);
    const std::size_t v = scene.grid.at(1, 1, 1);
    for (int a = 0; a < 3; ++a)
    {
      const double high = oracle::shortest(block, a, up[a])[v], low = -oracle::shortest(block, a, down[a])[v];
      const double expected = std::min(std::max(probe.displacement[a], low), high);
      EXPECT_NEAR(results.back().reached[a], expected, rounding(27.0)) << "axis " << a;
    }
    EXPECT_LE(oracle::maxLinkExcess(block, state(simulation)), rounding(27.0));
  }
}

// A probe with a radius that grabs deformed tissue keeps the tissue's shape, so its elements have different
// displacements. Then the first arrival in time is not always the active constraint.
TEST(Conflicts, TimestampsOfAnUnevenSourceLeaveLinksWithinTheirLimits)
{
  for (std::uint64_t seed = 0; seed < 8; ++seed)
  {
    SCOPED_TRACE(seed);
    const Scene scene = noise({ 12, 10, 9 }, 2100 + seed);
    Simulation simulation = simulate(scene);
    simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Limit);
    simulation.pull({ probeAt(scene, { 5, 5, 4 }, { 3.0, -2.0, 2.5 }) });
    simulation.pull({});
    simulation.relax(3, 0.0);
    Probe wide = anchorAt(scene, simulation, { 5, 5, 4 });
    wide.anchor = false;
    wide.radius = 2.6;
    wide.displacement = { -2.5, 1.5, 4.0 };
    const auto results = simulation.pull({ wide });
    EXPECT_GT(results[0].elements, 8u);
    EXPECT_EQ(results[0].reached[0], -2.5);
    EXPECT_LE(oracle::maxLinkExcess(scene.block(), state(simulation)), rounding(7.0));
  }
}

// With Latest, the waves of all probes start at once, and drag earlier probes along.
TEST(Conflicts, OverlappingWavesOfContradictingProbesEndFeasible)
{
  for (std::uint64_t seed = 0; seed < 8; ++seed)
  {
    SCOPED_TRACE(seed);
    Scene scene = noise({ 14, 11, 10 }, 2200 + seed);
    scene.anchors.faces[2] = seed % 2 == 0;
    const oracle::Block block = scene.block();
    Random random(2300 + seed);
    std::vector<Probe> probes;
    for (int n = 0; n < 6; ++n)
    {
      probes.push_back(probeAt(scene, { random.below(14), 1 + random.below(10), random.below(10) },
        { random(-6.0, 6.0), random(-6.0, 6.0), random(-6.0, 6.0) }, random(0.0, 2.0)));
    }
    probes[1].anchor = true;
    for (const bool relaxed : { false, true })
    {
      Simulation simulation = simulate(scene);
      simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Latest);
      simulation.hold(probes);
      if (relaxed)
      {
        simulation.propagate(3);
        simulation.relax(2, 0.0);
      }
      EXPECT_TRUE(simulation.propagate(0).finished);
      EXPECT_LE(oracle::maxLinkExcess(block, state(simulation)), rounding(6.0));
      const auto results = simulation.probes();
      EXPECT_EQ(results[1].reached, (Vector3{ 0.0, 0.0, 0.0 })) << "an anchor was dragged along";
    }
  }
}

// Two probes strain a chain to the last bit. A third probe between them is to move along other axes only. On the
// strained axis only rounding is left, which must not keep the probe from moving along the others.
TEST(Conflicts, NoRoomOnOneAxisLeavesTheOthers)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Scene scene({ 15, 1, 1 }, 0.0f);
    Random random(2400 + seed);
    scene.each([&](int i, int j, int k) { scene.give(i, j, k, static_cast<float>(random(0.01, 0.3))); });
    Simulation simulation = simulate(scene);
    Probe anchor = probeAt(scene, { 0, 0, 0 }, { 0.0, -30.0, 0.0 });
    anchor.anchor = true;
    // To the limit of the chain.
    std::vector<Probe> probes{ anchor, probeAt(scene, { 14, 0, 0 }, { 0.0, 30.0, -30.0 }) };
    simulation.pull(probes);
    const double reach = simulation.probes()[1].reached[1];
    EXPECT_GT(reach, 0.5);
    const auto u = state(simulation);
    Probe between = anchorAt(scene, simulation, { 7, 0, 0 });
    between.anchor = false;
    between.displacement = { 0.05, 1.0, -1.0 };
    probes.push_back(between);
    const auto results = simulation.pull(probes);
    EXPECT_EQ(results[2].reached[0], static_cast<float>(0.05));
    EXPECT_NEAR(results[2].reached[1], 0.0, rounding(1.0));
    EXPECT_NEAR(results[2].reached[2], 0.0, rounding(1.0));
    EXPECT_LE(oracle::maxLinkExcess(scene.block(), state(simulation)), rounding(reach));
  }
}

// Two earlier probes strain the tissue of a handle so far that the handle as a whole has no feasible displacement on
// that axis. Its wave reaches one of them long before the other, so it finds one conflict at a time. It keeps its
// tissue on that axis and moves along the others.
TEST(Conflicts, AHandThatOthersPullApartMovesAlongOtherAxes)
{
  const Scene scene({ 100, 1, 1 }, 0.25f);
  Simulation simulation = simulate(scene, { 4, 2, 2 });
  const auto results = simulation.pull({ probeAt(scene, { 20, 0, 0 }, { 0.0, 7.5, 0.0 }),
    probeAt(scene, { 90, 0, 0 }, { 0.0, -10.0, 0.0 }), probeAt(scene, { 50, 0, 0 }, { 0.05, 0.0, -0.125 }, 1.0) });
  ASSERT_EQ(results[2].elements, 3u);
  EXPECT_EQ(results[2].reached[0], static_cast<float>(0.05));
  EXPECT_EQ(results[2].reached[2], -0.125);
  const auto u = state(simulation);
  for (std::size_t v = 49; v <= 51; ++v)
  {
    EXPECT_NEAR(u[v][1], 0.25 * (50.0 - static_cast<double>(v)), rounding(10.0));
  }
  EXPECT_LE(oracle::maxLinkExcess(scene.block(), state(simulation)), rounding(10.0));
}

// A probe whose first wave has not started counts as under way.
TEST(Conflicts, RelaxationBeforeTheFirstTimestamp)
{
  const Scene scene = noise({ 9, 8, 7 }, 2500);
  Simulation simulation = simulate(scene);
  simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Limit);
  const Probe probe = probeAt(scene, { 4, 4, 3 }, { 2.0, 1.0, -1.5 });
  for (int round = 0; round < 2; ++round)
  {
    simulation.hold({ probe });
    simulation.relax(2, 0.0);
    EXPECT_EQ(simulation.measure().displaced, 0u);
    simulation.propagate(0);
    EXPECT_EQ(simulation.probes()[0].reached, (Vector3{ 2.0, 1.0, -1.5 }));
    EXPECT_LE(oracle::maxLinkExcess(scene.block(), state(simulation)), rounding(2.0));
    simulation.reset();
  }
}

}
