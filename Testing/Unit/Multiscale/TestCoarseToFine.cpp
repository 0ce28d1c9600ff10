// Relaxation that starts on coarser grids. The result is feasible, with lower energy than without them. Probes, anchors
// and rigid tissue keep their places and shapes, and cuts stay open. It needs far fewer sweeps.

#include "Blades.h"
#include "Scene.h"

#include <cmath>

namespace
{

using namespace chainmail;

// Float32 rounding of displacements of a few voxels. Errors of a coarse grid are 0.1 and more.
constexpr double tolerance = 1e-5;

std::vector<oracle::Vector3> relaxed(const Scene& scene, const std::vector<Probe>& probes, bool coarse, int sweeps,
  double* energy, const Surface* blade = nullptr, const Index3& brick = { 0, 0, 0 }, double error = 0.0)
{
  Simulation simulation = simulate(scene, brick);
  simulation.setCoarseToFine(coarse);
  if (blade)
  {
    simulation.cut(*blade);
  }
  simulation.pull(probes);
  const double before = simulation.measure().energy;
  simulation.relax(sweeps, 1e-6, error);
  *energy = simulation.measure().energy;
  EXPECT_LE(*energy, before * (1 + 1e-6));
  EXPECT_LE(simulation.measure().maxLinkExcess, tolerance);
  return state(simulation);
}

}

TEST(CoarseToFine, AFewSweepsGetNearTheOptimum)
{
  Scene scene({ 48, 44, 40 }, 0.25f);
  scene.anchors.faces[4] = true;
  const std::vector<Probe> probes{ probeAt(scene, { 24, 22, 36 }, { 4.0, 2.0, 3.0 }, 3.0) };
  double optimum = 0.0;
  double coarse = 0.0;
  double fine = 0.0;
  relaxed(scene, probes, true, 600, &optimum);
  relaxed(scene, probes, true, 10, &coarse);
  relaxed(scene, probes, false, 10, &fine);
  EXPECT_GE(coarse, optimum * (1 - 1e-6));
  EXPECT_LT(coarse, 1.05 * optimum);
  EXPECT_GT(fine, 1.5 * optimum); // otherwise there is nothing to gain
}

TEST(CoarseToFine, CorrectionsFindWhatSweepsLeave)
{
  // With 20 iterations there is room for a correction, with 19 there is not, and sweeps take its place. Where bones can
  // move, 16 more sweeps come first. They leave so little that a correction has to be asked for.
  for (const bool bones : { false, true })
  {
    Scene scene = randomScene({ 72, 60, 50 }, 1, 4500, 0.0, 0.0);
    scene.each(
      [&](int i, int j, int k)
      {
        const bool isAir = std::abs(i - 36) < 3 && j > 12 && k > 10; // so the pull goes round a slit
        const bool isBone = std::hypot(i - 36, j - 6, k - 25) < 5 || std::hypot(i - 52, j - 40, k - 25) < 8;
        scene.give(i, j, k, isAir ? -INFINITY : isBone && bones ? 0.0f : i < 30 ? 0.15f : 0.35f);
        scene.scalar[scene.grid.at(i, j, k)] = isAir ? 0.0f : 1.0f;
      });
    scene.anchors.faces[0] = true;
    const std::vector<Probe> probes{ probeAt(scene, { 60, 40, 35 }, { 5.0, -3.0, 4.0 }, 3.0) };
    double optimum = 0.0;
    double energy = 0.0;
    const auto rest = relaxed(scene, probes, true, 1500, &optimum);
    const auto error = [&](int iterations)
    {
      double square = 0.0;
      const auto u = relaxed(scene, probes, true, iterations, &energy, nullptr, { 0, 0, 0 }, 1e-6);
      for (std::size_t v = 0; v < u.size(); ++v)
      {
        for (int a = 0; a < 3; ++a)
        {
          square += std::pow(u[v][a] - rest[v][a], 2);
        }
      }
      return std::sqrt(square / static_cast<double>(u.size()));
    };
    const double without = error(bones ? 35 : 19);
    const double with = error(bones ? 36 : 20);
    EXPECT_GE(energy, optimum * (1 - 1e-6)) << bones;
    EXPECT_GT(without, 0.005) << "hardly anything is left to correct";
    EXPECT_LT(with, (bones ? 0.85 : 0.6) * without) << bones; // one more sweep instead gives 0.97
  }
}

// With a rigid cluster that can move, as in the first scene, sweeps come before the corrections.
TEST(CoarseToFine, EndsNearTheOptimum)
{
  for (const bool rigid : { true, false })
  {
    Scene scene({ 45, 37, 30 }, 0.2f);
    scene.each(
      [&](int i, int j, int k)
      {
        const bool isBone = std::pow(i - 20, 2) + std::pow(j - 18, 2) + std::pow(k - 14, 2) < 36;
        scene.give(i, j, k, isBone && rigid ? 0.0f : i < 20 ? 0.15f : 0.35f);
      });
    scene.anchors.faces[0] = true;
    const std::vector<Probe> probes{ probeAt(scene, { 38, 24, 20 }, { 4.0, -3.0, 2.0 }, 2.0) };
    double energy = 0.0;
    const auto rest = relaxed(scene, probes, true, 3000, &energy);
    const auto near = [&](double error, const Index3& brick, RelaxResult& result)
    {
      Simulation simulation = simulate(scene, brick);
      simulation.setCoarseToFine(true);
      simulation.pull(probes);
      result = simulation.relax(500, 0.0, error);
      EXPECT_LE(simulation.measure().maxLinkExcess, tolerance);
      const auto u = state(simulation);
      if (result.converged)
      {
        EXPECT_EQ(simulation.relax(500, 0.0, error).iterations, 0);
        EXPECT_EQ(state(simulation), u);
        EXPECT_EQ(simulation.relax(5, 0.0).iterations, 5); // where no distance is asked for
      }
      return u;
    };
    int before = 0;
    for (const double error : { 1e-2, 1e-3 })
    {
      RelaxResult result;
      const auto u = near(error, { 0, 0, 0 }, result);
      EXPECT_TRUE(result.converged);
      EXPECT_GT(result.iterations, before);
      before = result.iterations;
      double square = 0.0;
      double largest = 0.0;
      for (std::size_t v = 0; v < u.size(); ++v)
      {
        double length = 0.0;
        for (int a = 0; a < 3; ++a)
        {
          square += std::pow(u[v][a] - rest[v][a], 2);
          length += std::pow(rest[v][a], 2);
        }
        largest = std::max(largest, length);
      }
      const double distance = std::sqrt(square / static_cast<double>(u.size()) / largest);
      EXPECT_LT(distance, error) << rigid;
      EXPECT_GT(distance, 0.01 * error) << rigid; // or it went on for too long
      for (const Index3& brick : brickSizes())
      {
        RelaxResult other;
        EXPECT_EQ(near(error, brick, other), u) << brick[0];
        EXPECT_EQ(other.iterations, result.iterations) << brick[0];
      }
    }
  }
}

// The estimate is one of the scene as it was then.
TEST(CoarseToFine, WhatIsReleasedGoesBack)
{
  Scene scene({ 40, 34, 30 }, 0.3f);
  scene.anchors.faces[0] = true;
  Simulation simulation = simulate(scene);
  simulation.setCoarseToFine(true);
  const Probe probe = probeAt(scene, { 30, 16, 16 }, { 4.0, -3.0, 2.0 }, 2.0);
  const Probe other = probeAt(scene, { 20, 8, 8 }, { 1.0, 0.0, 0.0 }, 1.0);
  for (const std::vector<Probe>& left : { std::vector<Probe>(), std::vector<Probe>{ other } })
  {
    simulation.pull({ probe, other });
    EXPECT_TRUE(simulation.relax(500, 0.0, 0.01).converged);
    const double before = simulation.measure().energy;
    simulation.pull(left);
    EXPECT_GT(simulation.relax(500, 0.0, 0.01).iterations, 0);
    EXPECT_LT(simulation.measure().energy, 0.2 * before);
  }
}

TEST(CoarseToFine, CorrectionsDoNotDependOnBricks)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 45, 37, 30 }, axes, 4510 + axes, 0.1, 0.0);
    scene.anchors.faces[2] = true;
    const std::vector<Probe> probes = compatibleProbes(scene, 2, 4.0, 4520 + axes);
    Surface blade;
    blade.points = { { 20.3, 10, -1 }, { 20.3, 40, -1 }, { 20.3, 40, 31 }, { 20.3, 10, 31 } };
    blade.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
    double energy = 0.0;
    const auto u = relaxed(scene, probes, true, 40, &energy, &blade);
    EXPECT_LE(oracle::maxLinkExcess(scene.block(), relaxed(scene, probes, true, 40, &energy)), tolerance);
    const std::vector<Index3> sizes = axes == 1 ? brickSizes() : std::vector<Index3>{ { 8, 4, 8 } };
    for (const Index3& brick : sizes)
    {
      EXPECT_EQ(relaxed(scene, probes, true, 40, &energy, &blade, brick), u) << brick[0];
    }
  }
}

// Progress is reported before each launch of a sweep. A correction makes 30 sweeps on each of three coarser grids, and
// launches none of them in vain, however little its elements move.
TEST(CoarseToFine, ACorrectionLaunchesItsSweepsOnce)
{
  Scene scene = randomScene({ 40, 34, 30 }, 1, 4530, 0.1, 0.0);
  scene.anchors.faces[0] = true;
  const auto calls = [&](int iterations)
  {
    Simulation simulation = simulate(scene);
    simulation.setCoarseToFine(true);
    simulation.pull({ probeAt(scene, { 30, 16, 16 }, { 0.4, -0.3, 0.2 }, 2.0) });
    int count = 0;
    simulation.setProgress(
      [&](double)
      {
        ++count;
        return true;
      });
    simulation.relax(iterations, 0.0, 1e-6);
    return count;
  };
  const int more = calls(20) - calls(19); // 12 of the 20 iterations are a correction, in place of 15 sweeps of 19
  EXPECT_GT(more, 60);
  EXPECT_LT(more, 120);
}

TEST(CoarseToFine, ACorrectionThatWasStoppedLeavesNoTrace)
{
  Scene scene = randomScene({ 40, 34, 30 }, 1, 4530, 0.1, 0.0);
  scene.anchors.faces[0] = true;
  const std::vector<Probe> probes{ probeAt(scene, { 30, 16, 16 }, { 4.0, -3.0, 2.0 }, 2.0) };
  Simulation simulation = simulate(scene);
  simulation.setCoarseToFine(true);
  int calls = 0;
  int most = 1 << 30;
  simulation.setProgress([&](double) { return ++calls <= most; });
  const auto relax = [&]
  {
    simulation.pull(probes);
    calls = 0;
    simulation.relax(40, 0.0);
  };
  relax();
  const std::vector<float> expected = displacements(simulation);
  const int all = calls;
  ASSERT_GT(all, 20);
  simulation.reset();
  for (int n = 1; n < all; n += std::max(1, all / 25))
  {
    simulation.pull(probes);
    calls = 0;
    most = n;
    EXPECT_THROW(simulation.relax(40, 0.0), Aborted) << n;
    most = 1 << 30;
    relax();
    EXPECT_TRUE(sameBits(displacements(simulation), expected)) << "stopped at call " << n << " of " << all;
    simulation.reset();
  }
}

TEST(CoarseToFine, StateStaysFeasibleAndHeldTissueStays)
{
  for (int seed = 0; seed < 8; ++seed)
  {
    const int axes = seed % 2 == 0 ? 1 : 3;
    const bool bones = seed < 4;
    const int sweeps = bones ? 3 : 24; // the latter with a correction
    Scene scene = randomScene({ 33, 21, 26 }, axes, 1200 + seed, 0.1, bones ? 0.05 : 0.0);
    // A bone as large as several coarse elements.
    scene.each(
      [&](int i, int j, int k)
      {
        if (bones && std::abs(i - 16) < 8 && std::abs(j - 10) < 3 && std::abs(k - 13) < 3)
        {
          scene.scalar[scene.grid.at(i, j, k)] = 1.0f;
          scene.give(i, j, k, 0.0f);
        }
      });
    scene.anchors.faces[0] = true;
    scene.grid.spacing = { 0.7, 1.1, 2.0 };
    const oracle::Block block = scene.block();
    const std::vector<Probe> probes = compatibleProbes(scene, 3, 4.0, 1210 + seed);
    double energy = 0.0;
    const auto u = relaxed(scene, probes, true, sweeps, &energy);
    EXPECT_LE(oracle::maxLinkExcess(block, u), tolerance);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.anchored[v])
      {
        EXPECT_EQ(u[v], oracle::Vector3{});
      }
    }
    const auto handle = handles(block, probes);
    for (const oracle::Handle& h : handle)
    {
      for (const std::size_t v : h.elements)
      {
        for (int a = 0; a < 3; ++a)
        {
          EXPECT_NEAR(u[v][a], h.target[a], tolerance);
        }
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      const std::vector<int> label = oracle::clusters(block, a);
      std::vector<std::size_t> first;
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        if (label[v] >= 0)
        {
          if (static_cast<std::size_t>(label[v]) == first.size())
          {
            first.push_back(v);
          }
          EXPECT_EQ(u[v][a], u[first[label[v]]][a]);
        }
      }
    }
    double again = 0.0;
    EXPECT_EQ(relaxed(scene, probes, true, sweeps, &again), u) << "the same bits again";
  }
}

TEST(CoarseToFine, ACutStaysACut)
{
  // Two halves, one held and one pulled: no displacement crosses the cut.
  for (const double place : { 15.5, 16.5 }) // between two coarse elements, and through one
  {
    Scene scene({ 32, 24, 24 }, 0.3f);
    scene.anchors.faces[0] = true;
    Surface blade;
    blade.points = { { place, -1, -1 }, { place, 30, -1 }, { place, 30, 30 }, { place, -1, 30 } };
    blade.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
    double energy = 0.0;
    const auto u = relaxed(scene, { probeAt(scene, { 26, 12, 12 }, { 5.0, 3.0, 0.0 }) }, true, 200, &energy, &blade);
    scene.each(
      [&](int i, int j, int k)
      {
        const oracle::Vector3& v = u[scene.grid.at(i, j, k)];
        if (i < place)
        {
          EXPECT_LT(std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]), 0.02) << i;
        }
        else
        {
          // After a cut through coarse elements the finer grids have more to do.
          EXPECT_NEAR(v[0], 5.0, place == 15.5 ? 0.05 : 0.5) << i;
          EXPECT_NEAR(v[1], 3.0, place == 15.5 ? 0.05 : 0.5) << i;
        }
      });
  }
}

TEST(CoarseToFine, AHandAtItsLimitDragsNoAnchoredBone)
{
  // On coarser grids the tissue between them has fewer links, so it stretches less.
  Scene scene({ 32, 32, 96 }, 0.45f);
  scene.anchors.faces[4] = scene.anchors.faces[5] = true;
  scene.each(
    [&](int i, int j, int k)
    {
      if (std::abs(i - 12) < 5 && std::abs(j - 16) < 5)
      {
        scene.give(i, j, k, 0.0f);
      }
    });
  for (const double sign : { 1.0, -1.0 })
  {
    const std::vector<Probe> probes{ probeAt(scene, { 25, 16, 60 }, { 9.0 * sign, 4.0 * sign, 2.0 * sign }, 4.0) };
    double energy = 0.0;
    const auto optimum = relaxed(scene, probes, true, 600, &energy);
    const auto few = relaxed(scene, probes, true, 5, &energy);
    double square = 0.0;
    for (std::size_t v = 0; v < few.size(); ++v)
    {
      for (int a = 0; a < 3; ++a)
      {
        square += std::pow(few[v][a] - optimum[v][a], 2);
      }
    }
    // measured: 0.02. If coarser grids drag the bone along: 0.3
    EXPECT_LT(std::sqrt(square / static_cast<double>(few.size())), 0.05) << sign;
  }
}

TEST(CoarseToFine, CarvesAndReleasesAreFollowed)
{
  Scene scene({ 30, 30, 20 }, 0.3f);
  scene.anchors.faces[0] = true;
  Simulation simulation = simulate(scene);
  simulation.setCoarseToFine(true);
  const Probe probe = probeAt(scene, { 20, 15, 10 }, { 3.0, 0.0, 0.0 });
  simulation.pull({ probe });
  simulation.relax(5, 0.0);
  Surface box;
  for (int n = 0; n < 8; ++n)
  {
    box.points.push_back({ n & 1 ? 14.5 : 9.5, n & 2 ? 40.0 : -10.0, n & 4 ? 40.0 : -10.0 });
  }
  box.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 }, { 2, 6, 3 },
    { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
  EXPECT_GT(simulation.carve(box), 0u);
  simulation.relax(100, 0.0);
  // No link connects the probe with the anchored face any more.
  EXPECT_LT(simulation.measure().energy, 0.05);
  simulation.pull({});
  simulation.relax(20, 0.0);
  simulation.restoreTopology();
  EXPECT_EQ(simulation.measure().displaced, 0u);
  simulation.relax(20, 0.0);
  EXPECT_EQ(simulation.measure().displaced, 0u);
}

TEST(CoarseToFine, WhereAllIsCarvedNothingHappens)
{
  const Scene scene({ 20, 18, 16 }, 0.3f);
  Simulation simulation = simulate(scene);
  simulation.setCoarseToFine(true);
  simulation.carve(box({ -10.0, -10.0, -10.0 }, { 40.0, 40.0, 40.0 }));
  EXPECT_FALSE(simulation.relax(5, 0.0).coarseStep);
  simulation.restoreTopology();
  simulation.pull({ probeAt(scene, { 10, 9, 8 }, { 3.0, 0.0, 0.0 }) });
  EXPECT_TRUE(simulation.relax(5, 0.0).coarseStep);
}

TEST(CoarseToFine, ComponentsWithoutLinksToMovingTissueStay)
{
  // A block that is pulled. Behind one voxel of air: specks, a held slab and a free slab. On coarser grids all of them
  // are connected with the block.
  Scene scene({ 40, 32, 32 }, 0.3f);
  scene.anchors.faces[4] = true;
  scene.each(
    [&](int i, int j, int k)
    {
      const bool specks = i > 21 && i < 30 && (i % 2 == 0 || j % 3 == 0 || k % 3 == 0);
      const bool looseSlabOnly = i > 31 && k == 0;
      if (i == 21 || i == 31 || specks || looseSlabOnly || (i == 30 && k < 4))
      {
        scene.air(i, j, k);
      }
    });
  Simulation simulation = simulate(scene);
  simulation.setCoarseToFine(true);
  simulation.pull({ probeAt(scene, { 18, 16, 24 }, { 4.0, 3.0, 2.0 }, 2.0) });
  const double before = simulation.measure().energy;
  simulation.relax(10, 0.0);
  EXPECT_LT(simulation.measure().energy, 0.5 * before);
  const auto u = state(simulation);
  std::size_t moved = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const oracle::Vector3& v = u[scene.grid.at(i, j, k)];
      if (i > 20)
      {
        EXPECT_EQ(v, oracle::Vector3{}) << i << " " << j << " " << k;
      }
      else
      {
        moved += v != oracle::Vector3{} ? 1 : 0;
      }
    });
  EXPECT_GT(moved, 15000u);
}

TEST(CoarseToFine, WhichComponentsStayDoesNotDependOnBricks)
{
  // Two blocks, one of them pulled, with a slab of air between them and a bridge at rest behind it. Loose tissue is
  // close to both; it fills some bricks and parts of others.
  Scene scene({ 32, 24, 24 }, 0.3f);
  scene.anchors.faces[4] = true;
  scene.each(
    [&](int i, int j, int k)
    {
      const bool loose = j >= 13 && k >= 13 && i < 30;
      const bool gap = (i == 15 && k >= 3) || (!loose && (j == 12 || k == 12) && j >= 12 && k >= 12 && i < 31) ||
                       (j >= 12 && k >= 12 && i >= 30);
      if (gap)
      {
        scene.air(i, j, k);
      }
    });
  std::vector<oracle::Vector3> first;
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    simulation.setCoarseToFine(true);
    simulation.pull({ probeAt(scene, { 10, 6, 16 }, { 3.0, 2.0, 1.5 }, 2.0) });
    simulation.relax(10, 0.0);
    const auto u = state(simulation);
    std::size_t moved = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        const bool loose = j >= 13 && k >= 13 && i < 30 && i != 15;
        const oracle::Vector3& v = u[scene.grid.at(i, j, k)];
        EXPECT_TRUE(!loose || v == oracle::Vector3{}) << i << " " << j << " " << k;
        moved += v != oracle::Vector3{} ? 1 : 0;
      });
    EXPECT_GT(moved, 5000u);
    EXPECT_TRUE(first.empty() || u == first) << brick[0] << " " << brick[1] << " " << brick[2];
    first = u;
  }
}

TEST(CoarseToFine, WhatWasCutOffIsNotDraggedAlong)
{
  // A lump that was cut out of held tissue and is still strained, next to the rest, which is pulled.
  Scene scene({ 32, 32, 32 }, 0.3f);
  scene.anchors.faces[4] = true;
  Simulation simulation = simulate(scene);
  const auto handle = [&](double reach) { return probeAt(scene, { 16, 16, 8 }, { reach, 0.0, 0.5 * reach }, 2.0); };
  simulation.pull({ handle(3.0) });
  simulation.relax(20, 0.0);
  Surface blade;
  blade.points = { { -9, -9, 12.4 }, { 49, -9, 18.4 }, { 49, 49, 24.4 }, { -9, 49, 18.4 } }; // oblique to every grid
  blade.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  simulation.cut(blade);
  const auto meanOfLump = [&]
  {
    const auto u = state(simulation);
    double sum = 0.0;
    int count = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        if (k > 12.4 + (i + 9 + j + 9) * 6.0 / 58.0)
        {
          sum += u[scene.grid.at(i, j, k)][0];
          ++count;
        }
      });
    return sum / count;
  };
  const double mean = meanOfLump();
  EXPECT_GT(mean, 0.1);
  simulation.setCoarseToFine(true);
  simulation.pull({ handle(9.0) });
  simulation.relax(10, 0.0);
  // Its strain relaxes, while its mean displacement hardly changes.
  EXPECT_NEAR(meanOfLump(), mean, 0.05);
}

TEST(CoarseToFine, ARoughCorrectionIsSmoothedNotDropped)
{
  // Lumps whose stiffness increases towards their middles, from soft tissue to bone, and a handle at its largest
  // displacement. The result of coarser grids is near the optimum. But in nearly rigid tissue it is so rough that its
  // energy is higher than that of the state before.
  Scene scene({ 40, 36, 32 }, 0.25f);
  scene.anchors.faces.fill(true);
  Random random(4202);
  struct Lump
  {
    double place[3];
    double radius;
  };
  std::vector<Lump> lumps;
  for (int n = 0; n < 12; ++n)
  {
    Lump lump{ { random(0, 40), random(0, 36), random(0, 32) }, random(3, 7) };
    random(0, 1);
    lumps.push_back(lump);
  }
  scene.each(
    [&](int i, int j, int k)
    {
      double hard = 0.0;
      for (const Lump& lump : lumps)
      {
        const double square =
          std::pow(i - lump.place[0], 2) + std::pow(j - lump.place[1], 2) + std::pow(k - lump.place[2], 2);
        hard = std::max(hard, 1.6 * (1.0 - square / (lump.radius * lump.radius)));
      }
      const double constraint = 0.25 * std::pow(1.0 - std::min(1.0, hard), 2);
      scene.give(i, j, k, constraint < 1e-3 ? 0.0f : static_cast<float>(constraint));
    });
  Random where(79);
  const chainmail::Index3 place{ 8 + where.below(24), 8 + where.below(20), 8 + where.below(16) };
  const std::vector<Probe> probes{ probeAt(scene, place, { 30.0, 20.0, -25.0 }, 2.5) };
  for (const int sweeps : { 20, 40 })
  {
    Simulation simulation = simulate(scene);
    simulation.pull(probes);
    EXPECT_FALSE(simulation.relax(sweeps, 0.0).coarseStep);
    const double fine = simulation.measure().energy;
    simulation.reset();
    simulation.setCoarseToFine(true);
    simulation.pull(probes);
    const RelaxResult result = simulation.relax(sweeps, 0.0);
    ASSERT_TRUE(result.coarseStep);
    EXPECT_EQ(*result.coarseStep, 1.0);
    EXPECT_EQ(result.iterations, sweeps);
    EXPECT_LE(simulation.measure().energy, (sweeps == 20 ? 0.99 : 1.0) * fine);
    EXPECT_LE(simulation.measure().maxLinkExcess, tolerance);
    EXPECT_FALSE(simulation.relax(1, 0.0).coarseStep) << "coarser grids have taken part already";
  }
}

TEST(CoarseToFine, WhereNothingMayMoveTheFineGridIsAlone)
{
  // Tissue that was let go settles, but nothing holds it.
  Scene scene = randomScene({ 28, 24, 20 }, 1, 4400, 0.1, 0.0);
  std::vector<std::vector<oracle::Vector3>> states;
  for (const bool coarse : { false, true })
  {
    Simulation simulation = simulate(scene);
    simulation.setCoarseToFine(coarse);
    simulation.pull({ probeAt(scene, { 14, 12, 10 }, { 4.0, -3.0, 2.0 }, 2.0) });
    simulation.hold({});
    EXPECT_GT(simulation.measure().energy, 0.0);
    EXPECT_FALSE(simulation.relax(10, 0.0).coarseStep);
    states.push_back(state(simulation));
  }
  EXPECT_EQ(states[0], states[1]);
}

TEST(CoarseToFine, TheEnergyNeverRises)
{
  // If the first sweeps are too few to smooth the correction of coarser grids, a part of it is applied.
  for (int seed = 0; seed < 6; ++seed)
  {
    Scene scene = randomScene({ 28, 24, 20 }, seed % 2 == 0 ? 1 : 3, 4300 + seed, 0.1, 0.2);
    scene.anchors.faces.fill(true);
    Simulation simulation = simulate(scene);
    simulation.setRelaxation(RelaxationMethod::Projected, seed < 4 ? 1.0 : 0.5);
    simulation.pull(compatibleProbes(scene, 2, 3.0, 4310 + seed));
    simulation.relax(30, 0.0);
    const double before = simulation.measure().energy;
    simulation.setCoarseToFine(true);
    simulation.setRelaxation(RelaxationMethod::Paper, 1.0); // and back: coarser grids take part again
    simulation.setRelaxation(RelaxationMethod::Projected, seed < 4 ? 1.0 : 0.5);
    const RelaxResult result = simulation.relax(1, 0.0);
    EXPECT_EQ(result.coarseStep.has_value(), before > 0.0);
    EXPECT_GE(result.coarseStep.value_or(0.0), 0.0);
    EXPECT_LE(result.coarseStep.value_or(0.0), 1.0);
    const double after = simulation.measure().energy;
    EXPECT_LE(after, before * (1 + 1e-6));
    EXPECT_NEAR(result.coarseDrop, before > 0.0 ? 1.0 - after / before : 0.0, 1e-6);
    EXPECT_LE(simulation.measure().maxLinkExcess, tolerance);
  }
}
