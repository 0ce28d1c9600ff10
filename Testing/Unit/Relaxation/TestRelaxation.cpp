// Relaxation against the certified optimum of the convex problem, and the invariants of every sweep.

#include "Inclusion.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// Engine and oracle on the same block after the same pull.
void expectOptimum(Scene& scene, const Vector3& displacement, const char* what, const Surface* blade = nullptr)
{
  SCOPED_TRACE(what);
  const Index3& n = scene.grid.size;
  scene.scalar[scene.grid.at(n[0] - 2, n[1] - 3, n[2] / 2)] = 1.0f;
  oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  if (blade)
  {
    simulation.cut(*blade);
    takeLinks(block, links(simulation));
  }
  const std::vector<Probe> probes{ corner(scene, displacement) };
  simulation.pull(probes);
  const std::vector<oracle::Vector3> pulled = state(simulation);
  std::vector<char> held = block.anchored;
  const std::size_t grabbed = handles(block, probes)[0].elements[0];
  held[grabbed] = 1;
  const oracle::Optimum best = oracle::minimise(block, held, pulled);
  ASSERT_LT(best.gap(), 1e-5) << "the oracle has no proof";
  ASSERT_GT(oracle::energy(block, pulled), 1.05 * best.energy) << "nothing to relax: a poor test";

  simulation.relax(3000, 0.0);
  const std::vector<oracle::Vector3> relaxed = state(simulation);
  const double energy = oracle::energy(block, relaxed);
  // At most 0.1 % above the optimum. Below the proven bound only by the float32 excess of links.
  EXPECT_LT(energy, 1.001 * best.energy);
  EXPECT_GT(energy, 0.9999 * best.bound);
  EXPECT_NEAR(simulation.measure().energy, energy, 1e-4 * energy);
  EXPECT_LE(oracle::maxLinkExcess(block, relaxed), 1e-5);
  EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_EQ(relaxed[grabbed][a], pulled[grabbed][a]); // held
  }
}

TEST(Relax, ReachesTheConstrainedOptimum)
{
  Scene scene = inclusionScene(16, 1, 11);
  expectOptimum(scene, { 0.6, -0.4, 0.3 }, "small pull");
  expectOptimum(scene, { 2.5, 2.0, -2.2 }, "large pull");
  expectOptimum(scene, { 50.0, -50.0, 50.0 }, "as far as the tissue goes");
}

TEST(Relax, ReachesTheOptimumOfAnisotropicTissueAndSpacing)
{
  Scene scene = inclusionScene(14, 3, 12);
  scene.grid.spacing = { 0.6, 1.0, 2.5 };
  expectOptimum(scene, { 0.5, -0.3, 0.9 }, "small pull");
  expectOptimum(scene, { 2.0, -2.0, 4.0 }, "large pull");
}

TEST(Relax, ReachesTheOptimumBehindACut)
{
  Scene scene = inclusionScene(15, 1, 13);
  Surface blade; // halfway through the block, through the rod
  blade.points = { { 7.4, -1.0, -1.0 }, { 7.4, 20.0, -1.0 }, { 7.4, -1.0, 9.3 }, { 7.4, 20.0, 9.3 } };
  blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
  expectOptimum(scene, { 0.8, -0.4, 0.3 }, "small pull", &blade);
  expectOptimum(scene, { 2.5, 2.0, -2.2 }, "large pull", &blade);
}

// Tissue stretched nearly to its limit has chains of links at their limits, whose elements can only move together.
// Updates of one element at a time stop up to 4 % above the optimum in these blocks, feasible and at rest.
TEST(Relax, ReachesTheOptimumWhereChainsOfLinksAreAtTheirLimits)
{
  for (const int seed : { 1000, 1002, 1004, 1009 })
  {
    SCOPED_TRACE(seed);
    const int n = 14;
    Scene scene = randomScene({ n, n, n }, 1, seed, 0.05, 0.0);
    for (int i = n / 5; i < n - n / 5; ++i)
    {
      for (int j : { n / 2, n / 2 + 1 })
      {
        scene.scalar[scene.grid.at(i, j, n / 2)] = 1.0f;
        scene.give(i, j, n / 2, 0.0f);
      }
    }
    scene.anchors.faces[0] = true;
    scene.scalar[scene.grid.at(n - 2, n - 3, n / 2)] = 1.0f;
    const oracle::Block block = scene.block();
    oracle::Handle far{ { scene.grid.at(n - 2, n - 3, n / 2) }, { 50.0, 50.0, 50.0 }, false };
    const double reach = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), { far }).reached[0][0];
    expectOptimum(scene, { 0.9 * reach, -0.6 * reach, 0.99 * reach }, "near the limit");
  }
}

TEST(Relax, EnergyNeverRisesAndEverySweepIsFeasible)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = inclusionScene(16, axes, 20 + axes);
    scene.scalar[scene.grid.at(14, 13, 8)] = 1.0f;
    const oracle::Block block = scene.block();
    Simulation simulation = simulate(scene);
    for (const Vector3& pull : { Vector3{ 0.5, 0.5, -0.5 }, Vector3{ 3.0, -3.0, 2.0 } })
    {
      simulation.pull({ corner(scene, pull) });
      double before = oracle::energy(block, state(simulation));
      for (int sweep = 0; sweep < 60; ++sweep)
      {
        EXPECT_EQ(simulation.relax(1, 0.0).iterations, 1);
        const std::vector<oracle::Vector3> now = state(simulation);
        const double energy = oracle::energy(block, now);
        // A sum of about ten thousand links, each rounded to 1e-7 of its value on the device. A sweep reduces the
        // energy by a hundred times as much here.
        ASSERT_LE(energy, before * (1.0 + 1e-6)) << "sweep " << sweep;
        ASSERT_LE(oracle::maxLinkExcess(block, now), 1e-5) << "sweep " << sweep;
        ASSERT_LE(simulation.measure().maxLinkExcess, 1e-5) << "sweep " << sweep;
        before = energy;
      }
    }
    // One call with many sweeps, too: omega rises within a call.
    simulation.pull({ corner(scene, { -2.0, 1.0, 2.0 }) });
    double before = oracle::energy(block, state(simulation));
    for (int call = 0; call < 6; ++call)
    {
      simulation.relax(25, 0.0);
      const double energy = oracle::energy(block, state(simulation));
      ASSERT_LE(energy, before * (1.0 + 1e-6));
      ASSERT_LE(simulation.measure().maxLinkExcess, 1e-5);
      before = energy;
    }
  }
}

// The published scheme inverts a checkerboard in every iteration. Here one is made by alternating probes, which are
// then released.
TEST(Relax, CheckerboardDecays)
{
  const int n = 8;
  Scene scene({ n, n, n }, 0.3f);
  scene.anchors.faces[0] = true;
  std::vector<Probe> probes;
  scene.each(
    [&](int i, int j, int k)
    {
      if (i > 0)
      {
        const double u = (i + j + k) % 2 == 0 ? 0.14 : -0.14;
        probes.push_back(probeAt(scene, { i, j, k }, { u, -u, u }));
      }
    });
  Simulation simulation = simulate(scene);
  simulation.pull(probes);
  const oracle::Block block = scene.block();
  const std::vector<oracle::Vector3> board = state(simulation);
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.index(v)[0] > 0)
    {
      ASSERT_NEAR(std::abs(board[v][0]), 0.14, 1e-7);
    }
  }
  simulation.pull({});
  const double before = oracle::energy(block, state(simulation));
  simulation.relax(2, 0.0);
  // After the first colour pass every red element is at the mean of its black neighbours. Only over-relaxation and the
  // border leave a part of the checkerboard.
  EXPECT_LT(oracle::energy(block, state(simulation)), 0.5 * before);
  simulation.relax(100, 0.0);
  EXPECT_LT(oracle::energy(block, state(simulation)), 1e-6 * before);
}

// A linear state between two held faces is the optimum of a homogeneous block: closed form.
TEST(Relax, HomogeneousStretchIsLinear)
{
  const int n = 12;
  Scene scene({ n, 6, 6 }, 0.4f);
  scene.anchors.faces[0] = true;
  std::vector<Probe> probes;
  for (int k = 0; k < 6; ++k)
  {
    for (int j = 0; j < 6; ++j)
    {
      probes.push_back(probeAt(scene, { n - 1, j, k }, { 2.2, -1.1, 0.55 }));
    }
  }
  Simulation simulation = simulate(scene);
  simulation.pull(probes);
  const RelaxResult result = simulation.relax(2000, 1e-6);
  EXPECT_TRUE(result.converged);
  const std::vector<oracle::Vector3> u = state(simulation);
  scene.each(
    [&](int i, int j, int k)
    {
      const auto& v = u[scene.grid.at(i, j, k)];
      // With a tolerance of 1e-6 for a sweep, the error is about ten times as large.
      EXPECT_NEAR(v[0], 0.2 * i, 2e-4);
      EXPECT_NEAR(v[1], -0.1 * i, 2e-4);
      EXPECT_NEAR(v[2], 0.05 * i, 2e-4);
    });
}

TEST(Relax, BoneMovesAsOneAndIsNotLocked)
{
  Scene scene({ 20, 12, 12 }, 0.3f);
  scene.anchors.faces[0] = true;
  for (int i = 4; i < 16; ++i)
  {
    scene.give(i, 6, 6, 0.0f);
  }
  for (int k = 3; k < 9; ++k)
  {
    scene.give(10, 6, k, 0.0f); // a cross
  }
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    simulation.pull({ probeAt(scene, { 18, 9, 6 }, { 0.4, 2.0, -1.6 }) });
    const std::vector<float> before = displacements(simulation);
    const std::size_t first = 3 * scene.grid.at(4, 6, 6);
    for (int call = 0; call < 8; ++call)
    {
      simulation.relax(call == 0 ? 1 : 20, 0.0);
      const std::vector<float> u = displacements(simulation);
      const std::vector<int> label = clusters(simulation);
      std::size_t members = 0;
      for (std::size_t v = 0; v < label.size(); ++v)
      {
        if (label[v] >= 0)
        {
          ++members;
          for (int a = 0; a < 3; ++a)
          {
            ASSERT_EQ(u[3 * v + a], u[first + a]) << "call " << call;
          }
        }
      }
      EXPECT_EQ(members, 12u + 5u);
    }
    const std::vector<float> u = displacements(simulation);
    EXPECT_GT(std::abs(u[first + 1] - before[first + 1]), 0.1f) << "locked";
  }
}

// A bone has the same bits alone and together with another one, with which the members are so many that every step of
// their pass is a launch of its own on a processor. Air lies between the two.
TEST(Relax, BonesOfFewMembersMoveLikeThoseOfMany)
{
  constexpr int between = 29; // the layer of air; the grid below it is too large to be relaxed in one launch
  std::vector<float> first;
  for (const bool withSecond : { false, true })
  {
    Scene scene({ 40, 30, 70 }, 0.3f);
    scene.anchors.faces[2] = true;
    scene.each(
      [&](int i, int j, int k)
      {
        if (k == between || (k > between && !withSecond))
        {
          scene.air(i, j, k);
        }
        else if (i >= 5 && i < 35 && j >= 5 && ((j < 10 && k >= 9 && k < 12) || (j < 25 && k >= 36 && k < 60)))
        {
          scene.give(i, j, k, 0.0f); // these bones have 450 and 14,400 members
        }
      });
    Simulation simulation = simulate(scene);
    std::vector<Probe> probes{ probeAt(scene, { 36, 15, 14 }, { 0.4, 2.0, -1.6 }) };
    if (withSecond)
    {
      probes.push_back(probeAt(scene, { 3, 27, 40 }, { 0.4, 1.0, -1.6 }));
    }
    simulation.pull(probes);
    const std::size_t ofBone = 3 * scene.grid.at(10, 7, 10);
    const float before = displacements(simulation)[ofBone + 1];
    simulation.relax(20, 0.0);
    std::vector<float> below = displacements(simulation);
    EXPECT_GT(std::fabs(below[ofBone + 1] - before), 1e-3f) << "the bone stays: a poor test";
    below.resize(3 * scene.grid.at(0, 0, between));
    first = first.empty() ? below : first;
    EXPECT_TRUE(sameBits(below, first));
  }
}

// Rods without contact to a probe or an anchor return to rest with their surroundings.
TEST(Relax, ReleasedBlockReturnsToItsAnchor)
{
  Scene scene = inclusionScene(12, 1, 44, 0.0);
  scene.scalar.assign(scene.scalar.size(), 1.0f);
  Simulation simulation = simulate(scene);
  simulation.pull({ corner(scene, { 2.0, -1.5, 1.0 }) });
  simulation.pull({});
  simulation.relax(3000, 1e-6);
  for (const float u : displacements(simulation))
  {
    ASSERT_NEAR(u, 0.0f, 1e-3f);
  }
}

TEST(Relax, BitsDoNotDependOnBricks)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = inclusionScene(21, axes, 50 + axes);
    scene.scalar[scene.grid.at(19, 18, 10)] = 1.0f;
    Surface blade;
    blade.points = { { 10.4, -1.0, -1.0 }, { 10.4, 30.0, -1.0 }, { 10.4, -1.0, 12.3 }, { 10.4, 30.0, 12.3 } };
    blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
    std::vector<float> first;
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      simulation.cut(blade);
      simulation.pull({ corner(scene, { 1.9, -2.3, 1.1 }) });
      simulation.relax(7, 0.0);
      simulation.relax(25, 1e-4);
      const std::vector<float> u = displacements(simulation);
      if (first.empty())
      {
        first = u;
      }
      EXPECT_TRUE(sameBits(u, first)) << axes << " axes, brick " << brick[0] << ' ' << brick[1] << ' ' << brick[2];
    }
  }
}

TEST(Relax, TwoRunsGiveTheSameBits)
{
  Scene scene = inclusionScene(16, 1, 60);
  std::vector<float> first;
  for (int run = 0; run < 2; ++run)
  {
    Simulation simulation = simulate(scene);
    simulation.pull({ corner(scene, { 1.9, -2.3, 1.1 }) });
    simulation.relax(40, 1e-3);
    if (run == 0)
    {
      first = displacements(simulation);
    }
    EXPECT_TRUE(sameBits(displacements(simulation), first));
  }
}

TEST(Relax, StopsAtItsToleranceAndSaysSo)
{
  Scene scene = inclusionScene(12, 1, 70, 0.0);
  Simulation simulation = simulate(scene);
  RelaxResult result = simulation.relax(10, 1e-3);
  EXPECT_TRUE(result.converged) << "rest is an optimum";
  EXPECT_EQ(result.largestMove, 0.0);
  EXPECT_LE(result.iterations, 1);

  simulation.pull({ corner(scene, { 2.0, 1.0, -1.0 }) });
  result = simulation.relax(3, 1e-3);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_FALSE(result.converged);
  EXPECT_GT(result.largestMove, 1e-3);

  result = simulation.relax(5000, 1e-3);
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.largestMove, 1e-3);
  EXPECT_GT(result.iterations, 3);
  EXPECT_LT(result.iterations, 1000);
  const std::vector<float> before = displacements(simulation);
  // Converged means that another sweep moves no element by more than the tolerance.
  simulation.relax(1, 0.0);
  const std::vector<float> after = displacements(simulation);
  for (std::size_t n = 0; n < before.size(); ++n)
  {
    ASSERT_LE(std::abs(after[n] - before[n]), 1.1e-3f);
  }

  EXPECT_EQ(simulation.relax(0, 1e-3).iterations, 0);
}

TEST(Relax, LargestMoveIsWhatMoved)
{
  Scene scene = inclusionScene(12, 1, 71, 0.0);
  Simulation simulation = simulate(scene);
  simulation.pull({ corner(scene, { 2.0, 1.0, -1.0 }) });
  for (int sweep = 0; sweep < 5; ++sweep)
  {
    const std::vector<float> before = displacements(simulation);
    const RelaxResult result = simulation.relax(1, 0.0);
    const std::vector<float> after = displacements(simulation);
    double largest = 0.0;
    for (std::size_t n = 0; n < before.size(); ++n)
    {
      largest = std::max(largest, static_cast<double>(std::abs(after[n] - before[n])));
    }
    EXPECT_NEAR(result.largestMove, largest, 1e-6);
  }
}

// The force is the gradient of the energy with respect to the handle's place. By the envelope theorem it is the change
// of the relaxed energy under a small change of the pull.
TEST(Relax, ForceIsTheGradientOfTheRelaxedEnergy)
{
  Scene scene = inclusionScene(12, 1, 80, 0.0);
  scene.grid.spacing = { 1.0, 0.5, 2.0 };
  const oracle::Block block = scene.block();
  const Vector3 pull{ 0.3, -0.2, 0.5 }; // so small that no limit is reached
  const auto relaxedEnergy = [&](const Vector3& t, Vector3* force)
  {
    Simulation simulation = simulate(scene);
    simulation.pull({ corner(scene, t) });
    simulation.relax(3000, 0.0);
    if (force)
    {
      *force = simulation.probes()[0].force;
    }
    return oracle::energy(block, state(simulation));
  };
  Vector3 force;
  relaxedEnergy(pull, &force);
  for (int a = 0; a < 3; ++a)
  {
    Vector3 more = pull, less = pull;
    const double step = 0.1 * pull[a];
    more[a] += step;
    less[a] -= step;
    const double slope = (relaxedEnergy(more, nullptr) - relaxedEnergy(less, nullptr)) / (2.0 * step);
    // The energy is quadratic here, so the central difference is exact. 1 % is for the error of 3000 sweeps in float32.
    EXPECT_NEAR(force[a], slope, 0.01 * std::abs(slope)) << a;
    EXPECT_GT(force[a] * pull[a], 0.0) << "the handle pulls outwards";
  }
}

}
