// Soft probes with rotations and in reduced models: against optima in double precision, and against the rigid motion
// that fits landmarks best.

#include "RotationScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// The rigid motion x -> c + R (x - b) that minimises the weighted sum of squared distances between two sets of points.
/// R is from B. Horn's unit quaternion (J. Opt. Soc. Am. A 4, 1987): the eigenvector of the largest eigenvalue of a 4 x
/// 4 matrix, found by power iteration.
struct Motion
{
  Vector3 from{};
  Vector3 to{};
  double rotation[3][3];

  Motion(const std::vector<Vector3>& points, const std::vector<Vector3>& goals, const std::vector<double>& weights)
  {
    double sum = 0.0;
    for (std::size_t n = 0; n < points.size(); ++n)
    {
      sum += weights[n];
      for (int a = 0; a < 3; ++a)
      {
        this->from[a] += weights[n] * points[n][a];
        this->to[a] += weights[n] * goals[n][a];
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      this->from[a] /= sum;
      this->to[a] /= sum;
    }
    double s[3][3] = {};
    double size = 0.0;
    for (std::size_t n = 0; n < points.size(); ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        for (int b = 0; b < 3; ++b)
        {
          const double product = weights[n] * (points[n][a] - this->from[a]) * (goals[n][b] - this->to[b]);
          s[a][b] += product;
          size += std::fabs(product);
        }
      }
    }
    const double m[4][4] = { { s[0][0] + s[1][1] + s[2][2] + 3 * size, s[1][2] - s[2][1], s[2][0] - s[0][2],
                               s[0][1] - s[1][0] },
      { s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2] + 3 * size, s[0][1] + s[1][0], s[2][0] + s[0][2] },
      { s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2] + 3 * size, s[1][2] + s[2][1] },
      { s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1] + 3 * size } };
    double q[4] = { 1.0, 0.01, 0.02, 0.03 };
    for (int round = 0; round < 20000; ++round)
    {
      double next[4] = {};
      double length = 0.0;
      for (int a = 0; a < 4; ++a)
      {
        for (int b = 0; b < 4; ++b)
        {
          next[a] += m[a][b] * q[b];
        }
        length += next[a] * next[a];
      }
      for (int a = 0; a < 4; ++a)
      {
        q[a] = next[a] / std::sqrt(length);
      }
    }
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double r[3][3] = { { w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y) },
      { 2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x) },
      { 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z } };
    std::copy(&r[0][0], &r[0][0] + 9, &this->rotation[0][0]);
  }

  Vector3 operator()(const Vector3& point) const
  {
    Vector3 moved = this->to;
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        moved[a] += this->rotation[a][b] * (point[b] - this->from[b]);
      }
    }
    return moved;
  }
};

/// A bone in air, or in tissue so soft that its forces are negligible.
Scene landmarkScene(bool inTissue)
{
  Scene scene({ 24, 13, 15 }, 0.9f);
  scene.grid.spacing = { 1.0, 1.5, 0.8 };
  scene.each(
    [&](int i, int j, int k)
    {
      const bool bone = i >= 4 && i < 20 && j >= 5 && j < 8 && k >= 6 && k < 9 && !(i > 15 && k == 8);
      if (bone)
      {
        scene.give(i, j, k, 0.0f);
      }
      else if (!inTissue)
      {
        scene.air(i, j, k);
      }
    });
  return scene;
}

/// Landmarks on the bone: soft probes of different tolerances whose targets no rigid motion fits exactly.
std::vector<Probe> landmarks(const Scene& scene, double degrees, double scale)
{
  const double angle = degrees * 3.14159265358979323846 / 180.0;
  std::vector<Probe> probes;
  int n = 0;
  for (const Index3& at : { Index3{ 4, 5, 6 }, Index3{ 19, 7, 6 }, Index3{ 11, 5, 8 }, Index3{ 15, 7, 8 } })
  {
    Probe probe = probeAt(scene, at, {});
    const double x = probe.position[0] - 10.0, y = probe.position[1] - 9.0;
    probe.displacement = { x * std::cos(angle) - y * std::sin(angle) - x + 1.5,
      x * std::sin(angle) + y * std::cos(angle) - y - 0.5, 0.7 + 0.1 * x };
    probe.displacement[n % 3] += 0.3; // landmarks have errors
    probe.tolerance = scale * (0.5 + 0.3 * n);
    probes.push_back(probe);
    ++n;
  }
  return probes;
}

TEST(SoftProbesRotations, LandmarksGiveABoneTheNearestRigidMotion)
{
  for (const bool inTissue : { false, true })
  {
    for (const double degrees : { 3.0, 40.0 })
    {
      if (inTissue && degrees > 3.0)
      {
        continue; // its links reach their limits
      }
      SCOPED_TRACE(testing::Message() << degrees << " degrees, " << (inTissue ? "in tissue" : "in air"));
      const Scene scene = landmarkScene(inTissue);
      const std::vector<Probe> probes = landmarks(scene, degrees, inTissue ? 1e-5 : 1.0);
      std::vector<Vector3> points, goals;
      std::vector<double> weights;
      for (const Probe& probe : probes)
      {
        points.push_back(probe.position);
        goals.push_back(probe.position);
        for (int a = 0; a < 3; ++a)
        {
          goals.back()[a] += probe.displacement[a];
        }
        weights.push_back(1.0 / probe.tolerance);
      }
      const Motion motion(points, goals, weights);
      Simulation simulation = simulateRotations(scene);
      simulation.hold(probes);
      double last = simulation.measure().energy;
      for (int n = 0; n < 10; ++n)
      {
        simulation.relax(inTissue ? 60 : 20, 0.0);
        const Statistics now = simulation.measure();
        EXPECT_LE(now.energy, last * (1.0 + 1e-5)) << n;
        EXPECT_LE(now.maxLinkExcess, 1e-5);
        last = now.energy;
      }
      const std::vector<oracle::Vector3> u = millimetres(simulation);
      const std::vector<int> labels = clusters(simulation);
      double worst = 0.0;
      for (std::size_t v = 0; v < labels.size(); ++v)
      {
        if (labels[v] >= 0)
        {
          const Index3 p = scene.grid.indexOf(v);
          const Vector3 rest = scene.place(p[0], p[1], p[2]);
          const Vector3 moved = motion(rest);
          for (int a = 0; a < 3; ++a)
          {
            worst = std::max(worst, std::fabs(rest[a] + u[v][a] - moved[a]));
          }
        }
      }
      // Near the optimum float32 cannot resolve which steps lower the energy: measured 1.1e-3.
      EXPECT_LT(worst, 2e-3);
      EXPECT_LT(bend(simulation), 1e-4);
      double energy = 0.0;
      for (std::size_t n = 0; n < probes.size(); ++n)
      {
        const Vector3 moved = motion(points[n]);
        for (int a = 0; a < 3; ++a)
        {
          energy += weights[n] * std::pow(moved[a] - goals[n][a], 2);
        }
      }
      EXPECT_NEAR(last, energy, (inTissue ? 1e-2 : 3e-4) * energy);
    }
  }
}

// Without rotations, landmarks give a bone the best translation.
TEST(SoftProbesRotations, WithoutRotationsABoneGoesByTheMean)
{
  const Scene scene = landmarkScene(false);
  const std::vector<Probe> probes = landmarks(scene, 3.0, 1.0);
  Simulation simulation = simulate(scene);
  simulation.hold(probes);
  simulation.relax(400, 0.0);
  Vector3 mean{};
  double sum = 0.0;
  for (const Probe& probe : probes)
  {
    sum += 1.0 / probe.tolerance;
    for (int a = 0; a < 3; ++a)
    {
      mean[a] += probe.displacement[a] / probe.tolerance;
    }
  }
  for (const ProbeResult& result : simulation.probes())
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(result.reached[a], mean[a] / sum, 1e-5);
    }
  }
}

// Small pulls end at the optimum of the linear energy: in soft tissue, and on a bone that rotates.
TEST(SoftProbesRotations, ReachTheOptimumOfSmallPulls)
{
  for (const double poissonRatio : { 0.0, 0.3 })
  {
    for (const bool cubes : { true, false })
    {
      SCOPED_TRACE(testing::Message() << poissonRatio << (cubes ? " cubes" : " no cubes"));
      Scene scene = inclusionScene(12, 1, 11);
      if (!cubes)
      {
        scene.grid.spacing = { 0.6, 1.0, 2.5 };
      }
      std::vector<Probe> probes;
      oracle::Block block = scene.block();
      Random random(5);
      for (int n = 0; n < 8; ++n)
      {
        Index3 at = randomElement(scene, random);
        for (int tries = 0; n % 2 == 0 && tries < 1000 && block.give[scene.grid.at(at[0], at[1], at[2])][0] > 0.0;
             ++tries)
        {
          at = randomElement(scene, random); // on the bone
        }
        Probe probe = probeAt(scene, at, { random(-0.01, 0.01), random(-0.01, 0.01), random(-0.01, 0.01) });
        probe.tolerance = random(0.005, 0.1);
        probes.push_back(probe);
        oracle::Soft soft;
        soft.voxel = scene.grid.at(at[0], at[1], at[2]);
        soft.tolerance = probe.tolerance;
        for (int a = 0; a < 3; ++a)
        {
          soft.target[a] = probe.displacement[a] / scene.grid.spacing[a];
        }
        block.soft.push_back(soft);
      }
      const std::vector<oracle::Vector3> start(block.count(), oracle::Vector3{});
      const oracle::RotationOptimum best = oracle::RotationProblem(block, block.anchored, poissonRatio).minimise(start);
      for (const bool coarse : { false, true })
      {
        Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, 1, poissonRatio);
        simulation.setCoarseToFine(coarse);
        simulation.hold(probes);
        const double first = simulation.measure().energy;
        simulation.relax(2000, 0.0);
        const double energy = simulation.measure().energy;
        EXPECT_GT(first, 1.1 * best.energy) << "nothing to relax: a poor test";
        EXPECT_NEAR(energy, best.energy, 2e-3 * best.energy); // the terms that the linear energy neglects
      }
    }
  }
}

// In a reduced model the weight of soft probes relative to the tissue is that in the whole model.
TEST(SoftProbesRotations, ReducedModelsWeighThemAlike)
{
  for (const bool rotations : { false, true })
  {
    SCOPED_TRACE(rotations ? "with rotations" : "without");
    Scene scene({ 32, 32, 32 }, 0.4f);
    scene.anchors.faces[4] = true;
    Probe ball = probeAt(scene, { 16, 16, 26 }, { 0.6, 0.0, 0.8 }, 4.0);
    ball.position = { 15.5, 15.5, 25.5 };
    ball.tolerance = 8.0;
    double energies[3], reached[3], forces[3];
    int n = 0;
    for (const int reduction : { 1, 2, 4 })
    {
      Settings settings;
      settings.device = testDevice();
      settings.rotations = rotations;
      settings.modelReduction = reduction;
      Simulation simulation(scene.model(), settings);
      simulation.setCoarseToFine(true);
      simulation.hold({ ball });
      simulation.relax(600, 1e-6);
      energies[n] = simulation.measure().energy;
      reached[n] = simulation.probes()[0].reached[2];
      forces[n] = simulation.probes()[0].force[2];
      EXPECT_NEAR(energies[n], energies[0], 0.08 * energies[0]);
      EXPECT_NEAR(reached[n], reached[0], 0.08 * reached[0]);
      EXPECT_NEAR(forces[n], forces[0], 0.08 * forces[0]);
      ++n;
    }
    EXPECT_GT(reached[0], 0.1);
    EXPECT_LT(reached[0], 0.7);
  }
}

}
