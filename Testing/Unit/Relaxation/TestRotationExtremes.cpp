// Extreme rotations. If everything is rotated by one rotation, exact places are known, and nothing is strained.
// Each test prints its measurements as "NUMERICS: name | figure"; Testing/Numerics.md lists them.

#include "Figures.h"
#include "RotationScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// A rotation about an axis through a point, given by a rotation matrix in double precision.
class Rotation
{
public:
  Rotation(const Vector3& axis, double degrees, const Vector3& middle)
    : middle_(middle)
  {
    const double angle = degrees * 3.14159265358979323846 / 180.0;
    const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    const double x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;
    // 1 - cos as a square: accurate for small angles, too.
    const double s = std::sin(angle), v = 2.0 * std::sin(0.5 * angle) * std::sin(0.5 * angle);
    this->less_ = { { { { v * (x * x - 1.0), v * x * y - s * z, v * x * z + s * y } },
      { { v * x * y + s * z, v * (y * y - 1.0), v * y * z - s * x } },
      { { v * x * z - s * y, v * y * z + s * x, v * (z * z - 1.0) } } } };
  }

  /// The displacement of a point.
  Vector3 operator()(const Vector3& at) const
  {
    Vector3 moved{};
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        moved[a] += this->less_[a][b] * (at[b] - this->middle_[b]);
      }
    }
    return moved;
  }

private:
  Vector3 middle_;
  std::array<std::array<double, 3>, 3> less_{};
};

/// The errors after a rotation of everything.
struct Followed
{
  double astray = 0.0; ///< largest distance of an element from its place, relative to the largest displacement
  double energy = 0.0; ///< relative to the energy before the last relaxation
  double bend = 0.0;   ///< of bones [spacings]
  double excess = 0.0; ///< of links [spacings]
};

/// Rotates tissue by its corners in steps of at most ten degrees, and relaxes it.
///
/// The error is rounding, about ten times as much as was measured: a place is rounded to the last bits of float32, and
/// the energy is the square of the strain by this.
Followed rotateByCorners(const Scene& scene, const Vector3& axis, double degrees)
{
  const Index3& n = scene.grid.size;
  const Vector3 middle = scene.place(n[0] / 2, n[1] / 2, n[2] / 2);
  Simulation simulation = simulateRotations(scene);
  std::vector<Probe> probes;
  for (int corner = 0; corner < 8; ++corner)
  {
    Probe probe;
    probe.position = scene.place(corner & 1 ? n[0] - 1 : 0, corner & 2 ? n[1] - 1 : 0, corner & 4 ? n[2] - 1 : 0);
    probes.push_back(probe);
  }
  const int steps = std::max(1, static_cast<int>(std::ceil(degrees / 10.0)));
  double strained = 0.0;
  for (int step = 1; step <= steps; ++step)
  {
    const Rotation rotation(axis, degrees * step / steps, middle);
    for (Probe& probe : probes)
    {
      probe.displacement = rotation(probe.position);
    }
    simulation.pull(probes);
    strained = simulation.measure().energy;
    EXPECT_GT(strained, 0.0) << "nothing to relax: a poor test";
    simulation.relax(3000, 0.0);
  }
  const Rotation rotation(axis, degrees, middle);
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  double worst = 0.0, most = 0.0;
  scene.each(
    [&](int i, int j, int k)
    {
      const Vector3 expected = rotation(scene.place(i, j, k));
      for (int a = 0; a < 3; ++a)
      {
        worst = std::max(worst, std::fabs(u[scene.grid.at(i, j, k)][a] - expected[a]));
        most = std::max(most, std::fabs(expected[a]));
      }
    });
  const Statistics now = simulation.measure();
  return { worst / most, now.energy / strained, bend(simulation), now.maxLinkExcess };
}

Scene block()
{
  Scene scene({ 11, 7, 8 }, 0.3f);
  scene.grid.spacing = { 1.0, 0.7, 1.2 };
  return scene;
}

TEST(RotationExtremes, AnglesFromAMillionthOfADegreeToNinety)
{
  Scene scene = block();
  Random random(5);
  scene.each([&](int i, int j, int k) { scene.give(i, j, k, static_cast<float>(random(0.1, 0.4))); });
  for (const double degrees : { 1e-6, 1e-3, 1.0, 15.0, 45.0, 90.0 })
  {
    char name[64];
    std::snprintf(name, sizeof name, "turned by %g degrees, ", degrees);
    const Followed followed = rotateByCorners(scene, { 1.0, -2.0, 3.0 }, degrees);
    expectAtMost(std::string(name) + "distance by the largest displacement", followed.astray, 1e-5);
    expectAtMost(std::string(name) + "energy left", followed.energy, 1e-6);
    expectAtMost(std::string(name) + "link excess", followed.excess, 2e-6, "spacings");
  }
}

void expectBonesFollow(const Scene& scene, const std::string& name)
{
  for (const Vector3& axis : { Vector3{ 1.0, 0.0, 0.0 }, Vector3{ 0.3, 1.0, 0.2 } })
  {
    const std::string about = name + (axis[1] == 0.0 ? ", about x: " : ", aslant: ");
    const Followed followed = rotateByCorners(scene, axis, 60.0);
    expectAtMost(about + "distance by the largest displacement", followed.astray, 1e-5);
    expectAtMost(about + "energy left", followed.energy, 1e-6);
    expectAtMost(about + "bend of bones", followed.bend, 1e-5, "spacings");
    expectAtMost(about + "link excess", followed.excess, 2e-6, "spacings");
  }
}

// The shape of a bone of one voxel does not determine its rotation: only its links do.
TEST(RotationExtremes, BonesOfOneVoxel)
{
  Scene scene = block();
  scene.each(
    [&](int i, int j, int k)
    {
      if (i % 3 == 1 && j % 2 == 1 && k % 3 == 1)
      {
        scene.give(i, j, k, 0.0f);
      }
    });
  expectBonesFollow(scene, "bones of one voxel");
}

// The members of a straight bone do not determine its rotation about their line.
TEST(RotationExtremes, BonesInALine)
{
  Scene scene = block();
  for (int n = 2; n < 9; ++n)
  {
    scene.give(n, 2, 2, 0.0f);
    scene.give(n, 4, 5, 0.0f);
  }
  for (int n = 1; n < 6; ++n)
  {
    scene.give(5, n, 0, 0.0f);
  }
  expectBonesFollow(scene, "bones in a line");
}

TEST(RotationExtremes, Noise)
{
  Scene scene = block();
  Random random(9);
  scene.each(
    [&](int i, int j, int k)
    {
      const bool corner = i % 10 == 0 && j % 6 == 0 && k % 7 == 0;
      scene.give(i, j, k, !corner && random.oneIn(10) ? 0.0f : static_cast<float>(random(0.1, 0.4)));
    });
  expectBonesFollow(scene, "noise, a tenth of it rigid");
}

}
