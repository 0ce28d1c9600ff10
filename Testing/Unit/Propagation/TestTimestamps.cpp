// The published propagation and its maps of time and wave ids, against a simple run of algorithms 1 and 2 and against
// Dijkstra's algorithm. The order of waves, their overlap, and the tissue that resists them.

#include "../../Oracles/Timestamps.h"
#include "Scene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

// Sums of some fifty float32 limits below 1.
constexpr double tolerance = 1e-5;

std::vector<float> times(const Simulation& simulation)
{
  std::vector<float> out(simulation.model().grid().voxels() * simulation.model().axes());
  simulation.propagationTimes(out.data());
  return out;
}

std::vector<int> fronts(const Simulation& simulation)
{
  std::vector<int> out(simulation.model().grid().voxels() * simulation.model().axes());
  simulation.wavefronts(out.data());
  return out;
}

Simulation simulateWith(const Scene& scene, PropagationMethod method, ConflictPolicy policy = ConflictPolicy::Limit,
  const Index3& brick = { 0, 0, 0 })
{
  Simulation simulation = simulate(scene, brick);
  simulation.setPropagation(method, policy);
  simulation.setPropagationTimes(true);
  return simulation;
}

constexpr PropagationMethod bothMethods[] = { PropagationMethod::Envelope, PropagationMethod::Timestamp };

}

TEST(Timestamp, Figure4OfThePaperExactly)
{
  // Links of 1.5 and 3 in a spacing of 16: all numbers are exact.
  Scene scene({ 3, 1, 1 });
  scene.grid.spacing = { 16.0, 16.0, 16.0 };
  scene.constraint = { 0.0625f, 0.125f, 0.25f };
  for (const PropagationMethod method : bothMethods)
  {
    Simulation simulation = simulateWith(scene, method);
    simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 100.0, 0.0, 0.0 }) });
    const std::vector<float> t = times(simulation);
    EXPECT_EQ(t[0] * 16.0f, 0.0f);
    EXPECT_EQ(t[1] * 16.0f, 1.5f);
    EXPECT_EQ(t[2] * 16.0f, 4.5f);
    EXPECT_EQ(fronts(simulation), (std::vector<int>{ 1, 1, 1 }));
  }
}

TEST(Timestamp, Figure5OfThePaperTakesTheRigidBranch)
{
  // A ring: elastic on top, rigid at the sides and the bottom.
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
  for (const PropagationMethod method : bothMethods)
  {
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulateWith(scene, method, ConflictPolicy::Limit, brick);
      simulation.pull({ probeAt(scene, { 0, n - 1, 0 }, { 3.0, -2.0, 0.0 }) });
      const std::vector<float> u = displacements(simulation);
      const std::vector<float> t = times(simulation);
      for (const int voxel : { 0, n - 1, n * n - 1 }) // the other three corners
      {
        EXPECT_EQ(u[3 * voxel], 3.0f);
        EXPECT_EQ(u[3 * voxel + 1], -2.0f);
        EXPECT_EQ(t[voxel], 0.0f);
      }
    }
  }
}

TEST(Timestamp, SingleWavesAreTheEnvelopeAndTheirTimesAreDijkstras)
{
  for (int seed = 0; seed < 6; ++seed)
  {
    const int axes = seed % 2 == 0 ? 1 : 3;
    Scene scene = randomScene({ 19, 16, 13 }, axes, 700 + seed, 0.15, seed < 2 ? 0.1 : 0.0);
    scene.grid.spacing = { 0.7, 1.3, 2.9 };
    const oracle::Block block = scene.block();
    Random random(seed);
    const Index3 at = randomElement(scene, random);
    const Probe probe = probeAt(scene, at, { 1.9, -2.2, 3.1 });
    Simulation envelope = simulateWith(scene, PropagationMethod::Envelope);
    Simulation timestamp = simulateWith(scene, PropagationMethod::Timestamp);
    envelope.pull({ probe });
    timestamp.pull({ probe });
    const auto u = state(timestamp);
    EXPECT_LT(largestDifference(block, u, state(envelope)), tolerance);

    const std::vector<float> t = times(timestamp);
    const std::vector<float> te = times(envelope);
    const std::vector<int> f = fronts(timestamp);
    EXPECT_EQ(f, fronts(envelope));
    const std::size_t source = scene.grid.at(at[0], at[1], at[2]);
    int reached = 0;
    for (int group = 0; group < axes; ++group)
    {
      const auto graph = oracle::graph(block, group);
      const std::vector<double> distance = oracle::shortest(block, group, { { source, 0.0 } });
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        const std::size_t n = v * axes + group;
        const auto moved = [&](std::size_t voxel)
        { return voxel == source || (axes == 3 ? u[voxel][group] != 0.0 : u[voxel] != oracle::Vector3{}); };
        // A time is known for moved elements and their neighbours.
        const bool known =
          block.tissue[v] && (moved(v) || std::any_of(graph[v].begin(), graph[v].end(),
                                            [&](const oracle::Neighbour& w) { return moved(w.voxel); }));
        ASSERT_EQ(f[n], known ? 1 : 0) << v;
        if (!known)
        {
          EXPECT_EQ(t[n], -1.0f);
          EXPECT_EQ(te[n], -1.0f);
          continue;
        }
        ++reached;
        // If rounding absorbs the displacement of an earlier arrival, the published method does not pass the arrival
        // on.
        EXPECT_NEAR(t[n], te[n], 1e-6) << v;
        if (moved(v))
        {
          EXPECT_NEAR(t[n], distance[v], tolerance) << v;
        }
        else
        {
          // For neighbours of moved tissue the shortest path may run outside it.
          EXPECT_GE(t[n], distance[v] - tolerance) << v;
        }
      }
    }
    EXPECT_GT(reached, 200);
  }
}

TEST(Timestamp, EveryIterationIsThatOfAlgorithm2)
{
  for (int seed = 0; seed < 3; ++seed)
  {
    // Without rigid tissue, in which several neighbours arrive at the same time and the published order would matter.
    Scene scene = randomScene({ 17, 14, 11 }, 1, 800 + seed, 0.15, 0.0);
    const oracle::Block block = scene.block();
    Random random(seed);
    const Index3 p = randomElement(scene, random);
    Index3 q = randomElement(scene, random);
    while (std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]) < 8)
    {
      q = randomElement(scene, random);
    }
    const Probe first = probeAt(scene, p, { 2.5, -1.7, 1.1 });
    const Probe second = probeAt(scene, q, { -1.5, 2.0, 0.6 });

    std::vector<Simulation> simulations;
    for (const Index3& brick : brickSizes())
    {
      simulations.push_back(simulateWith(scene, PropagationMethod::Timestamp, ConflictPolicy::Latest, brick));
    }
    oracle::TimestampWaves waves(block);
    for (int iteration = 0; iteration < 60; ++iteration)
    {
      if (iteration == 0 || iteration == 4)
      {
        std::vector<Probe> probes{ first };
        if (iteration == 4)
        {
          probes.push_back(second);
          waves.start(scene.grid.at(q[0], q[1], q[2]), { -1.5, 2.0, 0.6 }, 2);
        }
        else
        {
          waves.start(scene.grid.at(p[0], p[1], p[2]), { 2.5, -1.7, 1.1 }, 1);
        }
        for (Simulation& simulation : simulations)
        {
          simulation.hold(probes);
        }
      }
      waves.iterate();
      bool last = false;
      for (Simulation& simulation : simulations)
      {
        const PropagateResult result = simulation.propagate(1);
        EXPECT_EQ(result.iterations, 1);
        EXPECT_EQ(result.finished, waves.finished());
        last = result.finished;
        EXPECT_TRUE(sameBits(displacements(simulation), displacements(simulations.front())));
        EXPECT_TRUE(sameBits(times(simulation), times(simulations.front())));
        EXPECT_EQ(fronts(simulation), fronts(simulations.front()));
      }
      const auto u = state(simulations.front());
      const std::vector<float> t = times(simulations.front());
      const std::vector<int> f = fronts(simulations.front());
      double worst = 0.0;
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        ASSERT_EQ(f[v], waves.state[v].front) << "iteration " << iteration << " voxel " << v;
        worst = std::max(worst, std::abs(static_cast<double>(t[v]) - waves.state[v].time));
        // Overlapping waves end with a repair, see below.
        for (int a = 0; !last && a < 3; ++a)
        {
          worst = std::max(worst, std::abs(u[v][a] - waves.state[v].u[a]));
        }
      }
      EXPECT_LT(worst, tolerance) << "iteration " << iteration;
      if (last)
      {
        break;
      }
    }
    ASSERT_TRUE(waves.finished());

    // Overlapping waves leave links beyond their limits. The engine repairs them and changes little else.
    std::vector<oracle::Vector3> published(block.count());
    std::transform(waves.state.begin(), waves.state.end(), published.begin(),
      [](const oracle::TimestampWaves::Element& e) { return e.u; });
    const auto got = state(simulations.front());
    EXPECT_LT(oracle::maxLinkExcess(block, got), tolerance);
    if (oracle::maxLinkExcess(block, published) < tolerance)
    {
      EXPECT_LT(largestDifference(block, got, published), tolerance);
    }
    // The later wave prevails: its probe reaches its target.
    const std::size_t voxel = scene.grid.at(q[0], q[1], q[2]);
    EXPECT_EQ(got[voxel], (oracle::Vector3{ -1.5, 2.0, static_cast<double>(0.6f) }));
  }
}

TEST(Timestamp, UnderLimitNoHeldProbeMoves)
{
  for (const PropagationMethod method : bothMethods)
  {
    for (int seed = 0; seed < 4; ++seed)
    {
      Scene scene = randomScene({ 16, 14, 12 }, seed % 2 == 0 ? 1 : 3, 900 + seed);
      scene.anchors.faces[0] = true;
      const oracle::Block block = scene.block();
      Random random(seed);
      Simulation simulation = simulateWith(scene, method);
      std::vector<Probe> probes;
      std::vector<Index3> places;
      for (int n = 0; n < 4; ++n)
      {
        places.push_back(randomElement(scene, random));
        probes.push_back(probeAt(scene, places.back(), { random(-6, 6), random(-6, 6), random(-6, 6) }));
        const auto before = simulation.probes();
        simulation.hold(probes);
        const PropagateResult partial = simulation.propagate(3);
        EXPECT_LE(partial.iterations, 3);
        simulation.propagate();
        const auto after = simulation.probes();
        for (std::size_t p = 0; p < before.size(); ++p)
        {
          EXPECT_EQ(before[p].reached, after[p].reached);
        }
        EXPECT_LT(oracle::maxLinkExcess(block, state(simulation)), tolerance);
      }
    }
  }
}

TEST(Timestamp, UnderLatestTheNewestWaveDragsOlderProbesAndStopsAtAnchors)
{
  for (const PropagationMethod method : bothMethods)
  {
    Scene scene({ 24, 5, 4 }, 0.25f);
    Simulation simulation = simulateWith(scene, method, ConflictPolicy::Latest);
    const Probe first = probeAt(scene, { 4, 2, 2 }, { -2.0, 0.0, 0.0 });
    const Probe second = probeAt(scene, { 12, 2, 2 }, { 4.0, 1.0, 0.0 });
    simulation.pull({ first });
    const auto results = simulation.pull({ first, second });
    EXPECT_EQ(results[1].reached, (Vector3{ 4.0, 1.0, 0.0 }));
    // Eight links of 0.25 between them.
    EXPECT_NEAR(results[0].reached[0], 4.0 - 8 * 0.25, tolerance);
    EXPECT_EQ(results[0].reached[1], 0.0);
    EXPECT_LT(oracle::maxLinkExcess(scene.block(), state(simulation)), tolerance);

    // A later wave of the first probe, and an anchor, which no wave drags.
    Probe anchor = probeAt(scene, { 19, 2, 2 }, {}); // the current place of element 16
    anchor.anchor = true;
    const auto held = simulation.pull({ first, second, anchor });
    EXPECT_EQ(held[1].reached, results[1].reached);
    Probe again = first;
    again.displacement = { -9.0, 0.0, 0.0 };
    const auto pulled = simulation.pull({ again, second, anchor });
    EXPECT_EQ(pulled[2].reached, (Vector3{}));
    EXPECT_NEAR(state(simulation)[scene.grid.at(16, 2, 2)][0], 3.0, tolerance);
    EXPECT_NEAR(pulled[0].reached[0], 3.0 - 12 * 0.25, 2 * tolerance); // twelve links to the anchor
    EXPECT_LT(oracle::maxLinkExcess(scene.block(), state(simulation)), tolerance);
  }
}

TEST(Timestamp, LatestIsTheFormulaWaveByWave)
{
  for (int seed = 0; seed < 3; ++seed)
  {
    Scene scene = randomScene({ 15, 13, 12 }, seed == 2 ? 3 : 1, 950 + seed);
    const oracle::Block block = scene.block();
    Random random(seed);
    std::vector<Probe> probes;
    std::vector<oracle::Vector3> expected(block.count());
    for (const PropagationMethod method : bothMethods)
    {
      Simulation simulation = simulateWith(scene, method, ConflictPolicy::Latest);
      Random again(seed);
      std::vector<Probe> list;
      expected.assign(block.count(), {});
      for (int n = 0; n < 3; ++n)
      {
        const Index3 p = randomElement(scene, again);
        Probe probe = probeAt(scene, p, {});
        const auto now = state(simulation)[scene.grid.at(p[0], p[1], p[2])];
        oracle::Handle handle;
        handle.elements = { scene.grid.at(p[0], p[1], p[2]) };
        for (int a = 0; a < 3; ++a)
        {
          handle.target[a] = again(-4, 4);
          probe.position[a] += now[a];
          probe.displacement[a] = handle.target[a] - now[a];
        }
        list.push_back(probe);
        simulation.pull(list);
        expected = oracle::propagate(block, expected, { handle }).state;
        EXPECT_LT(largestDifference(block, state(simulation), expected), 2 * tolerance) << n;
      }
    }
  }
}

TEST(Timestamp, EnvelopeInStepsEndsWithTheSameBits)
{
  Scene scene = randomScene({ 40, 36, 20 }, 1, 960);
  const std::vector<Probe> probes = compatibleProbes(scene, 3, 4.0, 961);
  Simulation whole = simulate(scene, { 8, 4, 4 });
  whole.pull(probes);
  Simulation steps = simulate(scene, { 8, 4, 4 });
  steps.hold(probes);
  int iterations = 0;
  for (bool finished = false; !finished; ++iterations)
  {
    const PropagateResult result = steps.propagate(1);
    EXPECT_EQ(result.iterations, 1);
    finished = result.finished;
    if (!finished)
    {
      // Tissue does not relax while a wave passes through it.
      EXPECT_EQ(steps.relax(3, 0.0).iterations, 0);
    }
  }
  EXPECT_GT(iterations, 3);
  EXPECT_TRUE(sameBits(displacements(whole), displacements(steps)));
}

TEST(Timestamp, RelaxationBetweenIterationsEndsFeasibleWithProbesInPlace)
{
  for (const ConflictPolicy policy : { ConflictPolicy::Limit, ConflictPolicy::Latest })
  {
    for (int seed = 0; seed < 3; ++seed)
    {
      Scene scene = randomScene({ 18, 15, 13 }, seed == 1 ? 3 : 1, 970 + seed);
      scene.anchors.faces[2] = true;
      const oracle::Block block = scene.block();
      Simulation simulation = simulateWith(scene, PropagationMethod::Timestamp, policy);
      const std::vector<Probe> probes = compatibleProbes(scene, 2, 3.0, 980 + seed);
      simulation.hold({ probes[0] });
      simulation.propagate(2);
      simulation.relax(2, 0.0);
      simulation.hold(probes);
      bool finished = false;
      int frames = 0;
      for (; !finished && frames < 200; ++frames)
      {
        finished = simulation.propagate(1).finished;
        simulation.relax(2, 0.0);
      }
      EXPECT_TRUE(finished);
      EXPECT_GT(frames, 1);
      EXPECT_LT(oracle::maxLinkExcess(block, state(simulation)), tolerance);
      const auto results = simulation.probes();
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(results[1].reached[a], probes[1].displacement[a], tolerance);
      }
      const auto u = state(simulation);
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        if (block.anchored[v])
        {
          EXPECT_EQ(u[v], oracle::Vector3{});
        }
      }
    }
  }
}

TEST(Timestamp, AProbeReleasedInMidWaveIsHeldToItsEndAndThenFree)
{
  for (const PropagationMethod method : bothMethods)
  {
    Scene scene({ 30, 6, 6 }, 0.3f);
    Simulation simulation = simulateWith(scene, method, ConflictPolicy::Limit, { 4, 2, 2 });
    const Probe probe = probeAt(scene, { 3, 3, 3 }, { 4.0, 0.0, 0.0 });
    simulation.hold({ probe });
    EXPECT_FALSE(simulation.propagate(1).finished);
    simulation.hold({});
    simulation.propagate();
    Simulation whole = simulateWith(scene, method, ConflictPolicy::Limit, { 4, 2, 2 });
    whole.pull({ probe });
    EXPECT_TRUE(sameBits(displacements(simulation), displacements(whole)));
    // Nothing is held any more: the strain relaxes to 0.
    simulation.relax(4000, 0.0);
    EXPECT_LT(simulation.measure().energy, 1e-3 * whole.measure().energy);
  }
}

TEST(Timestamp, AProbeMovedAgainInMidWaveGetsToTheNewPlace)
{
  for (const PropagationMethod method : bothMethods)
  {
    for (const ConflictPolicy policy : { ConflictPolicy::Limit, ConflictPolicy::Latest })
    {
      Scene scene({ 30, 6, 6 }, 0.3f);
      Simulation simulation = simulateWith(scene, method, policy, { 4, 2, 2 });
      Probe probe = probeAt(scene, { 3, 3, 3 }, { 4.0, 0.0, 0.0 });
      simulation.hold({ probe });
      simulation.propagate(1);
      probe.displacement = { -1.0, 2.0, 0.5 };
      simulation.hold({ probe });
      simulation.propagate();
      EXPECT_EQ(simulation.probes()[0].reached, probe.displacement);
      EXPECT_EQ(simulation.probes()[0].elements, 1u);
      EXPECT_LT(oracle::maxLinkExcess(scene.block(), state(simulation)), tolerance);
    }
  }
}

TEST(Timestamp, ResetForgetsWavesAndTimes)
{
  Scene scene({ 12, 6, 6 }, 0.3f);
  Simulation simulation = simulateWith(scene, PropagationMethod::Timestamp);
  const Probe probe = probeAt(scene, { 3, 3, 3 }, { 2.0, 0.0, 0.0 });
  simulation.hold({ probe });
  simulation.propagate(2);
  simulation.reset();
  const std::vector<float> none = times(simulation);
  EXPECT_EQ(std::count(none.begin(), none.end(), -1.0f), static_cast<long>(none.size()));
  EXPECT_TRUE(simulation.propagate().finished);
  const std::vector<float> u = displacements(simulation);
  EXPECT_EQ(std::count(u.begin(), u.end(), 0.0f), static_cast<long>(u.size()));
  simulation.pull({ probe });
  Simulation fresh = simulateWith(scene, PropagationMethod::Timestamp);
  fresh.pull({ probe });
  EXPECT_TRUE(sameBits(displacements(simulation), displacements(fresh)));
  EXPECT_EQ(fronts(simulation), fronts(fresh));
}

TEST(Timestamp, TimesTravelAroundACut)
{
  // Fig. 7: a wall without links, open at its end.
  Scene scene({ 17, 17, 1 }, 0.1f);
  Surface blade;
  blade.points = { { 7.5, -1.0, -1.0 }, { 7.5, 12.2, -1.0 }, { 7.5, 12.2, 1.0 }, { 7.5, -1.0, 1.0 } };
  blade.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  for (const PropagationMethod method : bothMethods)
  {
    Simulation simulation = simulateWith(scene, method);
    simulation.cut(blade);
    simulation.pull({ probeAt(scene, { 4, 2, 0 }, { 8.0, 0.0, 0.0 }) });
    const std::vector<float> t = times(simulation);
    // Up to row 13, across, and down again on the other side.
    EXPECT_NEAR(t[scene.grid.at(8, 2, 0)], (4 + 11 + 11) * 0.1, tolerance);
    EXPECT_NEAR(t[scene.grid.at(7, 2, 0)], 3 * 0.1, tolerance);
  }
}
