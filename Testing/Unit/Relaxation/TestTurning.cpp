// Tissue and bones that turn: against an optimum in double precision, against rotations of everything, and the
// invariants of every sweep.

#include "TurningScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// Where a rotation by so many degrees about the y axis through a point takes another, less where that was [mm].
Vector3 turnedAboutY(const Vector3& at, const Vector3& middle, double degrees)
{
  const double angle = degrees * 3.14159265358979323846 / 180.0;
  const double x = at[0] - middle[0];
  const double z = at[2] - middle[2];
  return { x * std::cos(angle) + z * std::sin(angle) - x, 0.0, z * std::cos(angle) - x * std::sin(angle) - z };
}

TEST(Turning, ReachesTheOptimumOfSmallPulls)
{
  Scene scene = inclusionScene(14, 1, 11);
  expectLinearOptimum(scene, { 0.006, -0.004, 0.008 }, "cubes");
  scene.grid.spacing = { 0.6, 1.0, 2.5 };
  expectLinearOptimum(scene, { 0.004, -0.004, 0.015 }, "elements that are no cubes");
}

// A rod without anchors whose ends are taken along by a rotation: all of it follows, and nothing is strained.
TEST(Turning, TurningTissueAsAWholeCostsNothing)
{
  Scene scene({ 13, 4, 4 }, 0.2f);
  scene.grid.spacing = { 1.0, 0.7, 1.2 };
  scene.give(6, 1, 1, 0.0f); // bones, one of them of a single voxel
  scene.give(8, 2, 2, 0.0f);
  scene.give(9, 2, 2, 0.0f);
  const Vector3 middle = { 6.0, 1.0, 1.8 };
  Simulation simulation = simulateTurning(scene);
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
      probe.displacement = turnedAboutY(probe.position, middle, degrees);
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
      const Vector3 wanted = turnedAboutY(scene.place(i, j, k), middle, 90.0);
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(u[scene.grid.at(i, j, k)][a], wanted[a], 2e-3);
      }
    });
}

// Energy falls from sweep to sweep, links keep within their limits and bones keep their shape, however far the pull.
TEST(Turning, EverySweepKeepsTheInvariants)
{
  for (const bool coarse : { false, true })
  {
    for (const double pull : { 0.5, 3.0, 50.0 })
    {
      SCOPED_TRACE(testing::Message() << pull << (coarse ? " with" : " without") << " coarser grids");
      Scene scene = cornerScene(15, 1, 21);
      Simulation simulation = simulateTurning(scene);
      simulation.setCoarseToFine(coarse);
      simulation.pull({ corner(scene, { pull, -0.7 * pull, 0.9 * pull }) });
      double last = simulation.measure().energy;
      for (int n = 0; n < 12; ++n)
      {
        simulation.relax(n < 6 ? 5 : 40, 0.0); // at least sweepsToJudge at first
        const Statistics now = simulation.measure();
        EXPECT_LE(now.energy, last * (1.0 + 1e-5)) << n;
        EXPECT_LE(now.maxLinkExcess, 2e-5) << n;
        last = now.energy;
      }
      EXPECT_LT(bend(simulation), 1e-4);
    }
  }
}

TEST(Turning, BitsDoNotDependOnBricks)
{
  Scene scene = cornerScene(15, 1, 22);
  std::vector<float> first;
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulateTurning(scene, brick);
    simulation.pull({ corner(scene, { 2.0, -1.0, 1.5 }) });
    simulation.relax(60, 1e-4);
    const std::vector<float> u = displacements(simulation);
    first = first.empty() ? u : first;
    EXPECT_TRUE(sameBits(u, first));
  }
}

TEST(Turning, TheDefaultIsOff)
{
  Scene scene = cornerScene(12, 1, 23);
  Simulation off = simulate(scene);
  Simulation on = simulateTurning(scene);
  for (Simulation* simulation : { &off, &on })
  {
    simulation->pull({ corner(scene, { 1.0, 0.0, 0.0 }) });
  }
  EXPECT_GT(on.measure().deviceBytes, off.measure().deviceBytes); // of spins
  off.relax(50, 0.0);
  on.relax(50, 0.0);
  EXPECT_FALSE(sameBits(displacements(off), displacements(on)));
}

/// The angles that the bone of boneScene() turns by about each axis [rad], where they are small.
Vector3 anglesOf(const Simulation& simulation)
{
  const Grid& grid = simulation.model().grid();
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  const auto at = [&](int i, int j, int k) { return u[grid.at(i, j, k)]; };
  return { (at(6, 6, 7)[2] - at(6, 4, 7)[2]) / 2.0, (at(6, 4, 7)[2] - at(18, 4, 7)[2]) / 12.0,
    (at(18, 4, 7)[1] - at(6, 4, 7)[1]) / 12.0 };
}

TEST(Turning, AProbeTurnsABoneAsFarAsItsGripAllows)
{
  const Scene scene = boneScene();
  const auto angles = [&](const std::vector<Probe>& probes)
  {
    Simulation simulation = simulateTurning(scene);
    simulation.pull(probes);
    simulation.relax(400, 0.0);
    EXPECT_LT(bend(simulation), 1e-4);
    EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
    return anglesOf(simulation);
  };
  // One voxel at the end of the bone: it turns about it.
  const Vector3 ball = angles({ onBone(scene, 18, 5, 8, { 0.0, 0.0, 0.8 }) });
  EXPECT_LT(ball[1], -0.02);
  EXPECT_NEAR(ball[0], 0.0, 1e-3);
  EXPECT_NEAR(ball[2], 0.0, 1e-3);
  // Two voxels beside each other: it turns about the axis through them alone.
  const Vector3 hinge =
    angles({ onBone(scene, 18, 4, 8, { 0.0, 0.6, 0.8 }), onBone(scene, 18, 6, 8, { 0.0, 0.6, 0.8 }) });
  EXPECT_LT(hinge[1], -0.02);
  EXPECT_NEAR(hinge[0], 0.0, 1e-5);
  EXPECT_NEAR(hinge[2], 0.0, 1e-5);
  // The whole end: it only moves.
  for (const double angle : angles({ onBone(scene, 18, 5, 8, { 0.0, 0.0, 0.8 }, 1.1) }))
  {
    EXPECT_EQ(angle, 0.0);
  }
  // The tissue above it: it moves and turns.
  const Vector3 free = angles({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.1) });
  EXPECT_LT(free[1], -0.01);
}

// A bone gets the same bits alone and beside another one of so many links that a processor cannot turn both in one
// launch. Air lies between the two.
TEST(Turning, BonesOfFewLinksTurnAsThoseOfManyDo)
{
  constexpr int between = 17; // the layer of air
  std::vector<float> first;
  for (const bool beside : { false, true })
  {
    Scene scene({ 25, 11, 62 }, 0.35f);
    scene.anchors.faces[2] = true;
    scene.each(
      [&](int i, int j, int k)
      {
        if (k == between || (k > between && !beside))
        {
          scene.air(i, j, k);
        }
        else if (i >= 3 && i < 22 && j >= 3 && j < 8 && ((k >= 7 && k < 10) || (k >= 24 && k < 58)))
        {
          scene.give(i, j, k, 0.0f); // 334 and 1822 links leave these bones
        }
      });
    Simulation simulation = simulateTurning(scene);
    std::vector<Probe> probes{ onBone(scene, 21, 5, 12, { 0.0, 0.1, 0.8 }, 1.1) };
    if (beside)
    {
      probes.push_back(onBone(scene, 3, 9, 40, { 0.1, 0.3, 0.2 }));
    }
    simulation.pull(probes);
    simulation.relax(20, 0.0);
    EXPECT_LT(bend(simulation), 1e-4);
    EXPECT_GT(std::fabs(anglesOf(simulation)[1]), 1e-3) << "nothing turns: a poor test";
    std::vector<float> below = displacements(simulation);
    below.resize(3 * scene.grid.at(0, 0, between));
    first = first.empty() ? below : first;
    EXPECT_TRUE(sameBits(below, first));
  }
}

TEST(Turning, ABoneThatIsAnchoredStays)
{
  Scene scene = boneScene();
  for (int k = 0; k < 7; ++k)
  {
    scene.give(6, 5, k, 0.0f); // down to the face
  }
  Simulation simulation = simulateTurning(scene);
  simulation.setCoarseToFine(true);
  simulation.pull({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.1) });
  simulation.relax(40, 0.0);
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  for (int i = 6; i < 19; ++i)
  {
    EXPECT_EQ(u[scene.grid.at(i, 5, 8)], (oracle::Vector3{}));
  }
}

TEST(Turning, ReachGrowsWithTheRotationOfBones)
{
  Scene scene = boneScene();
  scene.anchors.faces.fill(false);
  scene.anchors.faces[0] = true; // a joint of soft tissue between this face and the bone
  const std::vector<Probe> probes{ onBone(scene, 18, 5, 8, { 0.0, 0.0, 9.0 }) };
  Simulation off = simulate(scene);
  const double slides = off.pull(probes)[0].reached[2];
  Simulation on = simulateTurning(scene);
  const double turns = on.pull(probes)[0].reached[2];
  EXPECT_GT(turns, 1.05 * slides);
  EXPECT_LT(turns, 4.0 * slides);
}

// A probe is asked for more than turning helps it to: relaxation goes on where the settling in between ended, as it
// would after a pull that is asked for no more than was reached.
TEST(Turning, RelaxationGoesOnFromSettling)
{
  Scene scene({ 17, 17, 17 }, 0.2f);
  scene.anchors.faces[4] = true;
  Probe probe;
  probe.position = scene.place(8, 8, 16);
  probe.radius = 2.1;
  const auto settled = [&](double asked, int iterations)
  {
    probe.displacement[2] = asked;
    Simulation simulation = simulateTurning(scene);
    simulation.setCoarseToFine(true);
    const double reached = simulation.pull({ probe })[0].reached[2];
    simulation.relax(iterations, 0.0);
    return std::make_pair(reached, simulation.measure().energy);
  };
  constexpr int ofSettling = 4;
  constexpr int sweeps = 6;
  const auto [reached, energy] = settled(6.0, sweeps);
  ASSERT_LT(reached, 5.0);
  const auto [again, expected] = settled(reached, ofSettling + sweeps);
  EXPECT_NEAR(again, reached, 1e-5);
  EXPECT_NEAR(energy, expected, 1e-5 * expected);
}

// Coarser grids come to the same optimum, sooner.
TEST(Turning, CoarseToFineComesToTheSameOptimumSooner)
{
  const Scene scene = boneScene();
  const auto energies = [&](bool coarse)
  {
    Simulation simulation = simulateTurning(scene);
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

// Soft and stiff patches with bones through them, pulled as far as they go: rotations that come from coarser grids turn
// the limits of links so that no state is within all of them. The rotations of before are taken in their place, and
// what coarser grids have moved is kept. Without that the energy is 1.1 times that of the finest grid alone; it is 0.83
// times.
TEST(Turning, CoarseToFineGainsWhereRotationsContradictEachOther)
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
    Simulation simulation = simulateTurning(scene);
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

TEST(Turning, ReducedModelsKeepBonesStraight)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateTurning(scene, { 0, 0, 0 }, 2);
  simulation.pull({ onBone(scene, 18, 5, 12, { 0.0, 0.0, 0.8 }, 1.5) });
  simulation.relax(200, 0.0);
  EXPECT_LT(bend(simulation), 1e-4);
  EXPECT_GT(std::fabs(anglesOf(simulation)[1]), 0.005);
}

// Constraints that differ by axis: tissue turns, bones move.
TEST(Turning, ConstraintsByAxisKeepTheInvariants)
{
  Scene scene = cornerScene(13, 3, 24);
  Simulation simulation = simulateTurning(scene);
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

// The force on a probe is the derivative of the energy: from pulls that differ a little.
TEST(Turning, ForcesAreTheSlopeOfTheEnergy)
{
  const Scene scene = boneScene();
  const auto settled = [&](double pull)
  {
    Simulation simulation = simulateTurning(scene);
    simulation.pull({ onBone(scene, 15, 5, 12, { 0.0, 0.0, pull }, 1.1) });
    simulation.relax(1500, 0.0);
    return std::make_pair(simulation.measure().energy, simulation.probes()[0].force[2]);
  };
  const double step = 0.02;
  const double slope = (settled(0.4 + step).first - settled(0.4 - step).first) / (2.0 * step);
  EXPECT_NEAR(settled(0.4).second, slope, 0.01 * slope);
}

TEST(Turning, WhatHoldsAProbeIsFound)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateTurning(scene);
  simulation.pull({ onBone(scene, 15, 5, 12, { 0.0, 0.0, 30.0 }, 1.1) });
  simulation.relax(20, 0.0);
  const HeldBy heldBy = simulation.heldBy(0);
  EXPECT_EQ(heldBy.what, HeldBy::What::Face);
  EXPECT_EQ(heldBy.face, 4);
}

// Random tissue with rigid specks and bones, drags of several probes, cuts and releases: whatever happens, links keep
// within their limits, relaxation never raises the energy nor moves what is held, bones stay straight, and bits do not
// depend on bricks until a probe comes less far than it asks: how a wave that is too long is shortened depends on
// bricks by rounding, and tissue that settles between it and the next makes more of that.
class RandomTurning : public testing::TestWithParam<int>
{
};

TEST_P(RandomTurning, KeepsTheInvariants)
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
  Random more(seed + 2000); // so that these scenes are those that they were without
  const double poissonRatio = more.oneIn(2) ? 0.0 : more(0.0, 0.49);
  std::vector<Simulation> simulations;
  for (const Index3& brick : { Index3{ 4, 2, 2 }, Index3{ 32, 8, 8 } })
  {
    simulations.push_back(simulateTurning(scene, brick, 1, poissonRatio));
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
        probes.pop_back(); // no tissue there any more
        simulation.pull(probes);
      }
      double last = simulation.measure().energy;
      const std::vector<ProbeResult> before = simulation.probes();
      for (int part = 0; part < 3; ++part)
      {
        simulation.relax(6, 0.0);
        const Statistics now = simulation.measure();
        EXPECT_LE(now.energy, last * (1.0 + 1e-5) + 1e-9);
        EXPECT_LE(now.maxLinkExcess, 1e-4); // what waves in a row may leave by rounding
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

INSTANTIATE_TEST_SUITE_P(Some, RandomTurning, testing::Range(CHAINMAIL_LONG ? 1 : 2, 7));

TEST(Turning, MethodsThatDoNotTurnAreRefused)
{
  const Scene scene = boneScene();
  Simulation simulation = simulateTurning(scene);
  EXPECT_THROW(simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Limit), InputError);
  EXPECT_THROW(simulation.setRelaxation(RelaxationMethod::Paper, 1.0), InputError);
  EXPECT_THROW(simulation.setRelaxation(RelaxationMethod::Projected, 0.8), InputError);
  simulation.setRelaxation(RelaxationMethod::Projected, 1.0);
}

}

// As long as nothing has turned waves are those of tissue that does not turn, to the bit, however many there are.
TEST(Turning, WavesBeforeAnythingTurnsAreAsWithout)
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
  Simulation on = simulateTurning(scene);
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
  EXPECT_FALSE(sameBits(displacements(on), displacements(off))) << "nothing turns: a poor test";
}
