// Tissue and bones that rotate: against an optimum in double precision, against rotations of whole scenes, and the
// invariants of every sweep.

#include "RotationScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// The displacement of a point under a rotation by `degrees` about the y axis through another point [mm].
Vector3 rotationAboutY(const Vector3& at, const Vector3& middle, double degrees)
{
  const double angle = degrees * 3.14159265358979323846 / 180.0;
  const double x = at[0] - middle[0];
  const double z = at[2] - middle[2];
  return { x * std::cos(angle) + z * std::sin(angle) - x, 0.0, z * std::cos(angle) - x * std::sin(angle) - z };
}

TEST(Rotations, ReachesTheOptimumOfSmallPulls)
{
  Scene scene = inclusionScene(14, 1, 11);
  expectLinearOptimum(scene, { 0.006, -0.004, 0.008 }, "cubes");
  scene.grid.spacing = { 0.6, 1.0, 2.5 };
  expectLinearOptimum(scene, { 0.004, -0.004, 0.015 }, "elements that are no cubes");
}

// A free rod whose ends are rotated: all of it follows, without strain.
TEST(Rotations, RotatingTissueAsAWholeCostsNothing)
{
  Scene scene({ 13, 4, 4 }, 0.2f);
  scene.grid.spacing = { 1.0, 0.7, 1.2 };
  scene.give(6, 1, 1, 0.0f); // bones, one of a single voxel
  scene.give(8, 2, 2, 0.0f);
  scene.give(9, 2, 2, 0.0f);
  const Vector3 middle = { 6.0, 1.0, 1.8 };
  Simulation simulation = simulateRotations(scene);
  std::vector<Probe> probes;
  for (const Index3& at : { Index3{ 0, 0, 0 }, Index3{ 0, 3, 3 }, Index3{ 12, 0, 3 }, Index3{ 12, 3, 0 } })
  {
    Probe probe;
    probe.position = scene.place(at[0], at[1], at[2]);
    probes.push_back(probe);
  }
  double energy = 0.0;
  for (const double degrees : { 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0 })
  {
    for (Probe& probe : probes)
    {
      probe.displacement = rotationAboutY(probe.position, middle, degrees);
    }
    const std::vector<ProbeResult> reached = simulation.pull(probes);
    for (std::size_t n = 0; n < probes.size(); ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_NEAR(reached[n].reached[a], probes[n].displacement[a], 1e-4) << degrees << " degrees, probe " << n;
      }
    }
    energy = simulation.measure().energy;
    simulation.relax(2000, 0.0);
  }
  EXPECT_GT(energy, 1.0) << "the last step strained nothing: a poor test";
  EXPECT_LT(simulation.measure().energy, 1e-6);
  EXPECT_LT(simulation.measure().maxLinkExcess, 1e-5);
  EXPECT_LT(bend(simulation), 1e-4);
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  scene.each(
    [&](int i, int j, int k)
    {
      const Vector3 expected = rotationAboutY(scene.place(i, j, k), middle, 90.0);
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(u[scene.grid.at(i, j, k)][a], expected[a], 2e-3);
      }
    });
}

// Energy falls with every sweep, links keep within their limits and bones keep their shape, for every pull.
TEST(Rotations, EverySweepKeepsTheInvariants)
{
  for (const bool coarse : { false, true })
  {
    for (const double pull : { 0.5, 3.0, 50.0 })
    {
      SCOPED_TRACE(testing::Message() << pull << (coarse ? " with" : " without") << " coarser grids");
      Scene scene = cornerScene(15, 1, 21);
      Simulation simulation = simulateRotations(scene);
      simulation.setCoarseToFine(coarse);
      simulation.pull({ corner(scene, { pull, -0.7 * pull, 0.9 * pull }) });
      double last = simulation.measure().energy;
      for (int n = 0; n < 12; ++n)
      {
        simulation.relax(n < 6 ? 5 : 40, 0.0); // the first call has at least sweepsToJudge
        const Statistics now = simulation.measure();
        EXPECT_LE(now.energy, last * (1.0 + 1e-5)) << n;
        EXPECT_LE(now.maxLinkExcess, 2e-5) << n;
        last = now.energy;
      }
      EXPECT_LT(bend(simulation), 1e-4);
    }
  }
}

TEST(Rotations, BitsDoNotDependOnBricks)
{
  Scene scene = cornerScene(15, 1, 22);
  std::vector<float> first;
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulateRotations(scene, brick);
    simulation.pull({ corner(scene, { 2.0, -1.0, 1.5 }) });
    simulation.relax(60, 1e-4);
    const std::vector<float> u = displacements(simulation);
    first = first.empty() ? u : first;
    EXPECT_TRUE(sameBits(u, first));
  }
}

TEST(Rotations, TheDefaultIsOff)
{
  Scene scene = cornerScene(12, 1, 23);
  Simulation off = simulate(scene);
  Simulation on = simulateRotations(scene);
  for (Simulation* simulation : { &off, &on })
  {
    simulation->pull({ corner(scene, { 1.0, 0.0, 0.0 }) });
  }
  EXPECT_GT(on.measure().deviceBytes, off.measure().deviceBytes); // the rotations of elements
  off.relax(50, 0.0);
  on.relax(50, 0.0);
  EXPECT_FALSE(sameBits(displacements(off), displacements(on)));
}

/// The rotation angles of boneScene()'s bone about each axis [rad], if they are small.
Vector3 anglesOf(const Simulation& simulation)
{
  const Grid& grid = simulation.model().grid();
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  const auto at = [&](int i, int j, int k) { return u[grid.at(i, j, k)]; };
  return { (at(6, 6, 7)[2] - at(6, 4, 7)[2]) / 2.0, (at(6, 4, 7)[2] - at(18, 4, 7)[2]) / 12.0,
    (at(18, 4, 7)[1] - at(6, 4, 7)[1]) / 12.0 };
}

TEST(Rotations, AProbeRotatesABoneAsFarAsItsGripAllows)
{
  const Scene scene = boneScene();
  const auto angles = [&](const std::vector<Probe>& probes)
  {
    Simulation simulation = simulateRotations(scene);
    simulation.pull(probes);
    simulation.relax(400, 0.0);
    EXPECT_LT(bend(simulation), 1e-4);
    EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
    return anglesOf(simulation);
  };
  // One voxel at the end of the bone: the bone rotates about it.
  const Vector3 ball = angles({ onBone(scene, 18, 5, 8, { 0.0, 0.0, 0.8 }) });
  EXPECT_LT(ball[1], -0.02);
  EXPECT_NEAR(ball[0], 0.0, 1e-3);
  EXPECT_NEAR(ball[2], 0.0, 1e-3);
  // Two neighbouring voxels: it rotates about the axis through them.
  const Vector3 hinge =
    angles({ onBone(scene, 18, 4, 8, { 0.0, 0.6, 0.8 }), onBone(scene, 18, 6, 8, { 0.0, 0.6, 0.8 }) });
  EXPECT_LT(hinge[1], -0.02);
  EXPECT_NEAR(hinge[0], 0.0, 1e-5);
  EXPECT_NEAR(hinge[2], 0.0, 1e-5);
  // The whole end: it only translates.
  for (const double angle : angles({ onBone(scene, 18, 5, 8, { 0.0, 0.0, 0.8 }, 1.1) }))
  {
    EXPECT_EQ(angle, 0.0);
  }
  // The tissue above it: it translates and rotates.
  const Vector3 free = angles({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.1) });
  EXPECT_LT(free[1], -0.01);
}

// A bone has the same bits alone and together with another one, which has so many links that a processor cannot update
// both in one launch. Air lies between the two.
TEST(Rotations, BonesOfFewLinksRotateLikeThoseOfMany)
{
  constexpr int between = 17; // the layer of air
  std::vector<float> first;
  for (const bool withSecond : { false, true })
  {
    Scene scene({ 25, 11, 62 }, 0.35f);
    scene.anchors.faces[2] = true;
    scene.each(
      [&](int i, int j, int k)
      {
        if (k == between || (k > between && !withSecond))
        {
          scene.air(i, j, k);
        }
        else if (i >= 3 && i < 22 && j >= 3 && j < 8 && ((k >= 7 && k < 10) || (k >= 24 && k < 58)))
        {
          scene.give(i, j, k, 0.0f); // these bones have 334 and 1822 links to other tissue
        }
      });
    Simulation simulation = simulateRotations(scene);
    std::vector<Probe> probes{ onBone(scene, 21, 5, 12, { 0.0, 0.1, 0.8 }, 1.1) };
    if (withSecond)
    {
      probes.push_back(onBone(scene, 3, 9, 40, { 0.1, 0.3, 0.2 }));
    }
    simulation.pull(probes);
    simulation.relax(20, 0.0);
    EXPECT_LT(bend(simulation), 1e-4);
    EXPECT_GT(std::fabs(anglesOf(simulation)[1]), 1e-3) << "nothing rotates: a poor test";
    std::vector<float> below = displacements(simulation);
    below.resize(3 * scene.grid.at(0, 0, between));
    first = first.empty() ? below : first;
    EXPECT_TRUE(sameBits(below, first));
  }
}

TEST(Rotations, ABoneThatIsAnchoredStays)
{
  Scene scene = boneScene();
  for (int k = 0; k < 7; ++k)
  {
    scene.give(6, 5, k, 0.0f); // down to the face
  }
  Simulation simulation = simulateRotations(scene);
  simulation.setCoarseToFine(true);
  simulation.pull({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.1) });
  simulation.relax(40, 0.0);
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  for (int i = 6; i < 19; ++i)
  {
    EXPECT_EQ(u[scene.grid.at(i, 5, 8)], (oracle::Vector3{}));
  }
}

TEST(Rotations, ReachGrowsWithTheRotationOfBones)
{
  Scene scene = boneScene();
  scene.anchors.faces.fill(false);
  scene.anchors.faces[0] = true; // soft tissue is the joint between this face and the bone
  const std::vector<Probe> probes{ onBone(scene, 18, 5, 8, { 0.0, 0.0, 9.0 }) };
  Simulation off = simulate(scene);
  const double slides = off.pull(probes)[0].reached[2];
  Simulation on = simulateRotations(scene);
  const double rotates = on.pull(probes)[0].reached[2];
  EXPECT_GT(rotates, 1.05 * slides);
  EXPECT_LT(rotates, 4.0 * slides);
}

// A probe requests more than rotations allow. Relaxation then continues from the end of the settling within the pull,
// like after a pull that requests exactly what was reached.
TEST(Rotations, RelaxationGoesOnFromSettling)
{
  Scene scene({ 17, 17, 17 }, 0.2f);
  scene.anchors.faces[4] = true;
  Probe probe;
  probe.position = scene.place(8, 8, 16);
  probe.radius = 2.1;
  const auto settled = [&](double asked, int iterations)
  {
    probe.displacement[2] = asked;
    Simulation simulation = simulateRotations(scene);
    simulation.setCoarseToFine(true);
    const double reached = simulation.pull({ probe })[0].reached[2];
    simulation.relax(iterations, 0.0);
    return std::make_pair(reached, simulation.measure().energy);
  };
  constexpr int whileSettling = 4;
  constexpr int sweeps = 6;
  const auto [reached, energy] = settled(6.0, sweeps);
  ASSERT_LT(reached, 5.0);
  const auto [again, expected] = settled(reached, whileSettling + sweeps);
  EXPECT_NEAR(again, reached, 1e-5);
  EXPECT_NEAR(energy, expected, 1e-5 * expected);
}

// Coarser grids reach the same optimum with fewer sweeps.
TEST(Rotations, CoarseToFineComesToTheSameOptimumSooner)
{
  const Scene scene = boneScene();
  const auto energies = [&](bool coarse)
  {
    Simulation simulation = simulateRotations(scene);
    simulation.setCoarseToFine(coarse);
    simulation.pull({ onBone(scene, 18, 5, 12, { 0.2, 0.1, 0.8 }, 1.1) });
    const RelaxResult result = simulation.relax(10, 0.0);
    EXPECT_EQ(result.coarseStep.has_value(), coarse);
    const double soon = simulation.measure().energy;
    simulation.relax(1500, 0.0);
    return std::make_pair(soon, simulation.measure().energy);
  };
  const auto [fine, fineEnd] = energies(false);
  const auto [coarse, coarseEnd] = energies(true);
  EXPECT_NEAR(coarseEnd, fineEnd, 1e-3 * fineEnd);
  EXPECT_LT(coarse - fineEnd, 0.25 * (fine - fineEnd));
}

// Soft and stiff patches with bones, pulled to their limit. Rotations from coarser grids rotate the limits of links,
// and no state is within all of them. Then the earlier rotations are used, and the displacements from coarser grids are
// kept. The energy is 0.83 times that of the finest grid alone; otherwise it is 1.1 times.
TEST(Rotations, CoarseToFineGainsWhereRotationsContradictEachOther)
{
  const int n = 40;
  Scene scene({ n, n, n });
  Random random(1);
  scene.each(
    [&](int i, int j, int k)
    {
      const bool soft = (i / 4 + j / 4 + k / 4) % 2 == 0;
      scene.give(i, j, k, static_cast<float>(random(0.05, 0.25) + (soft ? 0.2 : 0.0)));
    });
  for (int along = n / 5; along < n - n / 5; ++along)
  {
    for (const int a : { 0, 1 })
    {
      for (const int b : { 0, 1 })
      {
        scene.give(along, n / 3 + a, n / 3 + b, 0.0f);
        scene.give(2 * n / 3 + a, along, 2 * n / 3 + b, 0.0f);
      }
    }
  }
  scene.anchors.faces[4] = true;
  const auto energy = [&](bool coarse)
  {
    Simulation simulation = simulateRotations(scene);
    simulation.setCoarseToFine(coarse);
    const Probe handle = onBone(scene, n / 2, n / 2, n - 1, { 16.0, 0.0, 8.0 }, 2.0);
    EXPECT_NEAR(simulation.pull({ handle })[0].reached[0], 6.7, 0.2) << "the tissue gives no more";
    simulation.relax(10, 0.0);
    EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
    EXPECT_LT(bend(simulation), 1e-4);
    return simulation.measure().energy;
  };
  const double ratio = energy(true) / energy(false);
  EXPECT_LT(ratio, 0.95);
  EXPECT_GT(ratio, 0.7);
}

TEST(Rotations, ReducedModelsKeepBonesStraight)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, 2);
  simulation.pull({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.5) });
  simulation.relax(200, 0.0);
  EXPECT_LT(bend(simulation), 1e-4);
  EXPECT_GT(std::fabs(anglesOf(simulation)[1]), 0.005);
}

// Anisotropic constraints: tissue rotates, bones only translate.
TEST(Rotations, ConstraintsByAxisKeepTheInvariants)
{
  Scene scene = cornerScene(13, 3, 24);
  Simulation simulation = simulateRotations(scene);
  simulation.setCoarseToFine(true);
  simulation.pull({ corner(scene, { 1.0, -0.7, 0.9 }) });
  double last = simulation.measure().energy;
  for (int n = 0; n < 8; ++n)
  {
    simulation.relax(10, 0.0);
    const Statistics now = simulation.measure();
    EXPECT_LE(now.energy, last * (1.0 + 1e-5)) << n;
    EXPECT_LE(now.maxLinkExcess, 1e-5) << n;
    last = now.energy;
  }
}

// The force on a probe is the derivative of the energy: by the difference of two pulls.
TEST(Rotations, ForcesAreTheSlopeOfTheEnergy)
{
  const Scene scene = boneScene();
  const auto settled = [&](double pull)
  {
    Simulation simulation = simulateRotations(scene);
    simulation.pull({ onBone(scene, 15, 5, 12, { 0.0, 0.0, pull }, 1.1) });
    simulation.relax(1500, 0.0);
    return std::make_pair(simulation.measure().energy, simulation.probes()[0].force[2]);
  };
  const double step = 0.02;
  const double slope = (settled(0.4 + step).first - settled(0.4 - step).first) / (2.0 * step);
  EXPECT_NEAR(settled(0.4).second, slope, 0.01 * slope);
}

TEST(Rotations, WhatHoldsAProbeIsFound)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateRotations(scene);
  simulation.pull({ onBone(scene, 15, 5, 12, { 0.0, 0.0, 30.0 }, 1.1) });
  simulation.relax(20, 0.0);
  const Limiter limiter = simulation.limiter(0);
  EXPECT_EQ(limiter.what, Limiter::What::Face);
  EXPECT_EQ(limiter.face, 4);
}

// Random tissue with rigid specks and bones, drags of several probes, cuts and releases. Links keep within their
// limits, relaxation neither raises the energy nor moves held tissue, and bones keep their shape. Bits do not depend on
// bricks until a probe is shortened: the rounding of a shortened wave depends on bricks, and relaxation between two
// waves amplifies the difference.
class RotationsOfRandomTissue : public testing::TestWithParam<int>
{
};

TEST_P(RotationsOfRandomTissue, KeepsTheInvariants)
{
  const std::uint64_t seed = static_cast<std::uint64_t>(GetParam());
  Random random(seed);
  Scene scene = randomScene(
    { random.between(6, 14), random.between(6, 14), random.between(1, 12) }, 1, seed + 1000, 0.1, random(0.0, 0.15));
  scene.grid.spacing = { random(0.5, 2.0), random(0.5, 2.0), random(0.5, 2.0) };
  for (bool& face : scene.anchors.faces)
  {
    face = random.oneIn(3);
  }
  const bool coarse = random.oneIn(2);
  Random more(seed + 2000); // a generator of its own, so the other random numbers remain the same
  const double poissonRatio = more.oneIn(2) ? 0.0 : more(0.0, 0.49);
  std::vector<Simulation> simulations;
  for (const Index3& brick : { Index3{ 4, 2, 2 }, Index3{ 32, 8, 8 } })
  {
    simulations.push_back(simulateRotations(scene, brick, 1, poissonRatio));
    simulations.back().setCoarseToFine(coarse);
  }
  std::vector<Probe> probes;
  bool allReached = true;
  const Index3& n = scene.grid.size;
  for (int step = 0; step < 6; ++step)
  {
    if (probes.empty() || random.oneIn(3))
    {
      Index3 at{ random.below(n[0]), random.below(n[1]), random.below(n[2]) };
      Probe probe;
      probe.position = scene.place(at[0], at[1], at[2]);
      probe.radius = random.oneIn(2) ? 0.0 : random(0.5, 3.0);
      probe.anchor = random.oneIn(5);
      probes.push_back(probe);
    }
    else if (random.oneIn(5))
    {
      probes.pop_back();
    }
    for (Probe& probe : probes)
    {
      for (double& part : probe.displacement)
      {
        part += random(-0.3, 0.3);
      }
    }
    Surface blade;
    if (random.oneIn(4))
    {
      const double x = random(0.0, n[0]) * scene.grid.spacing[0];
      const double deep = random(0.0, n[2]) * scene.grid.spacing[2];
      blade.points = { { x, -50.0, -50.0 }, { x + 0.1, 50.0, -50.0 }, { x, -50.0, deep }, { x + 0.1, 50.0, deep } };
      blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
    }
    std::vector<float> first;
    for (Simulation& simulation : simulations)
    {
      SCOPED_TRACE(testing::Message() << "step " << step);
      if (!blade.points.empty())
      {
        simulation.cut(blade);
      }
      try
      {
        simulation.pull(probes);
      }
      catch (const ProbeError&)
      {
        probes.pop_back(); // there is no tissue any more
        simulation.pull(probes);
      }
      double last = simulation.measure().energy;
      const std::vector<ProbeResult> before = simulation.probes();
      for (int part = 0; part < 3; ++part)
      {
        simulation.relax(6, 0.0);
        const Statistics now = simulation.measure();
        EXPECT_LE(now.energy, last * (1.0 + 1e-5) + 1e-9);
        EXPECT_LE(now.maxLinkExcess, 1e-4); // the rounding of a sequence of waves
        last = now.energy;
      }
      const std::vector<ProbeResult> after = simulation.probes();
      for (std::size_t p = 0; p < after.size(); ++p)
      {
        EXPECT_EQ(after[p].reached, before[p].reached);
        for (int a = 0; a < 3; ++a)
        {
          const double lack = probes[p].displacement[a] - after[p].reached[a];
          allReached = allReached && (probes[p].anchor || std::fabs(lack) < 1e-5);
        }
      }
      EXPECT_LT(bend(simulation), 1e-3);
      const std::vector<float> u = displacements(simulation);
      first = first.empty() ? u : first;
      EXPECT_TRUE(sameBits(u, first) || !allReached);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Some, RotationsOfRandomTissue, testing::Range(CHAINMAIL_LONG ? 1 : 2, 7));

TEST(Rotations, MethodsWithoutRotationsAreRefused)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateRotations(scene);
  EXPECT_THROW(simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Limit), InputError);
  EXPECT_THROW(simulation.setRelaxation(RelaxationMethod::Paper, 1.0), InputError);
  EXPECT_THROW(simulation.setRelaxation(RelaxationMethod::Projected, 0.8), InputError);
  simulation.setRelaxation(RelaxationMethod::Projected, 1.0);
}

}

// Until something rotates, waves have the same bits as without rotations, for any number of waves.
TEST(Rotations, WavesBeforeAnyRotationAreAsWithout)
{
  Scene scene = boneScene();
  Random random(24);
  scene.each(
    [&](int i, int j, int k)
    {
      if (scene.constraint[scene.grid.at(i, j, k)] > 0.0f)
      {
        scene.give(i, j, k, static_cast<float>(random(0.2, 0.4)));
      }
    });
  Simulation off = simulate(scene);
  Simulation on = simulateRotations(scene);
  for (const Vector3& to : { Vector3{ 1.3, -0.7, 0.9 }, Vector3{ 0.4, 0.8, -0.6 }, Vector3{ -0.3, 0.1, 0.7 } })
  {
    for (Simulation* simulation : { &off, &on })
    {
      const Vector3 reached = simulation->pull({ onBone(scene, 18, 5, 12, to, 1.1) })[0].reached;
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_NEAR(reached[a], to[a], 1e-5) << "tissue settles where a probe comes short";
      }
    }
    EXPECT_TRUE(sameBits(displacements(on), displacements(off)));
  }
  on.relax(10, 0.0);
  off.relax(10, 0.0);
  EXPECT_FALSE(sameBits(displacements(on), displacements(off))) << "nothing rotates: a poor test";
}
