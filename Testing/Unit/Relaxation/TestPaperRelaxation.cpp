// The published relaxation, which moves all elements at once to the weighted mean: step by step against a simple run of
// the same iteration in double precision. And its limitations.

#include "Inclusion.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

Simulation published(const Scene& scene, double recovery = 1.0, const Index3& brick = { 0, 0, 0 })
{
  Simulation simulation = simulate(scene, brick);
  simulation.setRelaxation(RelaxationMethod::Paper, recovery);
  return simulation;
}

/// One iteration of eq. 8 as published.
std::vector<oracle::Vector3> iterate(
  const oracle::Block& block, const std::vector<char>& held, const std::vector<oracle::Vector3>& u)
{
  std::vector<oracle::Vector3> next = u;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto neighbours = oracle::graph(block, axis);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      double weight = 0.0;
      double sum = 0.0;
      for (const oracle::Neighbour& n : neighbours[v])
      {
        const double slack = block.slack * n.limit;
        const double stretch = u[v][axis] - u[n.voxel][axis];
        const double offered = u[n.voxel][axis] + std::min(std::max(stretch, -slack), slack);
        weight += 1.0 / (n.limit + 1e-6);
        sum += offered / (n.limit + 1e-6);
      }
      if (!held[v] && weight > 0.0)
      {
        next[v][axis] = sum / weight;
      }
    }
  }
  return next;
}

std::vector<char> heldIn(const oracle::Block& block, const std::vector<Probe>& probes)
{
  std::vector<char> held = block.anchored;
  for (const oracle::Handle& handle : handles(block, probes))
  {
    for (const std::size_t v : handle.elements)
    {
      held[v] = 1;
    }
  }
  return held;
}

TEST(Paper, EqualsAPlainRunStepByStep)
{
  for (const double recovery : { 1.0, 0.8 })
  {
    for (const int axes : { 1, 3 })
    {
      SCOPED_TRACE(recovery);
      SCOPED_TRACE(axes);
      Scene scene = inclusionScene(13, axes, 200 + axes, 0.1);
      scene.grid.spacing = { 0.7, 1.0, 1.6 };
      scene.scalar[scene.grid.at(11, 10, 6)] = 1.0f;
      oracle::Block block = scene.block();
      block.slack = 1.0 - recovery;
      Simulation simulation = published(scene, recovery);
      Surface blade; // halfway through the block
      blade.points = { { 3.9, -1.0, -1.0 }, { 3.9, 20.0, -1.0 }, { 3.9, -1.0, 9.3 }, { 3.9, 20.0, 9.3 } };
      blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
      ASSERT_GT(simulation.cut(blade), 0u);
      takeLinks(block, links(simulation));
      const std::vector<Probe> probes{ corner(scene, { 1.4, -1.0, 2.0 }) };
      simulation.pull(probes);
      const std::vector<char> held = heldIn(block, probes);
      std::vector<oracle::Vector3> expected = state(simulation);
      for (int step = 1; step <= 60; ++step)
      {
        const std::vector<oracle::Vector3> before = expected;
        expected = iterate(block, held, before);
        const RelaxResult result = simulation.relax(1, 0.0);
        EXPECT_EQ(result.iterations, 1);
        const std::vector<oracle::Vector3> now = state(simulation);
        ASSERT_LT(largestDifference(block, now, expected), 1e-6) << "step " << step;
        ASSERT_NEAR(result.largestMove, largestDifference(block, expected, before), 2e-6) << "step " << step;
        const double energy = oracle::energy(block, now);
        ASSERT_NEAR(simulation.measure().energy, energy, 1e-4 * energy);
        ASSERT_NEAR(simulation.measure().maxLinkExcess, oracle::maxLinkExcess(block, now), 1e-6);
      }
      EXPECT_GT(largestDifference(block, expected, state(simulate(scene))), 0.5) << "nothing was pulled";
    }
  }
}

TEST(Paper, OneCallOfManyIterationsIsManyCallsOfOne)
{
  Scene scene = inclusionScene(13, 1, 205);
  scene.scalar[scene.grid.at(11, 10, 6)] = 1.0f;
  Simulation one = published(scene);
  Simulation many = published(scene);
  for (Simulation* simulation : { &one, &many })
  {
    simulation->pull({ corner(scene, { 1.4, -1.0, 2.0 }) });
  }
  EXPECT_EQ(one.relax(25, 0.0).iterations, 25);
  for (int step = 0; step < 25; ++step)
  {
    many.relax(1, 0.0);
  }
  EXPECT_TRUE(sameBits(displacements(one), displacements(many)));
}

TEST(Paper, BitsDoNotDependOnBricks)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene = inclusionScene(21, axes, 210 + axes);
    scene.scalar[scene.grid.at(19, 18, 10)] = 1.0f;
    Surface blade;
    blade.points = { { 10.4, -1.0, -1.0 }, { 10.4, 30.0, -1.0 }, { 10.4, -1.0, 12.3 }, { 10.4, 30.0, 12.3 } };
    blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
    std::vector<float> first;
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = published(scene, 0.9, brick);
      simulation.cut(blade);
      simulation.pull({ corner(scene, { 0.6, -0.8, 0.7 }) });
      simulation.relax(7, 0.0);
      simulation.relax(40, 1e-3);
      const std::vector<float> u = displacements(simulation);
      first = first.empty() ? u : first;
      EXPECT_TRUE(sameBits(u, first)) << axes << " axes, brick " << brick[0] << ' ' << brick[1] << ' ' << brick[2];
    }
  }
}

TEST(Paper, StopsAtItsToleranceAndSaysSo)
{
  const Scene scene = inclusionScene(12, 1, 71, 0.0);
  Simulation simulation = published(scene);
  RelaxResult result = simulation.relax(10, 1e-3);
  EXPECT_TRUE(result.converged) << "rest is an optimum";
  EXPECT_EQ(result.largestMove, 0.0);
  simulation.pull({ corner(scene, { 2.0, 1.0, -1.0 }) });
  result = simulation.relax(3, 1e-3);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_FALSE(result.converged);
  EXPECT_GT(result.largestMove, 1e-3);
  result = simulation.relax(5000, 1e-3);
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.largestMove, 1e-3);
  EXPECT_LT(result.iterations, 1000);
  EXPECT_GT(result.iterations, 3);
  EXPECT_EQ(simulation.relax(0, 1e-3).iterations, 0);
}

/// Solves eq. 7 without limits, directly: the weighted Laplacian of the free elements.
std::vector<oracle::Vector3> unlimitedOptimum(
  const oracle::Block& block, const std::vector<char>& held, const std::vector<oracle::Vector3>& start)
{
  std::vector<oracle::Vector3> result = start;
  std::vector<long> unknown(block.count(), -1);
  std::size_t unknowns = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && !held[v])
    {
      unknown[v] = static_cast<long>(unknowns++);
    }
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    oracle::Skyline matrix(unknowns);
    std::vector<double> right(unknowns, 0.0);
    for (const bool reserve : { true, false })
    {
      const auto put = [&](long a, long b, double w)
      { reserve ? matrix.reserve(std::max(a, b), std::min(a, b)) : matrix.add(std::max(a, b), std::min(a, b), w); };
      for (const oracle::Link& link : oracle::links(block))
      {
        const double w = 1.0 / (oracle::limit(block, link, axis) + 1e-6);
        const long i = unknown[link.from], j = unknown[link.to];
        if (i >= 0)
        {
          put(i, i, w);
          right[i] += reserve || j >= 0 ? 0.0 : w * start[link.to][axis];
        }
        if (j >= 0)
        {
          put(j, j, w);
          right[j] += reserve || i >= 0 ? 0.0 : w * start[link.from][axis];
        }
        if (i >= 0 && j >= 0)
        {
          put(i, j, -w);
        }
      }
    }
    matrix.factorise();
    matrix.solve(right);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (unknown[v] >= 0)
      {
        result[v][axis] = right[unknown[v]];
      }
    }
  }
  return result;
}

// Held tissue damps both the smooth and the alternating modes, so the iteration converges here: to the optimum of eq.
// 7, which ignores the limits of links.
TEST(Paper, ConvergesToTheOptimumWithoutLimitsAndLeavesThem)
{
  Scene scene = randomScene({ 9, 8, 8 }, 1, 220, 0.0, 0.0);
  scene.anchors.faces.fill(true);
  const oracle::Block block = scene.block();
  const std::vector<Probe> probes{ probeAt(scene, { 4, 4, 4 }, { 0.6, -0.5, 0.55 }) };
  Simulation simulation = published(scene);
  simulation.pull(probes);
  EXPECT_LT(simulation.measure().maxLinkExcess, 1e-5);
  const std::vector<oracle::Vector3> best = unlimitedOptimum(block, heldIn(block, probes), state(simulation));
  const RelaxResult result = simulation.relax(2000, 1e-7);
  EXPECT_TRUE(result.converged);
  const std::vector<oracle::Vector3> relaxed = state(simulation);
  // An iteration reduces the error by a few per cent, so the error is at most a hundred times the last move.
  EXPECT_LT(largestDifference(block, relaxed, best), 1e-5);
  EXPECT_NEAR(oracle::energy(block, relaxed), oracle::energy(block, best), 1e-4 * oracle::energy(block, best));
  const double excess = oracle::maxLinkExcess(block, relaxed);
  EXPECT_GT(excess, 0.05);
  EXPECT_NEAR(simulation.measure().maxLinkExcess, excess, 1e-5);

  // The optimum within the limits has more energy.
  Simulation projected = simulate(scene);
  projected.pull(probes);
  projected.relax(2000, 0.0);
  EXPECT_GT(projected.measure().energy, 1.02 * simulation.measure().energy);
}

// A checkerboard in free tissue: red and black elements exchange their displacements in every iteration, without end.
TEST(Paper, CheckerboardFlipsForEver)
{
  const int n = 6;
  Scene scene({ n, n, n }, 0.3f);
  std::vector<Probe> probes;
  scene.each(
    [&](int i, int j, int k)
    {
      const double u = (i + j + k) % 2 == 0 ? 0.125 : -0.125;
      probes.push_back(probeAt(scene, { i, j, k }, { u, -u, u }));
    });
  Simulation simulation = published(scene);
  simulation.pull(probes);
  const oracle::Block block = scene.block();
  const std::vector<oracle::Vector3> board = state(simulation);
  EXPECT_EQ(board[0][0], 0.125);
  simulation.pull({});
  const double energy = simulation.measure().energy;
  for (const int steps : { 1, 1, 1, 500, 500, 1 })
  {
    const std::vector<oracle::Vector3> before = state(simulation);
    const RelaxResult result = simulation.relax(steps, 1e-3);
    EXPECT_EQ(result.iterations, steps);
    EXPECT_NEAR(result.largestMove, 0.25, 1e-4);
    const std::vector<oracle::Vector3> after = state(simulation);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      // Each mean is rounded. After a thousand iterations the error is far below 1e-4.
      ASSERT_NEAR(after[v][0], (steps % 2 == 0 ? 1.0 : -1.0) * before[v][0], 1e-4);
    }
    EXPECT_NEAR(simulation.measure().energy, energy, 1e-3 * energy);
  }
  // The projected method removes it: TestRelaxation, CheckerboardDecays.
}

// A bone that soft tissue pulls hardly moves. Each of its elements is held by its rigid neighbours, whose links have a
// hundred thousand times the weight.
TEST(Paper, BoneIsLocked)
{
  Scene scene({ 18, 9, 9 }, 0.3f);
  scene.anchors.faces[0] = true;
  for (int i = 5; i < 15; ++i)
  {
    for (int j = 3; j < 6; ++j)
    {
      for (int k = 3; k < 6; ++k)
      {
        scene.give(i, j, k, 0.0f);
      }
    }
  }
  const std::vector<Probe> probes{ probeAt(scene, { 10, 7, 4 }, { 0.0, 0.25, 0.0 }) };
  for (const bool projected : { false, true })
  {
    Simulation simulation = projected ? simulate(scene) : published(scene);
    simulation.pull(probes);
    simulation.relax(200, 0.0);
    const std::vector<oracle::Vector3> u = state(simulation);
    double low = 1.0;
    double high = -1.0;
    scene.each(
      [&](int i, int j, int k)
      {
        if (scene.constraint[scene.grid.at(i, j, k)] == 0.0f)
        {
          low = std::min(low, u[scene.grid.at(i, j, k)][1]);
          high = std::max(high, u[scene.grid.at(i, j, k)][1]);
        }
      });
    if (projected)
    {
      EXPECT_GT(low, 0.05);
      EXPECT_EQ(low, high) << "in one piece";
    }
    else
    {
      EXPECT_LT(high, 1e-4);
      EXPECT_GT(high, low) << "no two elements at the same place: it bends, by little";
    }
  }
}

// Only moved tissue and its surroundings are updated. Memory grows with the iterations, and a small pull in a large
// block needs little. Skipping bricks changes no bit (BitsDoNotDependOnBricks). Far from the pull all is exactly at
// rest.
TEST(Paper, TissueFarAwayIsNotVisited)
{
  Scene scene({ 96, 96, 96 }, 0.3f);
  Simulation simulation = published(scene, 1.0, { 8, 8, 8 });
  simulation.pull({ probeAt(scene, { 20, 20, 20 }, { 0.2, 0.1, -0.2 }) });
  simulation.relax(8, 1e-3);
  const Statistics statistics = simulation.measure();
  EXPECT_GT(statistics.displaced, 50u);
  EXPECT_LT(statistics.displaced, 6000u);
  EXPECT_LT(statistics.allocated, scene.grid.voxels() / 8);
}

// After the published method links exceed their limits. The projected method first repairs them and then runs as usual.
TEST(Paper, ProjectedAfterwardsIsFeasibleAgain)
{
  for (const std::uint64_t seed : { 230, 231 })
  {
    Scene scene = inclusionScene(13, 1, seed);
    scene.scalar[scene.grid.at(11, 10, 6)] = 1.0f;
    const oracle::Block block = scene.block();
    const std::vector<Probe> probes{ corner(scene, { 3.0, -2.5, 2.8 }) };
    Simulation simulation = published(scene);
    simulation.pull(probes);
    const std::vector<oracle::Vector3> pulled = state(simulation);
    simulation.relax(100, 0.0);
    ASSERT_GT(simulation.measure().maxLinkExcess, 0.05);
    const std::size_t bytes = simulation.measure().deviceBytes;
    simulation.setRelaxation(RelaxationMethod::Projected, 1.0);
    EXPECT_LT(simulation.measure().deviceBytes, bytes) << "the second copy of the state goes";

    simulation.relax(1, 0.0);
    std::vector<oracle::Vector3> now = state(simulation);
    EXPECT_LE(oracle::maxLinkExcess(block, now), 1e-5);
    double before = oracle::energy(block, now);
    for (int call = 0; call < 10; ++call)
    {
      simulation.relax(5, 0.0);
      now = state(simulation);
      ASSERT_LE(oracle::energy(block, now), before * (1.0 + 1e-6));
      ASSERT_LE(oracle::maxLinkExcess(block, now), 1e-5);
      before = oracle::energy(block, now);
    }
    simulation.relax(1500, 0.0);
    const std::vector<char> held = heldIn(block, probes);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      for (int a = 0; held[v] && a < 3; ++a)
      {
        ASSERT_EQ(state(simulation)[v][a], pulled[v][a]) << "held";
      }
    }
    const oracle::Optimum best = oracle::minimise(block, held, pulled);
    EXPECT_LT(oracle::energy(block, state(simulation)), 1.001 * best.energy);

    // The published method again.
    simulation.setRelaxation(RelaxationMethod::Paper, 1.0);
    simulation.relax(50, 0.0);
    EXPECT_GT(simulation.measure().maxLinkExcess, 0.05);
    simulation.reset();
    EXPECT_EQ(simulation.measure().displaced, 0u);
    EXPECT_TRUE(simulation.relax(5, 0.0).converged);
  }
}

}
