// Tissue that is dragged round in circles: every rotation, also half a turn and more than one, has to be as good as any
// other. The state after whole turns is the one before them.

#include "TurningScene.h"

#include <cmath>

namespace
{

using namespace chainmail;

constexpr double pi = 3.14159265358979323846;

/// Where a rotation by so many degrees about one axis of the grid through a point takes another, less where that was.
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

/// Drags one voxel of a sheet round another, twice and a third, and back to where it began. Each update has what holds
/// of all, and the state at each angle is the one a turn before.
void expectTurnsAlike(double stepDegrees)
{
  const Scene scene({ 1, 5, 8 }, 0.2f);
  Simulation simulation = simulateTurning(scene);
  Probe anchor = probeAt(scene, { 0, 2, 3 }, {});
  anchor.anchor = true;
  Probe probe = probeAt(scene, { 0, 2, 7 }, {});
  const int stepsPerTurn = static_cast<int>(std::lround(360.0 / std::fabs(stepDegrees)));
  const int there = 2 * stepsPerTurn + stepsPerTurn / 3;
  std::vector<std::vector<oracle::Vector3>> ofAngle(stepsPerTurn);
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
    std::vector<oracle::Vector3>& last = ofAngle[number % stepsPerTurn];
    for (std::size_t v = 0; v < u.size() && step > stepsPerTurn + 1 && step <= there; ++v)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double off = std::fabs(u[v][a] - last[v][a]);
        worst = off <= worst ? worst : off; // takes a NaN as well
      }
    }
    last = u;
  }
  // Displacements are of up to 10 voxels. Tissue that a step leaves behind is not quite the same in each turn.
  EXPECT_LT(worst, 0.2);
}

// A free sheet: all of it turns about the anchored voxel and nothing is strained, whatever the angle.
TEST(FullTurns, ASheetGoesRound)
{
  for (const double degrees : { 10.0, -10.0, 3.0 })
  {
    SCOPED_TRACE(degrees);
    expectTurnsAlike(degrees);
  }
}

/// Turns a block by its corners, one and a half times round, and expects it at half a turn and at every further one
/// where the rotation has it. What is left is rounding: places are known to 1.2e-7 of the largest displacement, and a
/// few sweeps leave ten times as much.
void expectRotationOfEverything(const Scene& scene, double stepDegrees, int axis, double poissonRatio, bool coarse)
{
  const Index3& n = scene.grid.size;
  const Vector3 middle = scene.place(n[0] / 2, n[1] / 2, n[2] / 2);
  Simulation simulation = simulateTurning(scene, { 0, 0, 0 }, 1, poissonRatio);
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
          const Vector3 wanted = circled(scene.place(i, j, k), middle, axis, step * stepDegrees);
          for (int a = 0; a < 3; ++a)
          {
            const double off = std::fabs(u[scene.grid.at(i, j, k)][a] - wanted[a]);
            worst = off <= worst ? worst : off; // takes a NaN as well
          }
        });
      EXPECT_LT(worst, 1e-3);
      EXPECT_LT(now.energy, 1e-5);
      EXPECT_LT(bend(simulation), 1e-4);
    }
  }
}

// A block with bones, elements that are no cubes and tissue that keeps its volume.
TEST(FullTurns, ABlockWithBonesGoesRound)
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
