// Tissue that is dragged in circles: rotations of any angle, also of half a revolution and more than one, are
// equivalent. The state after whole revolutions is the state before them.

#include "RotationScene.h"

#include <cmath>

namespace
{

using namespace chainmail;

constexpr double pi = 3.14159265358979323846;

/// The displacement of a point under a rotation by `degrees` about an axis of the grid through another point.
Vector3 circled(const Vector3& at, const Vector3& middle, int axis, double degrees)
{
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const double sine = std::sin(degrees * pi / 180.0), cosine = std::cos(degrees * pi / 180.0);
  const double y = at[b] - middle[b], z = at[c] - middle[c];
  Vector3 moved{};
  moved[b] = y * cosine - z * sine - y;
  moved[c] = y * sine + z * cosine - z;
  return moved;
}

/// Drags one voxel of a sheet around another, by two and a third revolutions, and back to the start. Invariants hold
/// after each update, and the state at each angle equals the state one revolution earlier.
void expectRevolutionsAlike(double stepDegrees)
{
  const Scene scene({ 1, 5, 8 }, 0.2f);
  Simulation simulation = simulateRotations(scene);
  Probe anchor = probeAt(scene, { 0, 2, 3 }, {});
  anchor.anchor = true;
  Probe probe = probeAt(scene, { 0, 2, 7 }, {});
  const int stepsPerRevolution = static_cast<int>(std::lround(360.0 / std::fabs(stepDegrees)));
  const int there = 2 * stepsPerRevolution + stepsPerRevolution / 3;
  std::vector<std::vector<oracle::Vector3>> ofAngle(stepsPerRevolution);
  double worst = 0.0;
  for (int step = 1; step <= 2 * there; ++step)
  {
    const int number = step <= there ? step : 2 * there - step;
    probe.displacement = circled(probe.position, anchor.position, 0, number * stepDegrees);
    const ProbeResult reached = simulation.pull({ anchor, probe })[1];
    for (int a = 0; a < 3; ++a)
    {
      ASSERT_NEAR(reached.reached[a], probe.displacement[a], 1e-3) << "step " << step << ": held back";
    }
    const double before = simulation.measure().energy;
    simulation.relax(60, 0.0);
    const Statistics now = simulation.measure();
    ASSERT_TRUE(std::isfinite(now.energy)) << "step " << step;
    EXPECT_LE(now.energy, before * (1.0 + 1e-5) + 1e-9) << "step " << step;
    ASSERT_LE(now.maxLinkExcess, 2e-5) << "step " << step;
    const std::vector<oracle::Vector3> u = millimetres(simulation);
    std::vector<oracle::Vector3>& last = ofAngle[number % stepsPerRevolution];
    for (std::size_t v = 0; v < u.size() && step > stepsPerRevolution + 1 && step <= there; ++v)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double off = std::fabs(u[v][a] - last[v][a]);
        worst = off <= worst ? worst : off; // takes a NaN as well
      }
    }
    last = u;
  }
  // Displacements are up to 10 voxels. Tissue that a step leaves behind differs slightly between revolutions.
  EXPECT_LT(worst, 0.2);
}

// A free sheet: all of it rotates about the anchored voxel without strain, at any angle.
TEST(FullRotations, ASheetGoesRound)
{
  for (const double degrees : { 10.0, -10.0, 3.0 })
  {
    SCOPED_TRACE(degrees);
    expectRevolutionsAlike(degrees);
  }
}

/// Rotates a block by its corners, by one and a half revolutions. From half a revolution on, at every further one, it
/// expects the exact places. The error is rounding: displacements are rounded to 1.2e-7 of the largest one, and a few
/// sweeps leave ten times as much.
void expectRotationOfEverything(const Scene& scene, double stepDegrees, int axis, double poissonRatio, bool coarse)
{
  const Index3& n = scene.grid.size;
  const Vector3 middle = scene.place(n[0] / 2, n[1] / 2, n[2] / 2);
  Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, 1, poissonRatio);
  simulation.setCoarseToFine(coarse);
  std::vector<Probe> probes;
  for (int corner = 0; corner < 8; ++corner)
  {
    probes.push_back(
      probeAt(scene, { corner & 1 ? n[0] - 1 : 0, corner & 2 ? n[1] - 1 : 0, corner & 4 ? n[2] - 1 : 0 }, {}));
  }
  const int half = static_cast<int>(std::lround(180.0 / std::fabs(stepDegrees)));
  for (int step = 1; step <= 3 * half; ++step)
  {
    SCOPED_TRACE(testing::Message() << "step " << step);
    for (Probe& probe : probes)
    {
      probe.displacement = circled(probe.position, middle, axis, step * stepDegrees);
    }
    simulation.pull(probes);
    simulation.relax(step % half == 0 ? 1500 : 80, 0.0);
    const Statistics now = simulation.measure();
    ASSERT_TRUE(std::isfinite(now.energy));
    ASSERT_LE(now.maxLinkExcess, 2e-5);
    if (step % half == 0)
    {
      double worst = 0.0;
      const std::vector<oracle::Vector3> u = millimetres(simulation);
      scene.each(
        [&](int i, int j, int k)
        {
          const Vector3 expected = circled(scene.place(i, j, k), middle, axis, step * stepDegrees);
          for (int a = 0; a < 3; ++a)
          {
            const double off = std::fabs(u[scene.grid.at(i, j, k)][a] - expected[a]);
            worst = off <= worst ? worst : off; // takes a NaN as well
          }
        });
      EXPECT_LT(worst, 1e-3);
      EXPECT_LT(now.energy, 1e-5);
      EXPECT_LT(bend(simulation), 1e-4);
    }
  }
}

// A block with bones, anisotropic elements and a Poisson's ratio.
TEST(FullRotations, ABlockWithBonesGoesRound)
{
  Scene scene({ 7, 8, 12 }, 0.2f);
  scene.grid.spacing = { 1.0, 0.8, 1.3 };
  for (int n = 2; n < 6; ++n)
  {
    scene.give(3, n, 4, 0.0f);
    scene.give(3, 5, n + 2, 0.0f);
  }
  scene.give(1, 1, 8, 0.0f);
  scene.give(5, 2, 9, 0.0f);
  expectRotationOfEverything(scene, 10.0, 0, 0.0, false);
  expectRotationOfEverything(scene, -9.0, 1, 0.3, false);
  expectRotationOfEverything(scene, 7.5, 2, 0.0, true);
}

}
