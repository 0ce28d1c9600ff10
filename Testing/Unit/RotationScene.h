#pragma once

// Scenes of rotating tissue, and checks of them.

#include "../Oracles/Rotations.h"
#include "Inclusion.h"

#include <algorithm>
#include <cmath>

inline chainmail::Simulation simulateRotations(
  const Scene& scene, const chainmail::Index3& brick = { 0, 0, 0 }, int reduction = 1, double poissonRatio = 0.0)
{
  chainmail::Settings settings;
  settings.device = testDevice();
  settings.brickSize = brick;
  settings.rotations = true;
  settings.modelReduction = reduction;
  settings.poissonRatio = poissonRatio;
  return chainmail::Simulation(scene.model(), settings);
}

inline std::vector<oracle::Vector3> millimetres(const chainmail::Simulation& simulation)
{
  const std::vector<float> u = displacements(simulation);
  std::vector<oracle::Vector3> v(u.size() / 3);
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    v[n / 3][n % 3] = u[n];
  }
  return v;
}

/// The largest change of a distance between two members of a rigid cluster [mm].
inline double bend(const chainmail::Simulation& simulation)
{
  const chainmail::Grid& grid = simulation.model().grid();
  const std::vector<int> labels = clusters(simulation);
  const std::vector<oracle::Vector3> u = millimetres(simulation);
  std::vector<std::size_t> first;
  double worst = 0.0;
  for (std::size_t v = 0; v < labels.size(); ++v)
  {
    if (labels[v] < 0)
    {
      continue;
    }
    first.resize(std::max<std::size_t>(first.size(), static_cast<std::size_t>(labels[v]) + 1), v);
    const std::size_t w = first[labels[v]];
    const chainmail::Index3 p = grid.indexOf(v), q = grid.indexOf(w);
    double before = 0.0, after = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const double rest = (p[a] - q[a]) * grid.spacing[a];
      before += rest * rest;
      after += (rest + u[v][a] - u[w][a]) * (rest + u[v][a] - u[w][a]);
    }
    worst = std::max(worst, std::fabs(std::sqrt(after) - std::sqrt(before)));
  }
  return worst;
}

/// Expects that a small pull near a corner ends at the optimum of the linear energy.
inline void expectLinearOptimum(
  Scene& scene, const chainmail::Vector3& displacement, const char* what, double poissonRatio = 0.0)
{
  SCOPED_TRACE(what);
  const chainmail::Index3& n = scene.grid.size;
  scene.scalar[scene.grid.at(n[0] - 2, n[1] - 3, n[2] / 2)] = 1.0f;
  chainmail::Simulation simulation = simulateRotations(scene, { 0, 0, 0 }, 1, poissonRatio);
  const std::vector<chainmail::Probe> probes{ corner(scene, displacement) };
  simulation.pull(probes);
  const double pulled = simulation.measure().energy;
  simulation.relax(3000, 0.0);
  const std::vector<oracle::Vector3> relaxed = millimetres(simulation);

  const oracle::Block block = scene.block();
  std::vector<char> held = block.anchored;
  held[handles(block, probes)[0].elements[0]] = 1;
  const oracle::RotationOptimum best = oracle::RotationProblem(block, held, poissonRatio).minimise(relaxed);
  ASSERT_GT(pulled, 1.05 * best.energy) << "nothing to relax: a poor test";
  // The pull strains links by at most 0.01. The terms that the linear energy neglects are of this order.
  EXPECT_NEAR(simulation.measure().energy, best.energy, 2e-3 * best.energy);
  double worst = 0.0;
  for (std::size_t v = 0; v < relaxed.size(); ++v)
  {
    for (int a = 0; a < 3; ++a)
    {
      worst = std::max(worst, std::fabs(relaxed[v][a] - best.u[v][a]));
    }
  }
  double pull = 0.0;
  for (const double part : displacement)
  {
    pull = std::max(pull, std::fabs(part));
  }
  EXPECT_LT(worst, 0.01 * pull);
}

/// A bone in soft tissue that is anchored below.
inline Scene boneScene()
{
  Scene scene({ 25, 11, 17 }, 0.35f);
  for (int i = 6; i < 19; ++i)
  {
    for (const int j : { 4, 5, 6 })
    {
      for (const int k : { 7, 8, 9 })
      {
        scene.give(i, j, k, 0.0f);
      }
    }
  }
  scene.anchors.faces[4] = true;
  return scene;
}

inline chainmail::Probe onBone(
  const Scene& scene, int i, int j, int k, const chainmail::Vector3& displacement, double radius = 0.0)
{
  chainmail::Probe probe;
  probe.position = scene.place(i, j, k);
  probe.displacement = displacement;
  probe.radius = radius;
  return probe;
}
