// Probes with a rotation: their tissue follows the rigid motion, other tissue follows within its limits, and the
// limiter is named.

#include "../Figures.h"
#include "../RotationScene.h"
#include "Pose.h"

#include <cmath>

namespace
{

using namespace chainmail;

constexpr double pi = 3.14159265358979323846;
constexpr double degree = pi / 180.0;

/// The displaced position after a rotation by a rotation vector about a centre and then a shift; Rodrigues' formula.
Vector3 moved(const Vector3& place, const Vector3& centre, const Vector3& rotation, const Vector3& shift)
{
  const double angle = std::sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2]);
  Vector3 arm, axis{ 1.0, 0.0, 0.0 };
  double along = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    arm[a] = place[a] - centre[a];
    axis[a] = angle > 0.0 ? rotation[a] / angle : axis[a];
    along += axis[a] * arm[a];
  }
  Vector3 result;
  for (int a = 0; a < 3; ++a)
  {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    result[a] = centre[a] + shift[a] + std::cos(angle) * arm[a] + (1.0 - std::cos(angle)) * along * axis[a] +
                std::sin(angle) * (axis[b] * arm[c] - axis[c] * arm[b]);
  }
  return result;
}

Probe pose(const Scene& scene, const Index3& at, const Vector3& rotation, const Vector3& shift = {})
{
  Probe probe;
  probe.position = scene.place(at[0], at[1], at[2]);
  probe.centre = probe.position;
  probe.rotates = true;
  probe.rotation = rotation;
  probe.displacement = shift;
  return probe;
}

/// The largest distance of voxels from their places by the probe's rigid motion [mm], for voxels with `isHeld(i, j,
/// k)`.
template <typename F>
double offPose(const Scene& scene, const Simulation& simulation, const Probe& probe, const F& isHeld)
{
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  double worst = 0.0;
  scene.each(
    [&](int i, int j, int k)
    {
      if (!isHeld(i, j, k))
      {
        return;
      }
      const Vector3 rest = scene.place(i, j, k);
      const Vector3 expected = moved(rest, probe.centre, probe.rotation, probe.displacement);
      for (int a = 0; a < 3; ++a)
      {
        const double off = std::fabs(rest[a] + u[scene.grid.at(i, j, k)][a] - expected[a]);
        worst = off <= worst ? worst : off; // takes a NaN as well
      }
    });
  return worst;
}

bool isRigid(const Scene& scene, int i, int j, int k)
{
  return scene.constraint[scene.grid.at(i, j, k)] == 0.0f;
}

void expectAsked(const Probe& probe, const ProbeResult& result)
{
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_DOUBLE_EQ(result.rotated[a], probe.rotation[a]);
    EXPECT_DOUBLE_EQ(result.reached[a], probe.displacement[a]);
  }
}

// A bone in soft tissue has its pose at once, to rounding, and after relaxation, and the state is feasible. The pose
// back to rest restores the bone to the bit.
TEST(Poses, ABoneIsWhereItIsTold)
{
  Scene scene = boneScene();
  scene.grid.spacing = { 1.1, 0.9, 1.3 };
  const auto isBone = [&](int i, int j, int k) { return isRigid(scene, i, j, k); };
  for (const bool coarse : { false, true })
  {
    SCOPED_TRACE(coarse ? "coarse to fine" : "fine");
    Simulation simulation = simulateRotations(scene);
    simulation.setCoarseToFine(coarse);
    Probe probe = pose(scene, { 12, 5, 8 }, { 0.0, 12.0 * degree, 5.0 * degree }, { 0.3, -0.2, 0.4 });
    expectAsked(probe, simulation.pull({ probe })[0]);
    EXPECT_LT(offPose(scene, simulation, probe, isBone), 1e-5);
    const double pulled = simulation.measure().energy;
    simulation.relax(200, 0.0);
    const Statistics settled = simulation.measure();
    EXPECT_LT(settled.energy, 0.9 * pulled);
    EXPECT_GT(settled.energy, 0.0);
    EXPECT_LE(settled.maxLinkExcess, 2e-5);
    EXPECT_LT(offPose(scene, simulation, probe, isBone), 1e-5);
    EXPECT_LT(bend(simulation), 1e-4);

    probe.rotation = {};
    probe.displacement = {};
    expectAsked(probe, simulation.pull({ probe })[0]);
    EXPECT_EQ(offPose(scene, simulation, probe, isBone), 0.0);
    simulation.relax(2000, 0.0);
    EXPECT_LT(simulation.measure().energy, 1e-6 * pulled);
  }
}

// Free tissue follows any rotation in steps, also beyond half a revolution, and ends without strain.
TEST(Poses, FreeTissueFollowsAnyRotation)
{
  Scene scene({ 9, 8, 11 }, 0.2f);
  scene.grid.spacing = { 1.0, 1.2, 0.9 };
  for (int i = 3; i < 6; ++i)
  {
    for (int k = 4; k < 8; ++k)
    {
      scene.give(i, 4, k, 0.0f);
    }
  }
  bool coarse = false;
  for (const Vector3& rotation : { Vector3{ 0.0, 0.0, 90.0 * degree }, Vector3{ 200.0 * degree, 0.0, 0.0 },
         Vector3{ 100.0 * degree, -80.0 * degree, 60.0 * degree }, Vector3{ 0.0, -370.0 * degree, 0.0 } })
  {
    SCOPED_TRACE(testing::Message() << rotation[0] << ' ' << rotation[1] << ' ' << rotation[2]);
    Simulation simulation = simulateRotations(scene);
    coarse = !coarse;
    simulation.setCoarseToFine(coarse);
    const Probe probe = pose(scene, { 4, 4, 5 }, rotation, { 2.0, -3.0, 1.0 });
    expectAsked(probe, simulation.pull({ probe })[0]);
    EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
    simulation.relax(1500, 0.0);
    // Displacements are rounded to 1.2e-7 of the largest one, and sweeps leave ten times as much.
    EXPECT_LT(offPose(scene, simulation, probe, [](int, int, int) { return true; }), 1e-3);
    EXPECT_LT(simulation.measure().energy, 1e-5);
  }
}

// The bits are the same for every brick size.
TEST(Poses, BrickSizesGiveEqualBits)
{
  const Scene scene = boneScene();
  const Probe probe = pose(scene, { 12, 5, 8 }, { 0.0, 25.0 * degree, 10.0 * degree }, { 1.0, 0.5, -0.5 });
  std::vector<float> first;
  for (const Index3& brick : { Index3{ 8, 8, 8 }, Index3{ 16, 4, 8 }, Index3{ 32, 16, 16 } })
  {
    Simulation simulation = simulateRotations(scene, brick);
    simulation.setCoarseToFine(false);
    simulation.pull({ probe });
    simulation.relax(40, 0.0);
    const std::vector<float> u = displacements(simulation);
    first = first.empty() ? u : first;
    EXPECT_TRUE(u == first) << brick[0];
  }
}

// A probe's torque is the derivative of the relaxed energy with respect to the angle, its force that with respect to
// the displacement: compared with central differences. The pull is small, because links at their limits add forces.
// Sweeps leave the energy a little above the minimum.
TEST(Poses, TorqueIsTheDerivativeOfTheEnergy)
{
  Scene scene = boneScene();
  scene.grid.spacing = { 1.1, 0.9, 1.3 };
  for (const double poissonRatio : { 0.0, 0.3 })
  {
    SCOPED_TRACE(poissonRatio);
    Probe probe = pose(scene, { 12, 5, 8 }, { 0.8 * degree, 2.0 * degree, -0.6 * degree }, { 0.08, 0.04, -0.06 });
    probe.centre[0] += 3.0; // not the centre about which the bone rotates by itself
    const auto relaxed = [&](const Probe& asked, ProbeResult* result)
    {
      Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, 1, poissonRatio);
      simulation.pull({ asked });
      simulation.relax(800, 0.0);
      if (result)
      {
        *result = simulation.probes()[0];
      }
      return simulation.measure().energy;
    };
    ProbeResult result;
    const double energy = relaxed(probe, &result);
    ASSERT_GT(energy, 0.1);
    const double step = 0.004;
    for (int a = 0; a < 3; ++a)
    {
      // The rotation by R, followed by a small one about the axis, is given as a rotation vector.
      Probe more = probe, less = probe;
      const auto rotatedFurther = [&](double by)
      {
        Vector3 axis{};
        axis[a] = by;
        return rotationVectorOf(product(rotationBy(axis), rotationBy(probe.rotation)));
      };
      more.rotation = rotatedFurther(step);
      less.rotation = rotatedFurther(-step);
      const double torque = (relaxed(more, nullptr) - relaxed(less, nullptr)) / (2.0 * step);
      EXPECT_NEAR(result.torque[a], torque, 0.02 * energy) << a;
      more = less = probe;
      more.displacement[a] += step;
      less.displacement[a] -= step;
      const double force = (relaxed(more, nullptr) - relaxed(less, nullptr)) / (2.0 * step);
      EXPECT_NEAR(result.force[a], force, 0.02 * energy) << a;
    }
  }
}

// A bone between anchored ones rotates as far as the tissue between them allows, as a rigid body, and the holder is
// named.
TEST(Poses, WhatHoldsAProbeIsTold)
{
  Scene scene({ 17, 9, 9 }, 0.15f);
  for (int i = 4; i < 13; ++i)
  {
    scene.give(i, 4, 4, 0.0f);
  }
  scene.anchors.faces[4] = true;
  Simulation simulation = simulateRotations(scene);
  Probe probe = pose(scene, { 8, 4, 4 }, { 0.0, 60.0 * degree, 0.0 });
  const ProbeResult result = simulation.pull({ probe })[0];
  EXPECT_GT(result.rotated[1], 2.0 * degree);
  EXPECT_LT(result.rotated[1], 55.0 * degree);
  EXPECT_EQ(result.rotated[0], 0.0);
  probe.rotation = result.rotated;
  probe.displacement = result.reached;
  EXPECT_LT(offPose(scene, simulation, probe, [&](int i, int j, int k) { return isRigid(scene, i, j, k); }), 1e-5);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
  const Limiter holder = simulation.limiter(0);
  EXPECT_EQ(holder.what, Limiter::What::Face);
  EXPECT_EQ(holder.face, 4);
}

// Many bodies at once, each held at voxels of its own and about a centre of its own; other bodies stay at rest.
TEST(Poses, ManyBodiesGoTogether)
{
  Scene scene({ 12, 12, 42 }, 0.4f);
  std::vector<Probe> probes;
  for (int body = 0; body < 5; ++body)
  {
    const int z = 3 + 8 * body;
    auto voxels = std::make_shared<std::vector<std::size_t>>();
    for (int k = z; k < z + 4; ++k)
    {
      for (int j = 4; j < 8; ++j)
      {
        for (int i = 4; i < 8; ++i)
        {
          scene.give(i, j, k, i == 5 && j == 5 ? 0.4f : 0.0f); // marrow is soft and moves along
          voxels->push_back(scene.grid.at(i, j, k));
        }
      }
    }
    Probe probe = pose(scene, { 0, 0, 0 }, { (body % 2 == 0 ? 6.0 : -6.0) * degree, 3.0 * degree, 0.0 });
    probe.centre = scene.place(5, 5, z + 2);
    probe.voxels = voxels;
    probe.body = static_cast<std::uint64_t>(body) + 1;
    probes.push_back(probe);
  }
  scene.anchors.faces[4] = scene.anchors.faces[5] = true;
  Simulation simulation = simulateRotations(scene);
  const std::vector<ProbeResult> results = simulation.pull(probes);
  simulation.relax(40, 0.0);
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    expectAsked(probes[n], results[n]);
    const std::vector<std::size_t>& own = *probes[n].voxels;
    EXPECT_EQ(results[n].elements, own.size());
    const auto isOwn = [&](int i, int j, int k)
    { return std::binary_search(own.begin(), own.end(), scene.grid.at(i, j, k)); };
    EXPECT_LT(offPose(scene, simulation, probes[n], isOwn), 1e-5);
  }
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
}

// Stiff tissue in a notch of a bone moves along with it: it could neither rotate without moving nor move without
// rotating.
TEST(Poses, StiffTissueInANotchGoesAlong)
{
  Scene scene({ 17, 17, 17 }, 0.8f);
  const auto isNotch = [](int i, int j, int k) { return i >= 7 && i < 10 && j >= 7 && j < 9 && k >= 7 && k < 9; };
  for (int i = 7; i < 10; ++i)
  {
    for (int j = 5; j < 12; ++j)
    {
      for (int k = 5; k < 12; ++k)
      {
        scene.give(i, j, k, isNotch(i, j, k) ? 0.05f : j < 9 && k < 9 ? 0.8f : 0.0f);
      }
    }
  }
  scene.anchors.faces.fill(true);
  Simulation simulation = simulateRotations(scene);
  const Probe probe = pose(scene, { 8, 10, 10 }, { 35.0 * degree, 0.0, 0.0 });
  const ProbeResult result = simulation.pull({ probe })[0];
  expectAsked(probe, result); // 17 degrees if the notch is not part of the handle
  EXPECT_EQ(result.elements, 3u * (7 * 7 - 4 * 4 + 2 * 2));
  EXPECT_LT(
    offPose(scene, simulation, probe, [&](int i, int j, int k) { return isRigid(scene, i, j, k) || isNotch(i, j, k); }),
    1e-5);
  simulation.relax(40, 0.0);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);

  // It does so too if several probes request the rotation.
  simulation.reset();
  std::vector<Probe> corners;
  for (const Index3& at : { Index3{ 7, 11, 5 }, Index3{ 9, 5, 11 }, Index3{ 7, 11, 11 }, Index3{ 9, 9, 9 } })
  {
    Probe corner = pose(scene, at, {});
    const Vector3 goal = moved(corner.position, probe.centre, probe.rotation, {});
    for (int a = 0; a < 3; ++a)
    {
      corner.displacement[a] = goal[a] - corner.position[a];
    }
    corner.rotates = false;
    corners.push_back(corner);
  }
  const std::vector<ProbeResult> results = simulation.pull(corners);
  for (std::size_t n = 0; n < corners.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(results[n].reached[a], corners[n].displacement[a], 1e-4) << n;
    }
  }
}

// In a reduced model rigid voxels have the pose, too.
TEST(Poses, ReducedModels)
{
  Scene scene({ 24, 24, 24 }, 0.4f);
  for (int i = 8; i < 16; ++i)
  {
    for (int k = 10; k < 14; ++k)
    {
      scene.give(i, 12, k, 0.0f);
      scene.give(i, 13, k, 0.0f);
    }
  }
  const auto isBone = [&](int i, int j, int k) { return isRigid(scene, i, j, k); };
  for (const int reduction : { 2, 4 })
  {
    SCOPED_TRACE(reduction);
    Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, reduction);
    const Probe probe = pose(scene, { 12, 12, 12 }, { 20.0 * degree, 15.0 * degree, 0.0 }, { 1.0, 0.0, -1.0 });
    expectAsked(probe, simulation.pull({ probe })[0]);
    simulation.relax(20, 0.0);
    EXPECT_LT(offPose(scene, simulation, probe, isBone), 2e-5);
  }
}

// A ball of soft tissue is held at a pose.
TEST(Poses, SoftTissue)
{
  Scene scene({ 15, 15, 15 }, 0.4f);
  scene.anchors.faces.fill(true);
  Simulation simulation = simulateRotations(scene);
  Probe probe = pose(scene, { 7, 7, 7 }, { 0.0, 0.0, 25.0 * degree }, { 0.5, 0.0, 0.0 });
  probe.radius = 3.0;
  expectAsked(probe, simulation.pull({ probe })[0]);
  simulation.relax(30, 0.0);
  const auto isHeld = [](int i, int j, int k)
  { return (i - 7) * (i - 7) + (j - 7) * (j - 7) + (k - 7) * (k - 7) <= 9; };
  EXPECT_LT(offPose(scene, simulation, probe, isHeld), 1e-5);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
}

// Probes that are refused: one with a rotation where tissue does not rotate, and unusable rotations, centres and
// voxels.
TEST(Poses, WhatCannotBe)
{
  const Scene scene = boneScene();
  Probe probe = pose(scene, { 12, 5, 8 }, { 0.0, 0.1, 0.0 });
  {
    Simulation simulation = simulate(scene);
    EXPECT_THROW(simulation.hold({ probe }), ProbeError);
  }
  Simulation simulation = simulateRotations(scene);
  probe.rotation[1] = NAN;
  EXPECT_THROW(simulation.hold({ probe }), ProbeError);
  probe.rotation[1] = 1e4;
  EXPECT_THROW(simulation.hold({ probe }), ProbeError);
  probe.rotation[1] = 0.0;
  probe.centre[0] = INFINITY;
  EXPECT_THROW(simulation.hold({ probe }), ProbeError);
  probe.centre = probe.position;
  probe.voxels = std::make_shared<const std::vector<std::size_t>>();
  EXPECT_THROW(simulation.hold({ probe }), ProbeError);
}

/// Four probes on a bone with the targets of one rigid motion.
std::vector<Probe> fourProbes(const Scene& scene, const Vector3& rotation, const Vector3& shift)
{
  std::vector<Probe> probes;
  for (const Index3& at : { Index3{ 6, 5, 8 }, Index3{ 18, 5, 8 }, Index3{ 12, 4, 8 }, Index3{ 12, 6, 9 } })
  {
    Probe probe = pose(scene, at, {});
    const Vector3 goal = moved(probe.position, scene.place(12, 5, 8), rotation, shift);
    for (int a = 0; a < 3; ++a)
    {
      probe.displacement[a] = goal[a] - probe.position[a];
    }
    probe.rotates = false;
    probes.push_back(probe);
  }
  return probes;
}

// Several probes on a bone with the targets of one rigid motion give the bone this motion.
TEST(Poses, SeveralProbesRotateABone)
{
  Scene scene = boneScene();
  const Vector3 rotation{ 0.0, 14.0 * degree, 6.0 * degree };
  const Vector3 shift{ 0.4, 0.0, 0.3 };
  Simulation simulation = simulateRotations(scene);
  const std::vector<Probe> probes = fourProbes(scene, rotation, shift);
  const std::vector<ProbeResult> results = simulation.pull(probes);
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(results[n].reached[a], probes[n].displacement[a], 1e-4) << n;
    }
  }
  simulation.relax(40, 0.0);
  Probe motion = pose(scene, { 12, 5, 8 }, rotation, shift);
  EXPECT_LT(offPose(scene, simulation, motion, [&](int i, int j, int k) { return isRigid(scene, i, j, k); }), 1e-4);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
  EXPECT_LT(bend(simulation), 1e-4);

  // If no rigid motion fits the targets, the bone remains rigid and each probe comes near its target.
  std::vector<Probe> incompatible = probes;
  incompatible[0].displacement[0] -= 1.0;
  simulation.reset();
  const std::vector<ProbeResult> near = simulation.pull(incompatible);
  for (std::size_t n = 0; n < incompatible.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(near[n].reached[a], incompatible[n].displacement[a], 0.8) << n; // on average a quarter
    }
  }
  EXPECT_LT(bend(simulation), 1e-4);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
}

}
