#pragma once

#include "Scene.h"

/// A heterogeneous block with an inclusion, a rod of bone and one anchored face.
inline Scene inclusionScene(int n, int axes, std::uint64_t seed, double air = 0.05)
{
  Scene scene = randomScene({ n, n, n }, axes, seed, air, 0.0);
  const int middle = n / 2;
  for (int i = n / 5; i < n - n / 5; ++i)
  {
    for (int j : { middle, middle + 1 })
    {
      scene.scalar[scene.grid.at(i, j, middle)] = 1.0f;
      scene.give(i, j, middle, 0.0f);
    }
  }
  // A second body, without a probe.
  for (int k = 2; k < 5; ++k)
  {
    for (int j = 2; j < 5; ++j)
    {
      scene.scalar[scene.grid.at(n - 5, j, k)] = 1.0f;
      scene.give(n - 5, j, k, 0.0f);
    }
  }
  scene.anchors.faces[0] = true;
  return scene;
}

/// A probe on one element near a corner, away from the anchored face.
inline chainmail::Probe corner(const Scene& scene, const chainmail::Vector3& displacement)
{
  const chainmail::Index3& n = scene.grid.size;
  chainmail::Probe probe = probeAt(scene, { n[0] - 2, n[1] - 3, n[2] / 2 }, displacement);
  probe.radius = 0.0;
  return probe;
}

/// The largest displacement of the element of corner() on each axis, as a fraction of the spacing.
inline chainmail::Vector3 reachOfCorner(const Scene& scene)
{
  const oracle::Block block = scene.block();
  oracle::Handle handle = handles(block, { corner(scene, {}) })[0];
  handle.target = { 1e3, 1e3, 1e3 };
  return oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), { handle }).reached[0];
}

/// A pull of corner() by shares of its largest displacement.
inline chainmail::Probe pullBy(const Scene& scene, const chainmail::Vector3& shares)
{
  const chainmail::Vector3 reach = reachOfCorner(scene);
  chainmail::Vector3 displacement;
  for (int a = 0; a < 3; ++a)
  {
    displacement[a] = shares[a] * reach[a] * scene.grid.spacing[a];
  }
  return corner(scene, displacement);
}

/// inclusionScene() with tissue at the element that corner() grabs.
inline Scene cornerScene(int n, int axes, std::uint64_t seed)
{
  Scene scene = inclusionScene(n, axes, seed);
  scene.scalar[scene.grid.at(n - 2, n - 3, n / 2)] = 1.0f;
  return scene;
}
