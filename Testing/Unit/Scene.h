#pragma once

#include "../Oracles/Crossing.h"
#include "../Oracles/Optimiser.h"
#include "../Oracles/Propagation.h"
#include "Error.h"
#include "Random.h"
#include "Simulation.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

/// A block of tissue for the engine and for the oracles. Constraints are fractions of the spacing; voxels of scalar 0
/// are air. Nothing is anchored by default.
struct Scene
{
  chainmail::Grid grid;
  int components = 1;
  std::vector<float> constraint; ///< `components` values a voxel
  std::vector<float> scalar;
  chainmail::Anchors anchors;

  explicit Scene(const chainmail::Index3& size, float everywhere = 0.3f, int axes = 1)
    : components(axes)
  {
    this->grid.size = size;
    this->constraint.assign(this->grid.voxels() * axes, everywhere);
    this->scalar.assign(this->grid.voxels(), 1.0f);
    this->anchors.faces.fill(false);
  }

  void air(int i, int j, int k) { this->scalar[this->grid.at(i, j, k)] = 0.0f; }
  bool tissue(std::size_t voxel) const { return this->scalar[voxel] != 0.0f; }
  void give(int i, int j, int k, float value)
  {
    for (int c = 0; c < this->components; ++c)
    {
      this->constraint[this->grid.at(i, j, k) * this->components + c] = value;
    }
  }

  /// Calls `f(i, j, k)` for every voxel.
  template <typename F> void each(F&& f) const
  {
    for (int k = 0; k < this->grid.size[2]; ++k)
    {
      for (int j = 0; j < this->grid.size[1]; ++j)
      {
        for (int i = 0; i < this->grid.size[0]; ++i)
        {
          f(i, j, k);
        }
      }
    }
  }

  /// Voxel centre in the engine's positions [mm].
  chainmail::Vector3 place(int i, int j, int k) const
  {
    return { i * this->grid.spacing[0], j * this->grid.spacing[1], k * this->grid.spacing[2] };
  }

  /// The model reads the arrays of the scene, so the scene must outlive the model.
  std::shared_ptr<const chainmail::Model> model(const chainmail::Joints& joints = {}) const
  {
    chainmail::Material material;
    material.joints = joints;
    material.tissueThreshold = 0.5;
    material.constraintArray.data = this->constraint.data();
    material.constraintArray.type = chainmail::ArrayView::Type::Float32;
    material.constraintArray.components = this->components;
    chainmail::ArrayView scalars;
    scalars.data = this->scalar.data();
    scalars.type = chainmail::ArrayView::Type::Float32;
    return std::make_shared<chainmail::Model>(this->grid, scalars, material, this->anchors);
  }

  oracle::Block block() const
  {
    oracle::Block block(this->grid.size);
    block.spacing = this->grid.spacing;
    this->each(
      [&](int i, int j, int k)
      {
        const std::size_t v = this->grid.at(i, j, k);
        block.tissue[v] = this->tissue(v);
        bool rigid = false;
        for (int a = 0; a < 3; ++a)
        {
          block.give[v][a] = this->constraint[v * this->components + (this->components == 3 ? a : 0)];
          rigid = rigid || block.give[v][a] == 0.0;
        }
        const chainmail::Index3 p{ i, j, k };
        bool face = false;
        for (int a = 0; a < 3; ++a)
        {
          const bool thick = this->grid.size[a] > 1;
          face = face || (thick && this->anchors.faces[2 * a] && p[a] == 0);
          face = face || (thick && this->anchors.faces[2 * a + 1] && p[a] == this->grid.size[a] - 1);
        }
        block.anchored[v] = block.tissue[v] && (face || (this->anchors.rigid && rigid));
      });
    return block;
  }
};

/// The device of the tests: the best one, or the one that the environment variable CHAINMAIL_TEST_DEVICE names.
inline std::string testDevice()
{
  const char* name = std::getenv("CHAINMAIL_TEST_DEVICE");
  return name ? name : "";
}

inline chainmail::Simulation simulate(const Scene& scene, const chainmail::Index3& brick = { 0, 0, 0 })
{
  chainmail::Settings settings;
  settings.device = testDevice();
  settings.brickSize = brick;
  return chainmail::Simulation(scene.model(), settings);
}

/// Three brick sizes: the smallest, an anisotropic one of medium size, a large one.
inline std::vector<chainmail::Index3> brickSizes()
{
  return { { 4, 2, 2 }, { 8, 4, 8 }, { 32, 16, 4 } };
}

/// A visitor for resample() that calls f(voxel, offset) for every voxel of every box.
template <typename F> chainmail::BoxVisitor visitEach(F f)
{
  return [f](const std::vector<chainmail::ResampledBox>& boxes)
  {
    for (const chainmail::ResampledBox& box : boxes)
    {
      box.forVoxels(f);
    }
  };
}

/// The engine's displacements [mm].
inline std::vector<float> displacements(const chainmail::Simulation& simulation)
{
  std::vector<float> u(simulation.model().grid().voxels() * 3);
  simulation.displacements(u.data());
  return u;
}

/// The engine's displacements as fractions of the spacing, in the oracles' types.
inline std::vector<oracle::Vector3> state(const chainmail::Simulation& simulation)
{
  const std::vector<float> u = displacements(simulation);
  std::vector<oracle::Vector3> v(u.size() / 3);
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    v[n / 3][n % 3] = u[n] / simulation.model().grid().spacing[n % 3];
  }
  return v;
}

inline std::vector<std::uint8_t> links(const chainmail::Simulation& simulation)
{
  std::vector<std::uint8_t> bits(simulation.model().grid().voxels());
  simulation.links(bits.data());
  return bits;
}

inline std::vector<int> clusters(const chainmail::Simulation& simulation)
{
  std::vector<int> labels(simulation.model().grid().voxels() * simulation.model().axes());
  simulation.clusters(labels.data());
  return labels;
}

/// Removes from the block the links that are missing in the engine's bits.
inline void takeLinks(oracle::Block& block, const std::vector<std::uint8_t>& bits)
{
  for (const oracle::Link& link : oracle::links(block))
  {
    if (!(bits[link.from] >> (2 * link.direction + 1) & 1))
    {
      block.cut[link.from] |= static_cast<std::uint8_t>(1u << link.direction);
    }
  }
}

inline bool sameBits(const std::vector<float>& a, const std::vector<float>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// FNV-1a of the bits of the values.
template <typename T> std::uint64_t hashOfBits(const std::vector<T>& values)
{
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  std::uint64_t h = 14695981039346656037u;
  for (std::size_t n = 0; n < values.size() * sizeof(T); ++n)
  {
    h = (h ^ bytes[n]) * 1099511628211u;
  }
  return h;
}

/// Largest difference of two states over all tissue and axes, as a fraction of the spacing.
inline double largestDifference(
  const oracle::Block& block, const std::vector<oracle::Vector3>& a, const std::vector<oracle::Vector3>& b)
{
  double worst = 0.0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    for (int axis = 0; block.tissue[v] && axis < 3; ++axis)
    {
      const double d = std::abs(a[v][axis] - b[v][axis]);
      worst = d <= worst ? worst : d; // takes a NaN as well
    }
  }
  return worst;
}

/// Random tissue: constraints in [0, 0.5) from patches and noise, shares of rigid elements and of air.
inline Scene randomScene(
  const chainmail::Index3& size, int axes, std::uint64_t seed, double airShare = 0.15, double rigidShare = 0.1)
{
  Scene scene(size, 0.0f, axes);
  Random random(seed);
  scene.each(
    [&](int i, int j, int k)
    {
      if (random(0, 1) < airShare)
      {
        scene.air(i, j, k);
      }
      const bool rigid = random(0, 1) < rigidShare;
      for (int c = 0; c < axes; ++c)
      {
        const double value = random(0.02, 0.25) + (((i / 4 + j / 4 + k / 4 + c) % 2) ? 0.2 : 0.0);
        scene.constraint[scene.grid.at(i, j, k) * axes + c] = rigid ? 0.0f : static_cast<float>(value);
      }
    });
  return scene;
}

/// A random element.
inline chainmail::Index3 randomElement(const Scene& scene, Random& random)
{
  for (;;)
  {
    const chainmail::Index3 p{ random.below(scene.grid.size[0]), random.below(scene.grid.size[1]),
      random.below(scene.grid.size[2]) };
    if (scene.tissue(scene.grid.at(p[0], p[1], p[2])))
    {
      return p;
    }
  }
}

inline chainmail::Probe probeAt(
  const Scene& scene, const chainmail::Index3& p, const chainmail::Vector3& displacement, double radius = 0.0)
{
  chainmail::Probe probe;
  probe.position = scene.place(p[0], p[1], p[2]);
  probe.displacement = displacement;
  probe.radius = radius;
  return probe;
}

/// The probes as handles of the oracle. An element has one holder: an anchor, else the first probe that grabs it.
inline std::vector<oracle::Handle> handles(const oracle::Block& block, const std::vector<chainmail::Probe>& probes)
{
  std::vector<oracle::Handle> result;
  std::vector<char> taken = block.anchored;
  for (const chainmail::Probe& probe : probes)
  {
    oracle::Handle handle;
    for (const std::size_t voxel : oracle::grab(block, probe.position, probe.radius))
    {
      if (!taken[voxel])
      {
        taken[voxel] = 1;
        handle.elements.push_back(voxel);
      }
    }
    handle.anchor = probe.anchor;
    for (int a = 0; a < 3; ++a)
    {
      handle.target[a] = probe.displacement[a] / block.spacing[a];
    }
    result.push_back(handle);
  }
  return result;
}

/// `count` compatible probes on random elements: the tissue allows all their displacements together, with a margin for
/// rounding. With a `largestRadius` [mm] every other probe has a random radius and a position off the voxel's centre.
inline std::vector<chainmail::Probe> compatibleProbes(
  const Scene& scene, int count, double reach, std::uint64_t seed, double largestRadius = 0.0)
{
  const oracle::Block block = scene.block();
  Random random(seed);
  std::vector<chainmail::Probe> probes;
  std::vector<oracle::Handle> before;
  while (static_cast<int>(probes.size()) < count)
  {
    const chainmail::Index3 p = randomElement(scene, random);
    oracle::Handle handle;
    handle.elements.assign(1, scene.grid.at(p[0], p[1], p[2]));
    chainmail::Probe probe = probeAt(scene, p, {});
    if (largestRadius > 0.0 && probes.size() % 2 == 0)
    {
      probe.radius = random(0.3, 1.0) * largestRadius;
      for (double& x : probe.position)
      {
        x += random(-0.2, 0.2);
      }
      probes.push_back(probe);
      handle.elements = handles(block, probes).back().elements;
      probes.pop_back();
      if (handle.elements.empty())
      {
        continue;
      }
    }
    for (double& t : handle.target)
    {
      t = random(-reach, reach);
    }
    std::vector<oracle::Handle> all = before;
    all.push_back(handle);
    const auto allowed = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), all).reached.back();
    // The target is 0.98 of the allowed displacement. If an earlier probe pulls far, 0 is not allowed, and the target
    // may not be allowed either. Such a probe is drawn anew.
    for (int a = 0; a < 3; ++a)
    {
      all.back().target[a] = handle.target[a] = 0.98 * allowed[a];
    }
    const auto again = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), all).reached.back();
    bool compatible = true;
    for (int a = 0; a < 3; ++a)
    {
      compatible = compatible && again[a] == handle.target[a];
    }
    if (!compatible)
    {
      continue;
    }
    before.push_back(handle);
    for (int a = 0; a < 3; ++a)
    {
      probe.displacement[a] = handle.target[a] * scene.grid.spacing[a];
    }
    probes.push_back(probe);
  }
  return probes;
}

/// Runs `f`, which must throw E, and returns its message.
template <typename E, typename F> std::string messageOf(F&& f)
{
  try
  {
    f();
  }
  catch (const E& error)
  {
    return error.what();
  }
  catch (const std::exception& error)
  {
    ADD_FAILURE() << "another exception was thrown: " << error.what();
    return {};
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

inline bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}
