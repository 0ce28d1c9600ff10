// Elements of 2, 4 or 8 voxels per axis: the reduced grid against an oracle by its definition; what is exact for every
// reduction (rest, translations, bone, walls, gaps, cuts); and the difference from the result of the whole model.

#include "Blades.h"
#include "Constraints.h"
#include "Environment.h"
#include "Picture.h"
#include "Random.h"
#include "ReducedModel.h"
#include "Resampler.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

namespace
{

using namespace chainmail;

const std::vector<int> reductions{ 2, 4, 8 };

Simulation reduced(const Scene& scene, int reduction, const Index3& brick = { 0, 0, 0 })
{
  Settings settings;
  settings.device = testDevice();
  settings.brickSize = brick;
  settings.modelReduction = reduction;
  return Simulation(scene.model(), settings);
}

/// The reduced model by its definition, for scenes without cuts.
struct Reduction
{
  const oracle::Block whole;
  Index3 factor{};
  oracle::Block block; ///< of the elements

  Reduction(const Scene& scene, int n)
    : whole(scene.block())
    , factor{ scene.grid.size[0] > 1 ? n : 1, scene.grid.size[1] > 1 ? n : 1, scene.grid.size[2] > 1 ? n : 1 }
  {
    Index3 size;
    for (int a = 0; a < 3; ++a)
    {
      size[a] = (scene.grid.size[a] + this->factor[a] - 1) / this->factor[a];
    }
    this->block = oracle::Block(size);
    std::vector<int> count(this->block.count(), 0);
    std::vector<std::array<bool, 3>> rigid(this->block.count());
    this->block.tissue.assign(this->block.count(), 0);
    for (std::size_t v = 0; v < this->whole.count(); ++v)
    {
      const std::size_t e = this->elementOf(v);
      this->block.spacing = scene.grid.spacing;
      if (this->whole.tissue[v])
      {
        this->block.tissue[e] = 1;
        this->block.anchored[e] = this->block.anchored[e] || this->whole.anchored[v];
        ++count[e];
        for (int a = 0; a < 3; ++a)
        {
          this->block.give[e][a] += this->whole.give[v][a];
          rigid[e][a] = rigid[e][a] || this->whole.give[v][a] == 0.0;
        }
      }
    }
    for (std::size_t e = 0; e < this->block.count(); ++e)
    {
      for (int a = 0; a < 3; ++a)
      {
        this->block.give[e][a] = rigid[e][a] || count[e] == 0 ? 0.0 : this->block.give[e][a] / count[e];
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      this->block.spacing[a] *= this->factor[a];
    }
    std::set<std::pair<std::size_t, std::size_t>> joined;
    for (const oracle::Link& link : oracle::links(this->whole))
    {
      joined.insert({ this->elementOf(link.from), this->elementOf(link.to) });
    }
    for (const oracle::Link& link : oracle::links(this->block))
    {
      if (joined.count({ link.from, link.to }) == 0)
      {
        this->block.cut[link.from] |= static_cast<std::uint8_t>(1u << link.direction);
      }
    }
  }

  std::size_t elementOf(std::size_t voxel) const
  {
    const oracle::Index3 p = this->whole.index(voxel);
    return this->block.at(p[0] / this->factor[0], p[1] / this->factor[1], p[2] / this->factor[2]);
  }

  /// The elements of a handle that grabs these voxels: those with at least half of their voxels grabbed, else the one
  /// with most.
  std::vector<std::size_t> held(const std::vector<std::size_t>& voxels) const
  {
    std::map<std::size_t, int> grabbed, all;
    for (const std::size_t v : voxels)
    {
      ++grabbed[this->elementOf(v)];
    }
    for (std::size_t v = 0; v < this->whole.count(); ++v)
    {
      all[this->elementOf(v)] += this->whole.tissue[v];
    }
    std::vector<std::size_t> result;
    std::size_t best = grabbed.begin()->first;
    for (const auto& [e, count] : grabbed)
    {
      best = count > grabbed[best] ? e : best;
      if (2 * count >= all[e])
      {
        result.push_back(e);
      }
    }
    return result.empty() ? std::vector<std::size_t>{ best } : result;
  }

  /// The displacements of the voxels [fractions of their spacing] from those of the elements.
  std::vector<oracle::Vector3> expand(const std::vector<oracle::Vector3>& u) const
  {
    std::set<std::pair<std::size_t, std::size_t>> joined;
    for (const oracle::Link& link : oracle::links(this->block))
    {
      joined.insert({ link.from, link.to });
      joined.insert({ link.to, link.from });
    }
    std::vector<oracle::Vector3> result(this->whole.count());
    for (std::size_t v = 0; v < this->whole.count(); ++v)
    {
      if (!this->whole.tissue[v] || this->whole.anchored[v])
      {
        continue;
      }
      const oracle::Index3 p = this->whole.index(v);
      const std::size_t own = this->elementOf(v);
      std::map<std::size_t, double> corners;
      for (int n = 0; n < 8; ++n)
      {
        double share = 1.0;
        oracle::Index3 q;
        bool inside = true;
        for (int a = 0; a < 3; ++a)
        {
          const double where = (p[a] + 0.5) / this->factor[a] - 0.5;
          q[a] = static_cast<int>(std::floor(where)) + (n >> a & 1);
          share *= (n >> a & 1) ? where - std::floor(where) : 1.0 - (where - std::floor(where));
          inside = inside && q[a] >= 0 && q[a] < this->block.size[a];
        }
        if (inside && this->block.tissue[this->block.at(q[0], q[1], q[2])])
        {
          corners[this->block.at(q[0], q[1], q[2])] = share;
        }
      }
      std::set<std::size_t> reached{ own };
      for (std::size_t before = 0; before != reached.size();)
      {
        before = reached.size();
        for (const auto& corner : corners)
        {
          for (const std::size_t r : std::set<std::size_t>(reached))
          {
            if (joined.count({ r, corner.first }))
            {
              reached.insert(corner.first);
            }
          }
        }
      }
      for (int a = 0; a < 3; ++a)
      {
        double sum = 0.0, weight = 0.0;
        for (const auto& [e, share] : corners)
        {
          sum += reached.count(e) ? share * u[e][a] : 0.0;
          weight += reached.count(e) ? share : 0.0;
        }
        result[v][a] = this->factor[a] * (this->whole.give[v][a] == 0.0 ? u[own][a] : sum / weight);
      }
    }
    return result;
  }
};

/// Root mean square of a difference over tissue that either state moved [fractions of the spacing].
double rms(const oracle::Block& block, const std::vector<oracle::Vector3>& a, const std::vector<oracle::Vector3>& b)
{
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && (a[v] != oracle::Vector3{} || b[v] != oracle::Vector3{}))
    {
      ++count;
      for (int c = 0; c < 3; ++c)
      {
        sum += (a[v][c] - b[v][c]) * (a[v][c] - b[v][c]);
      }
    }
  }
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}

TEST(ModelReduction, OtherNumbersAreRefused)
{
  const Scene scene({ 6, 6, 6 });
  for (const int n : { 0, -1, 3, 16, 1 << 30 })
  {
    const std::string message = messageOf<InputError>([&] { reduced(scene, n); });
    EXPECT_TRUE(contains(message, std::to_string(n)) && contains(message, "1, 2, 4 or 8")) << message;
  }
}

TEST(ModelReduction, PropagationIsThatOfTheReducedGrid)
{
  int moved = 0;
  for (const int n : reductions)
  {
    for (int seed = 0; seed < 6; ++seed)
    {
      // Odd sizes, a single slice, a line, and tissue with holes, which leaves elements without links.
      const std::vector<Index3> sizes{ { 21, 17, 19 }, { 32, 16, 24 }, { 37, 29, 1 }, { 19, 9, 11 }, { 41, 1, 1 },
        { 9, 30, 13 } };
      Scene scene = randomScene(sizes[seed], seed % 2 == 0 ? 1 : 3, 3000 + 10 * n + seed, 0.4, 0.004);
      scene.grid.spacing = { 0.5, 2.0, 1.0 };
      scene.anchors.faces[0] = seed % 2 == 1;
      const Reduction oracle(scene, n);
      Random random(77 + seed);
      const Index3 p = randomElement(scene, random);
      const Probe probe = probeAt(scene, p, { 1.5, -2.5, 2.0 }, seed % 3 == 0 ? 3.0 : 0.0);
      oracle::Handle handle;
      for (const std::size_t e : oracle.held(oracle::grab(oracle.whole, probe.position, probe.radius)))
      {
        if (!oracle.block.anchored[e])
        {
          handle.elements.push_back(e);
        }
      }
      for (int a = 0; a < 3; ++a)
      {
        handle.target[a] = probe.displacement[a] / oracle.block.spacing[a];
      }
      const std::vector<oracle::Vector3> rest(oracle.block.count());
      const oracle::Propagated expected = oracle::propagate(oracle.block, rest, { handle });
      Simulation simulation = reduced(scene, n, brickSizes()[seed % 3]);
      const std::vector<ProbeResult> results = simulation.pull({ probe });
      EXPECT_EQ(results[0].elements, handle.elements.size());
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(results[0].reached[a], expected.reached[0][a] * oracle.block.spacing[a], 1e-5);
      }
      const auto u = oracle.expand(expected.state);
      moved += rms(oracle.whole, u, std::vector<oracle::Vector3>(u.size())) > 0.0;
      // Float32 rounding over some tens of links, times n.
      EXPECT_LT(largestDifference(oracle.whole, state(simulation), u), 1e-6 * n * 8) << n << ' ' << seed;
    }
  }
  EXPECT_GE(moved, 15);
}

TEST(ModelReduction, EverythingMovesAsOneExactly)
{
  for (const int n : reductions)
  {
    Scene scene({ 23, 18, 13 }, 0.0f);
    scene.grid.spacing = { 0.5, 0.7, 1.1 };
    // Half of the tissue is soft, with holes. Handles hold all of it, so they move every element.
    scene.each(
      [&](int i, int j, int k)
      {
        if (i >= 8)
        {
          scene.give(i, j, k, 0.3f);
        }
        if ((i * 7 + j * 5 + k * 3) % 11 == 0)
        {
          scene.air(i, j, k);
        }
      });
    Simulation simulation = reduced(scene, n);
    Probe probe = probeAt(scene, { 12, 9, 6 }, { 0.3, -1.3, 2.7 }, 100.0);
    simulation.pull({ probe });
    simulation.relax(20, 0.0);
    const std::vector<float> u = displacements(simulation);
    const std::size_t first = 3 * scene.grid.at(21, 17, 12);
    for (std::size_t v = 0; v < scene.grid.voxels(); ++v)
    {
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_EQ(u[3 * v + a], scene.tissue(v) ? u[first + a] : 0.0f);
        EXPECT_NEAR(u[first + a], probe.displacement[a], 1e-6);
      }
    }
    simulation.reset();
    EXPECT_EQ(displacements(simulation), std::vector<float>(u.size(), 0.0f));
    for (const float offset : resample(simulation).offset)
    {
      ASSERT_EQ(offset, 0.0f);
    }
  }
}

TEST(ModelReduction, AWholeVoxelTranslationShiftsThePicture)
{
  for (const int n : reductions)
  {
    // A body of odd size at an odd place in air.
    Scene scene({ 40, 30, 21 }, 0.3f);
    scene.each(
      [&](int i, int j, int k)
      {
        if (i < 5 || i > 23 || j < 3 || j > 19 || k < 4 || k > 12)
        {
          scene.air(i, j, k);
        }
      });
    Simulation simulation = reduced(scene, n);
    simulation.pull({ probeAt(scene, { 12, 10, 8 }, { 5.0, 0.0, 3.0 }, 50.0) });
    const Picture picture = resample(simulation);
    scene.each(
      [&](int i, int j, int k)
      {
        if (i >= 10 && i <= 28 && j >= 3 && j <= 19 && k >= 7 && k <= 15)
        {
          EXPECT_EQ(picture(i, j, k), (Vector3{ -5.0, 0.0, -3.0 }));
        }
      });
    EXPECT_TRUE(picture.vacated(6, 8, 5));
  }
}

TEST(ModelReduction, BoneOfASingleVoxelStaysRigid)
{
  for (const int n : reductions)
  {
    // A rod in steps through elements of any alignment, with a soft body around it.
    Scene scene({ 45, 22, 24 }, 0.3f);
    scene.anchors.faces[4] = true;
    std::vector<std::size_t> rod;
    int j = 5, k = 9;
    for (int i = 4; i < 41; ++i)
    {
      rod.push_back(scene.grid.at(i, j, k));
      if (i % 3 == 0)
      {
        rod.push_back(scene.grid.at(i, i % 2 ? ++j : j, i % 2 ? k : ++k));
      }
    }
    for (const std::size_t v : rod)
    {
      scene.constraint[v] = 0.0f;
    }
    Simulation simulation = reduced(scene, n);
    simulation.pull({ probeAt(scene, { 8, 19, 20 }, { 1.0, 4.0, 3.0 }, 3.0) });
    simulation.relax(60, 0.0);
    const std::vector<float> u = displacements(simulation);
    EXPECT_GT(std::abs(u[3 * rod[0] + 1]), 0.2f) << n; // it moves along
    for (const std::size_t v : rod)
    {
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_EQ(u[3 * v + a], u[3 * rod[0] + a]) << n;
      }
    }
    EXPECT_EQ(clusters(simulation)[rod.back()], 0);
    const std::vector<std::uint8_t> bits = links(simulation);
    EXPECT_EQ(bits[scene.grid.at(10, 10, 10)], 63); // the links of the voxels
  }
}

TEST(ModelReduction, AWallOfASingleVoxelHoldsTogetherAndAGapKeepsApart)
{
  for (const int n : reductions)
  {
    // A bent wall in air, from a held face to a handle. Pulled taut, all of it must move along.
    Scene scene({ 36, 20, 20 }, 0.1f);
    scene.anchors.faces[0] = true;
    scene.each(
      [&](int i, int j, int k)
      {
        if (j != 6 + i / 7)
        {
          scene.air(i, j, k);
        }
        if (i % 7 == 0 && j == 5 + i / 7)
        {
          scene.scalar[scene.grid.at(i, j, k)] = 1.0f;
        }
      });
    Simulation simulation = reduced(scene, n);
    const auto pulled = simulation.pull({ probeAt(scene, { 35, 11, 10 }, { 100.0, 0.0, 0.0 }) });
    // 40 links from end to end at a tenth each, minus about half an element at both ends.
    EXPECT_GT(pulled[0].reached[0], 0.1 * (40 - 2 * n)) << n;
    EXPECT_LT(pulled[0].reached[0], 0.1 * (40 + n)) << n;

    // Two bodies with a gap of 2 n voxels, for any alignment of elements.
    for (int shift = 0; shift < n; ++shift)
    {
      Scene bodies({ 8 * n + 3, 12, 12 }, 0.2f);
      const int left = 2 * n + shift, right = left + 2 * n;
      bodies.each(
        [&](int i, int j, int k)
        {
          if (i >= left && i < right)
          {
            bodies.air(i, j, k);
          }
        });
      Simulation two = reduced(bodies, n);
      two.pull({ probeAt(bodies, { left - 1, 6, 6 }, { 0.0, 7.0, 0.0 }, 2.0) });
      two.relax(200, 0.0);
      const std::vector<float> u = displacements(two);
      bodies.each(
        [&](int i, int j, int k)
        {
          if (i >= right)
          {
            ASSERT_EQ(u[3 * bodies.grid.at(i, j, k) + 1], 0.0f);
          }
        });
      EXPECT_GT(std::abs(u[3 * bodies.grid.at(0, 6, 6) + 1]), 1.0f);
    }
  }
}

TEST(ModelReduction, ACutStaysACutToTheVoxel)
{
  for (const int n : reductions)
  {
    // Blades between elements, through their middles and their edges; axis-parallel and oblique.
    for (const double slope : { 0.0, 0.3, -1.0 })
    {
      for (const double place : { 15.5, 16.5, 17.5, 20.5 })
      {
        Scene scene({ 40, 26, 26 }, 0.3f);
        scene.anchors.faces[0] = true;
        Surface blade;
        for (const Vector3& p :
          { Vector3{ -60, -60, -60 }, Vector3{ 60, -60, -60 }, Vector3{ 60, 60, 60 }, Vector3{ -60, 60, 60 } })
        {
          // Points (s, t): x = place + slope * (y - 13), any z.
          blade.points.push_back({ place + slope * (p[0] - 13.0), p[0], p[2] });
        }
        blade.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        const auto right = [&](int i, int j) { return i > place + slope * (j - 13.0); };
        Simulation simulation = reduced(scene, n);
        EXPECT_GT(simulation.cut(blade), 26u * 26u - 1);
        const Index3 handle{ 36, 13, 13 };
        simulation.pull({ probeAt(scene, handle, { 5.0, 3.0, 0.0 }, 2.0) });
        simulation.relax(300, 1e-5);
        const Statistics statistics = simulation.measure();
        EXPECT_LT(statistics.maxLinkExcess, 1e-5);
        EXPECT_LT(statistics.energy, 1e-3) << n << ' ' << slope << ' ' << place; // no component is held on both sides
        const std::vector<float> u = displacements(simulation);
        scene.each(
          [&](int i, int j, int k)
          {
            const float* v = u.data() + 3 * scene.grid.at(i, j, k);
            ASSERT_NEAR(v[0], right(i, j) ? 5.0 : 0.0, 0.1) << n << ' ' << slope << ' ' << i << ' ' << j << ' ' << k;
            ASSERT_NEAR(v[1], right(i, j) ? 3.0 : 0.0, 0.1);
          });
        simulation.restoreTopology();
        EXPECT_EQ(links(simulation), links(reduced(scene, n)));
        simulation.pull({ probeAt(scene, handle, { 40.0, 0.0, 0.0 }, 2.0) });
        EXPECT_GT(displacements(simulation)[3 * scene.grid.at(8, 13, 13)], 0.5f) << "mended tissue pulls";
      }
    }
  }
}

TEST(ModelReduction, CutsAtTheCurrentPlacesAndLipsOpen)
{
  for (const int n : { 2, 4 })
  {
    // An incision half through pulled tissue, then a further pull. Each side keeps its tissue, and a gap opens.
    Scene scene({ 48, 32, 40 }, 0.3f);
    scene.anchors.faces[4] = true;
    Simulation simulation = reduced(scene, n);
    Probe left = probeAt(scene, { 16, 16, 36 }, { -2.0, 0.0, 0.0 }, 5.0);
    Probe right = probeAt(scene, { 32, 16, 36 }, { 2.0, 0.0, 0.0 }, 5.0);
    simulation.pull({ left, right });
    simulation.relax(30, 1e-4);
    const std::vector<float> before = displacements(simulation);
    Surface blade{ { { 24.3, -9, 20 }, { 24.3, 60, 20 }, { 24.3, -9, 80 }, { 24.3, 60, 80 } },
      { { 0, 1, 2 }, { 1, 3, 2 } } };
    EXPECT_GT(simulation.cut(blade), 300u);
    const std::vector<std::uint8_t> bits = links(simulation);
    scene.each(
      [&](int i, int j, int k)
      {
        // By the places in the output before the cut.
        const float* u = before.data() + 3 * scene.grid.at(i, j, k);
        if (i + 1 < 48 && k > 24)
        {
          const float* w = before.data() + 3 * scene.grid.at(i + 1, j, k);
          const bool crosses = (i + u[0] < 24.3) != (i + 1 + w[0] < 24.3);
          ASSERT_EQ((bits[scene.grid.at(i, j, k)] & 2) == 0, crosses);
        }
      });
    left.displacement[0] = -5.0;
    right.displacement[0] = 5.0;
    const auto results = simulation.pull({ left, right });
    simulation.relax(100, 1e-4);
    const Picture picture = resample(simulation);
    int gap = 0;
    while (gap < 20 && picture.vacated(24 + gap, 16, 38))
    {
      ++gap;
    }
    EXPECT_GE(gap, 2) << n;
    EXPECT_LE(gap, 6) << n; // the lips are at most 10 voxels apart
    EXPECT_NEAR(results[1].reached[0], 5.0, 1e-4);
  }
}

TEST(ModelReduction, ThroughAHoleMadeByCarvingNothingPulls)
{
  for (const int n : reductions)
  {
    Scene scene({ 40, 22, 22 }, 0.3f);
    scene.anchors.faces[0] = true;
    Simulation simulation = reduced(scene, n);
    const Probe probe = probeAt(scene, { 33, 11, 11 }, { 6.0, 2.0, 0.0 }, 2.0);
    simulation.pull({ probe });
    simulation.relax(10, 0.0);
    const std::vector<float> u = displacements(simulation);
    // A slab thinner than an element, at the current places: it removes voxels, but hardly an element.
    std::size_t inside = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        const double x = i + static_cast<double>(u[3 * scene.grid.at(i, j, k)]);
        inside += x > 14.25 && x < 16.25;
      });
    EXPECT_EQ(simulation.carve(box({ 14.25, -50, -50 }, { 16.25, 90, 90 })), inside);
    EXPECT_GT(inside, 0u);
    simulation.relax(300, 0.0);
    EXPECT_LT(simulation.measure().energy, 1e-2) << n;
    // All tissue around the handle: its elements become empty, and the probe holds nothing any more.
    EXPECT_GT(simulation.carve(sphere({ 39, 13, 11 }, 30.0, 12, 24)), 0u);
    EXPECT_EQ(simulation.probes()[0].elements, 0u);
    simulation.restoreTopology();
    EXPECT_EQ(simulation.measure().displaced, 0u);
    std::vector<std::uint8_t> tissue(scene.grid.voxels());
    simulation.elements(tissue.data());
    EXPECT_EQ(tissue, std::vector<std::uint8_t>(scene.grid.voxels(), 1));
  }
}

TEST(ModelReduction, NearTheWholeModelsOptimum)
{
  // A smooth block with a stiff inclusion: each reduction against the converged whole model. The error grows with the
  // reduction.
  Scene scene({ 48, 40, 44 }, 0.25f);
  scene.anchors.faces[4] = true;
  scene.each(
    [&](int i, int j, int k)
    {
      scene.give(i, j, k, 0.2f + 0.1f * static_cast<float>(std::sin(0.2 * i) * std::cos(0.15 * j + 0.1 * k)));
      if (std::hypot(i - 20.0, j - 20.0, k - 16.0) < 7.0)
      {
        scene.give(i, j, k, 0.05f);
      }
    });
  const std::vector<Probe> probes{ probeAt(scene, { 24, 20, 38 }, { 3.0, 1.5, 2.0 }, 6.0) };
  const oracle::Block block = scene.block();
  const auto run = [&](int n, double* energy, double* force)
  {
    Simulation simulation = reduced(scene, n);
    simulation.setCoarseToFine(true);
    simulation.pull(probes);
    simulation.relax(800, 1e-6);
    EXPECT_LT(simulation.measure().maxLinkExcess, 1e-5);
    *energy = simulation.measure().energy;
    *force = simulation.probes()[0].force[0];
    return state(simulation);
  };
  double energy = 0.0, force = 0.0;
  const auto optimum = run(1, &energy, &force);
  const double moved = rms(block, optimum, std::vector<oracle::Vector3>(block.count()));
  double last = 0.0;
  for (const int n : reductions)
  {
    double energyOf = 0.0, forceOf = 0.0;
    const double error = rms(block, run(n, &energyOf, &forceOf), optimum);
    RecordProperty("rmsOf" + std::to_string(n), std::to_string(error / moved));
    EXPECT_GT(error, last) << n;
    EXPECT_GT(error, 0.002 * moved) << n; // the model is coarser
    EXPECT_LT(error, 0.05 * n * moved) << n;
    // A link stands for n^2 links, so energies of all reductions are comparable. The handle has the size of whole
    // elements.
    EXPECT_NEAR(energyOf / energy, 1.0, 0.1 * n) << n;
    EXPECT_NEAR(forceOf / force, 1.0, 0.1 * n) << n;
    last = error;
  }
}

TEST(ModelReduction, TimesAndWavesAreThoseOfTheElements)
{
  for (const int n : reductions)
  {
    Scene scene({ 40, 9, 9 }, 0.25f);
    scene.grid.spacing = { 2.0, 1.0, 1.0 };
    Simulation simulation = reduced(scene, n);
    simulation.setPropagationTimes(true);
    simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 60.0, 0.0, 0.0 }) });
    std::vector<float> times(scene.grid.voxels());
    std::vector<int> fronts(scene.grid.voxels());
    simulation.propagationTimes(times.data());
    simulation.wavefronts(fronts.data());
    scene.each(
      [&](int i, int j, int k)
      {
        // As many links as there are elements between, each n voxels long.
        const double expected = 0.25 * n * (i / n + j / n + k / n);
        EXPECT_NEAR(times[scene.grid.at(i, j, k)], expected, 1e-4);
        EXPECT_EQ(fronts[scene.grid.at(i, j, k)], 1);
      });
  }
}

TEST(ModelReduction, RandomLivesAreFiniteTheSameAgainAndEndAtRest)
{
  for (int seed = 0; seed < 12; seed += CHAINMAIL_LONG ? 1 : 7)
  {
    const int n = reductions[seed % 3];
    const std::vector<Index3> sizes{ { 25, 22, 19 }, { 40, 33, 1 }, { 16, 32, 24 }, { 31, 7, 12 } };
    Scene scene = randomScene(sizes[seed / 3 % 4], seed % 2 == 0 ? 1 : 3, 4000 + seed, 0.2, 0.01);
    scene.grid.spacing = { 0.8, 1.0, 1.6 };
    scene.anchors.faces[0] = seed % 4 < 2;
    scene.anchors.rigid = seed % 5 == 0;
    const oracle::Block block = scene.block();
    std::vector<std::vector<float>> first;
    for (int life = 0; life < 2; ++life)
    {
      Simulation simulation = reduced(scene, n, { 8, 4, 8 });
      simulation.setCoarseToFine(seed % 2 == 0);
      simulation.setPropagation(seed % 3 == 1 ? PropagationMethod::Timestamp : PropagationMethod::Envelope,
        seed % 4 == 3 ? ConflictPolicy::Latest : ConflictPolicy::Limit);
      simulation.setRelaxation(RelaxationMethod::Projected, seed % 3 == 2 ? 0.7 : 1.0);
      Random random(5000 + seed);
      std::vector<Probe> probes;
      std::size_t step = 0;
      for (int update = 0; update < 8; ++update)
      {
        const Index3 p = randomElement(scene, random);
        const Vector3 place = scene.place(p[0], p[1], p[2]);
        const double size = scene.grid.size[0] * scene.grid.spacing[0];
        if (update == 2 || update == 5)
        {
          Vector3 tilt{ random(-1, 1), random(-1, 1), random(-1, 1) };
          simulation.cut({ { { place[0] - size, place[1] - size * tilt[0], place[2] - size },
                             { place[0] + size, place[1] + size * tilt[1], place[2] - size },
                             { place[0] + size * tilt[2], place[1], place[2] + size } },
            { { 0, 1, 2 } } });
        }
        else if (update == 3 || update == 6)
        {
          simulation.carve(sphere(place, random(1.0, 4.0), 6, 8));
        }
        else
        {
          probes.push_back(probeAt(scene, p, { random(-4, 4), random(-4, 4), random(-4, 4) }, random(0, 4)));
          try
          {
            simulation.hold(probes);
          }
          catch (const ProbeError&)
          {
            probes.pop_back(); // the tissue has moved away
          }
        }
        simulation.propagate(update % 2 == 0 ? 0 : 3);
        simulation.relax(6, 0.0);
        if (update == 7)
        {
          simulation.propagate(0);
          simulation.relax(2, 0.0);
          EXPECT_LT(simulation.measure().maxLinkExcess, 1e-4) << seed;
        }
        std::vector<float> u = displacements(simulation);
        const std::vector<int> label = clusters(simulation);
        std::vector<std::uint8_t> tissue(block.count());
        simulation.elements(tissue.data());
        for (std::size_t v = 0; v < block.count(); ++v)
        {
          for (int a = 0; a < 3; ++a)
          {
            ASSERT_TRUE(std::isfinite(u[3 * v + a])) << seed;
            ASSERT_TRUE(u[3 * v + a] == 0.0f || (tissue[v] && !block.anchored[v])) << seed;
          }
        }
        if (update == 4)
        {
          for (const float offset : resample(simulation, { 2, 0, 0 }).offset)
          {
            ASSERT_TRUE(std::isnan(offset) || std::abs(offset) < 1e3f);
          }
        }
        for (const ProbeResult& result : simulation.probes())
        {
          ASSERT_TRUE(std::isfinite(result.force[0] + result.force[1] + result.force[2] + result.reached[0]));
        }
        if (life == 0)
        {
          first.push_back(std::move(u));
        }
        else
        {
          ASSERT_TRUE(sameBits(u, first[step])) << seed << ' ' << step;
        }
        ++step;
      }
      simulation.restoreTopology();
      ASSERT_EQ(displacements(simulation), std::vector<float>(3 * block.count(), 0.0f));
      EXPECT_EQ(links(simulation), links(reduced(scene, n)));
      // The same as a new simulation.
      const Probe probe = probeAt(scene, randomElement(scene, random), { 1.0, 2.0, 1.0 }, 2.0);
      Simulation other = reduced(scene, n, { 8, 4, 8 });
      for (Simulation* s : { &simulation, &other })
      {
        s->setPropagation(PropagationMethod::Envelope, ConflictPolicy::Limit);
        s->setCoarseToFine(false);
        s->setRelaxation(RelaxationMethod::Projected, 1.0);
        s->pull({ probe });
        s->relax(5, 0.0);
      }
      EXPECT_TRUE(sameBits(displacements(simulation), displacements(other))) << seed;
    }
  }
}

/// The number of floats whose bits differ.
std::size_t different(const std::vector<float>& a, const std::vector<float>& b)
{
  EXPECT_EQ(a.size(), b.size());
  std::size_t count = 0;
  for (std::size_t n = 0; n < a.size(); ++n)
  {
    count += std::memcmp(&a[n], &b[n], sizeof(float)) != 0 && !(std::isnan(a[n]) && std::isnan(b[n])) ? 1 : 0;
  }
  return count;
}

// Where the displacements of all voxels need too much memory, they are made for some bricks at a time: the picture, its
// parts for other processes and the displacements are the same bits.
TEST(ModelReduction, InPartsTheBitsAreTheSame)
{
  for (const int reduction : { 2, 8 })
  {
    const bool rotations = reduction == 8;
    Scene scene({ 104, 72, 64 }, 0.08f);
    Random random(5);
    for (int n = 0; n < 2000; ++n)
    {
      scene.air(random.below(104), random.below(72), random.below(64));
    }
    scene.anchors.faces.fill(false);
    for (int i = 20; i < 52; ++i) // a bone
    {
      for (int j = 26; j < 34; ++j)
      {
        scene.constraint[scene.grid.at(i, j, 44)] = 0.0f;
      }
    }
    Settings settings;
    settings.device = testDevice();
    settings.brickSize = { 8, 4, 4 };
    settings.modelReduction = reduction;
    settings.rotations = rotations;
    const auto live = [&]
    {
      Simulation simulation(scene.model(), settings);
      simulation.cut(sheet(-2.0, -2.0, 12.0, 9, 4, [](double x, double y) { return 29.3 + 0.11 * x - 0.13 * y; }));
      simulation.carve(sphere(scene.place(60, 30, 50), 6.1, 12, 16));
      Probe probe = probeAt(scene, { 36, 30, 44 }, { 3.4, -2.1, 5.3 });
      probe.radius = 7.0;
      simulation.pull({ probe });
      simulation.relax(8, 0.0);
      return simulation;
    };
    const Simulation whole = live();
    const VoxelBox box{ { 11, 5, 8 }, { 40, 44, 30 } };
    std::vector<float> expected(3 * box.voxels());
    whole.displacements(box, expected.data());
    ASSERT_FALSE(whole.portions({ 3, 0, 2 }, CutSurfaces::Smooth, {}));

    const Variable few("CHAINMAIL_VOXELS_AT_ONCE", "150000"); // of 479,232
    const Simulation parts = live();
    std::vector<float> found(3 * box.voxels());
    parts.displacements(box, found.data());
    EXPECT_EQ(different(expected, found), 0u);
    for (const CutSurfaces cuts : { CutSurfaces::Stepped, CutSurfaces::Smooth })
    {
      OutputDetail detail;
      detail.finer = cuts == CutSurfaces::Smooth ? 2 : 1;
      const Picture first = resample(whole, { 3, 0, 2 }, cuts, detail);
      const Picture other = resample(parts, { 3, 0, 2 }, cuts, detail);
      EXPECT_EQ(different(first.offset, other.offset), 0u) << reduction << ' ' << rotations;
      EXPECT_EQ(different(first.coverage, other.coverage), 0u);

      // Voxels that no portion has are at rest.
      const std::vector<OutputDetail> portions = parts.portions({ 3, 0, 2 }, cuts, detail).value();
      EXPECT_GT(portions.size(), 4u);
      std::vector<TissueReceiver> receivers;
      for (const OutputDetail& portion : portions)
      {
        receivers.push_back({ 1, portion, {} });
      }
      std::vector<float> assembled(first.offset.size(), 0.0f);
      std::size_t complete = 0;
      Resampler resampler(testDevice());
      parts.exportTissue({ 3, 0, 2 }, cuts, receivers,
        [&](std::size_t, const std::vector<char>& message)
        {
          resampler.take(message);
          if (resampler.version() == TissueVersion())
          {
            return;
          }
          ++complete;
          resampler.resample(
            [&](const std::vector<ResampledBox>& boxes)
            {
              for (const ResampledBox& one : boxes)
              {
                one.forCovered([&](const Index3& voxel, const float* offset, float)
                  { std::copy_n(offset, 3, assembled.begin() + 3 * first.at(voxel[0], voxel[1], voxel[2])); });
              }
            });
        });
      EXPECT_EQ(complete, portions.size());
      EXPECT_EQ(different(first.offset, assembled), 0u) << reduction << ' ' << rotations;
    }

    // Tissue that has moved on.
    Simulation later = live();
    Probe probe = probeAt(scene, { 36, 30, 44 }, { 1.4, 2.1, 2.3 });
    probe.radius = 7.0;
    const Picture before = resample(later, { 0, 0, 0 }, CutSurfaces::Stepped);
    later.pull({ probe });
    later.relax(4, 0.0);
    const Variable all("CHAINMAIL_VOXELS_AT_ONCE", nullptr);
    Simulation same = live();
    same.pull({ probe });
    same.relax(4, 0.0);
    EXPECT_EQ(different(resample(same, { 0, 0, 0 }, CutSurfaces::Stepped).offset,
                resample(later, { 0, 0, 0 }, CutSurfaces::Stepped).offset),
      0u);
  }
}

TEST(ModelReduction, OneIsTheWholeModel)
{
  // A reduction of 1 gives the same bits as the default, with cuts, carves and resampling.
  const Scene scene = randomScene({ 20, 18, 16 }, 1, 31);
  Settings settings;
  settings.device = testDevice();
  EXPECT_EQ(settings.modelReduction, 1);
  Simulation one = reduced(scene, 1), other = simulate(scene);
  for (Simulation* simulation : { &one, &other })
  {
    simulation->cut(planeAcrossX(9.5));
    simulation->pull({ probeAt(scene, { 4, 9, 8 }, { 2.0, 3.0, 1.0 }, 3.0) });
    simulation->relax(10, 0.0);
  }
  EXPECT_TRUE(sameBits(displacements(one), displacements(other)));
  EXPECT_EQ(one.measure().energy, other.measure().energy);
}

// Where each process has a part of the scan, elements whose voxels are all in one part are made there. The model and
// its missing links are the same bits, and of a part only its sides are read.
TEST(ModelReduction, ElementsMadeElsewhereAreTheSameBits)
{
  const std::shared_ptr<Context> context = Context::of(testDevice());
  for (int seed = 0; seed < 60; ++seed)
  {
    Random random(seed);
    const Grid grid{ { random.between(1, 60), random.between(1, 60), random.between(1, 60) }, { 1.0, 1.0, 1.0 } };
    const int reduction = random.of({ 2, 4, 8 });
    std::vector<std::uint8_t> values(grid.voxels());
    for (std::uint8_t& value : values)
    {
      value = static_cast<std::uint8_t>(random.below(random.chance(0.001) ? 5 : 256));
    }
    ArrayView scalars;
    scalars.data = values.data();
    scalars.type = ArrayView::Type::UInt8;
    Material material;
    material.tissueThreshold = random.of({ 10.0, 100.0, 200.0 });
    material.constraint = [](double value) { return value > 250.0 ? 0.0 : 0.001 + value / 300.0; };
    // In some trials constraints are those of an array, or also those of a region.
    std::vector<float> fractions(3 * grid.voxels());
    std::generate(fractions.begin(), fractions.end(),
      [&] { return random.chance(0.05) ? 0.0f : static_cast<float>(random(0.01, 0.9)); });
    if (random.chance(0.3))
    {
      material.constraintArray.data = fractions.data();
      material.constraintArray.type = ArrayView::Type::Float32;
      material.constraintArray.components = random.of({ 1, 3 });
    }
    if (random.chance(0.3))
    {
      material.regions.push_back(
        { { random(0.0, 30.0), random(0.0, 30.0), random(0.0, 30.0) }, random(0.0, 20.0), random.of({ 0.0, 0.3 }) });
    }
    Anchors anchors;
    anchors.rigid = random.chance(0.3);
    for (bool& face : anchors.faces)
    {
      face = random.chance(0.5);
    }

    // Boxes of any size, the parts of some processes.
    std::vector<VoxelBox> parts{ VoxelBox::all(grid) };
    for (int n = random.below(5); n > 0; --n)
    {
      VoxelBox& part = parts[random.below(static_cast<int>(parts.size()))];
      const int axis = random.below(3);
      const int low = random.between(0, part.size[axis]);
      VoxelBox other = part;
      part.size[axis] = low;
      other.first[axis] += low;
      other.size[axis] -= low;
      parts.push_back(other);
    }
    std::size_t read = 0;
    ArrayView elsewhere = scalars;
    elsewhere.data = nullptr;
    elsewhere.read = [&](std::size_t first, int count) -> const void*
    {
      read += count;
      return values.data() + first;
    };
    std::size_t inside = 0;
    Material there = material;
    there.count = [&] { return Constraints(grid, scalars, material).count(VoxelBox::all(grid)); };
    there.reduce = [&](const Index3& factor)
    {
      std::vector<ReducedBox> boxes;
      for (const VoxelBox& part : parts)
      {
        // Where a process has no voxels, it must not read any.
        ArrayView own = scalars;
        own.data = nullptr;
        own.read = [&](std::size_t first, int count) -> const void*
        {
          const Index3 at = grid.indexOf(first);
          EXPECT_TRUE(part.contains({ at, { count, 1, 1 } }));
          return values.data() + first;
        };
        boxes.push_back(Constraints(grid, own, material).reduce(factor, anchors.rigid, part));
        const VoxelBox& elements = boxes.back().elements;
        std::size_t voxels = elements.voxels() > 0 ? 1 : 0;
        for (int a = 0; a < 3; ++a)
        {
          voxels *= static_cast<std::size_t>(std::max(0, elements.size[a] - 2) * factor[a]);
        }
        inside += voxels;
      }
      return boxes;
    };
    std::array<std::vector<float>, 2> rows;
    std::array<std::vector<std::pair<std::size_t, int>>, 2> apart;
    for (int way = 0; way < 2; ++way)
    {
      std::shared_ptr<const Model> model;
      try
      {
        model =
          std::make_shared<const Model>(grid, way == 0 ? scalars : elsewhere, way == 0 ? material : there, anchors);
      }
      catch (const InputError&)
      {
        continue; // all is air
      }
      Index3 factor;
      for (int a = 0; a < 3; ++a)
      {
        factor[a] = grid.size[a] > 1 ? reduction : 1;
      }
      const Bricks bricks(context, model, { 8, 4, 4 }, RotationSettings());
      const std::shared_ptr<const Model> reduced = reducedModel(bricks, factor, apart[way]);
      const Grid& of = reduced->grid();
      const auto axes = static_cast<std::size_t>(reduced->axes());
      rows[way].resize(axes * of.voxels());
      for (int k = 0; k < of.size[2]; ++k)
      {
        for (int j = 0; j < of.size[1]; ++j)
        {
          reduced->row(0, j, k, of.size[0], rows[way].data() + axes * of.at(0, j, k));
        }
      }
    }
    EXPECT_EQ(different(rows[0], rows[1]), 0u) << seed;
    EXPECT_EQ(apart[0], apart[1]) << seed;
    EXPECT_EQ(read, rows[1].empty() ? 0u : grid.voxels() - inside) << seed;
  }
}
