// Carving: which elements it removes, against winding numbers and closed forms. The remaining tissue behaves as if the
// removed elements had never existed.

#include "../../Oracles/Inside.h"
#include "Blades.h"
#include "Picture.h"

#include <algorithm>
#include <functional>

namespace
{

using namespace chainmail;

std::vector<std::uint8_t> elements(const Simulation& simulation)
{
  std::vector<std::uint8_t> tissue(simulation.model().grid().voxels());
  simulation.elements(tissue.data());
  return tissue;
}

/// The scene with air in place of removed tissue.
Scene without(const Scene& scene, const Simulation& simulation)
{
  Scene rest = scene;
  const std::vector<std::uint8_t> tissue = elements(simulation);
  for (std::size_t v = 0; v < tissue.size(); ++v)
  {
    rest.scalar[v] = tissue[v] ? scene.scalar[v] : 0.0f;
  }
  return rest;
}

/// The engine against winding numbers at the current places. Elements within 1e-3 mm of the surface are left out:
/// rounding to 1/4096 voxel may decide them.
void expectWhatIsInside(const Scene& scene, Simulation& simulation, const Surface& surface)
{
  const std::vector<std::uint8_t> before = elements(simulation);
  const std::vector<oracle::Vector3> u = state(simulation);
  const std::size_t removed = simulation.carve(surface);
  const std::vector<std::uint8_t> after = elements(simulation);
  std::size_t gone = 0, wrong = 0, unsure = 0, kept = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const std::size_t v = scene.grid.at(i, j, k);
      if (!before[v])
      {
        wrong += after[v];
        return;
      }
      gone += !after[v];
      kept += after[v];
      Vector3 place = scene.place(i, j, k);
      for (int a = 0; a < 3; ++a)
      {
        place[a] += u[v][a] * scene.grid.spacing[a];
      }
      const int inside = oracle::inside(place, 1e-3, surface.points, surface.triangles);
      unsure += inside < 0;
      wrong += inside >= 0 && (inside == 1) == (after[v] != 0);
    });
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(removed, gone);
  EXPECT_GT(gone, 20u);
  EXPECT_GT(kept, 20u);
  EXPECT_LT(unsure, 20u) << "the surface is not in general position";
}

/// The state and its figures are those of the remaining tissue.
void expectConsistent(const Scene& scene, const Simulation& simulation)
{
  const Scene rest = without(scene, simulation);
  oracle::Block block = rest.block();
  const std::vector<std::uint8_t> bits = links(simulation);
  takeLinks(block, bits);
  EXPECT_EQ(oracle::linkBits(block), bits);
  const std::vector<oracle::Vector3> u = state(simulation);
  std::size_t displaced = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    const bool moved = u[v] != oracle::Vector3{};
    displaced += moved;
    ASSERT_FALSE(moved && !block.tissue[v]) << "removed elements are nowhere";
  }
  const Statistics statistics = simulation.measure();
  EXPECT_EQ(statistics.displaced, displaced);
  const double energy = oracle::energy(block, u);
  EXPECT_NEAR(statistics.energy, energy, 1e-4 * energy + 1e-9);
  EXPECT_LE(oracle::maxLinkExcess(block, u), 1e-5);
  EXPECT_LE(statistics.maxLinkExcess, 1e-5);
  for (int a = 0; a < simulation.model().axes(); ++a)
  {
    const std::vector<int> expected = oracle::clusters(block, a);
    const std::vector<int> labels = clusters(simulation);
    for (std::size_t v = 0; v < expected.size(); ++v)
    {
      ASSERT_EQ(labels[v * simulation.model().axes() + a], expected[v]);
    }
  }
}

// --- What is inside

TEST(Carve, SolidsHoldWhatTheirWindingNumberSays)
{
  Scene scene = randomScene({ 21, 18, 15 }, 1, 2, 0.1);
  scene.grid.spacing = { 0.9, 1.1, 1.7 };
  const Surface small = sphere({ 9.1, 9.2, 12.3 }, 4.1, 8, 13), large = sphere({ 9.3, 8.1, 12.7 }, 7.63, 12, 17);
  const std::pair<const char*, Surface> cases[] = {
    { "sphere", large },
    { "box", box({ 2.13, 3.27, 4.31 }, { 11.83, 14.17, 19.91 }) },
    { "torus", torus({ 9.13, 9.27, 11.9 }, 5.71, 2.63, 23, 11) },
    { "a sphere in a sphere", both(small, large) },
    { "a sphere with a hollow", both(inverted(small), large) },
    { "spheres that overlap", both(large, sphere({ 13.3, 12.7, 15.1 }, 5.9, 11, 13)) },
    { "a sphere that leaves the image", sphere({ 1.2, 15.3, 3.1 }, 8.3, 11, 13) },
    { "a tetrahedron", { { { -3.1, -2.2, -4.7 }, { 31.3, 4.1, 2.9 }, { 4.4, 28.7, 5.3 }, { 7.9, 6.1, 33.1 } },
                         { { 0, 1, 2 }, { 0, 3, 1 }, { 0, 2, 3 }, { 1, 3, 2 } } } },
  };
  std::size_t n = 0;
  for (const auto& [name, surface] : cases)
  {
    SCOPED_TRACE(name);
    Simulation simulation = simulate(scene, brickSizes()[n++ % 3]);
    expectWhatIsInside(scene, simulation, surface);
    expectConsistent(scene, simulation);
    EXPECT_EQ(simulation.carve(surface), 0u) << "a second time there is nothing left to remove";
  }
}

TEST(Carve, HappensAtTheCurrentDeformation)
{
  for (const int axes : { 1, 3 })
  {
    for (const Index3& brick : brickSizes())
    {
      Scene scene = randomScene({ 20, 16, 14 }, axes, 3, 0.05);
      scene.grid.spacing = { 1.0, 1.25, 0.75 };
      scene.anchors.faces[0] = true;
      Simulation simulation = simulate(scene, brick);
      simulation.pull(compatibleProbes(scene, 3, 3.0, 4));
      simulation.relax(5, 0.0);
      const Surface ball = sphere({ 10.3, 10.2, 5.1 }, 4.4, 9, 13);
      Simulation atRest = simulate(scene);
      atRest.carve(ball);
      expectWhatIsInside(scene, simulation, ball);
      expectConsistent(scene, simulation);
      EXPECT_NE(elements(simulation), elements(atRest)) << "the deformation does not matter: a poor test";
    }
  }
}

TEST(Carve, TissueThatIsFarAway)
{
  Scene scene({ 9, 8, 7 }, 0.0f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 4, 4, 3 }, { 100000.0, -3000.0, 0.25 }) });
  EXPECT_EQ(simulation.carve(box({ -0.5, -0.5, -0.5 }, { 8.5, 7.5, 6.5 })), 0u) << "nobody is here any more";
  // 0.25 further along z: the layers 0 .. 2 are below 2.5.
  EXPECT_EQ(simulation.carve(box({ 99999.5, -3000.5, -1.0 }, { 100008.5, -2992.5, 2.5 })), 9u * 8u * 3u);
  expectConsistent(scene, simulation);
}

// Ties are decided as if the tissue were shifted by an infinitesimal: a box contains its lower faces, not its upper
// ones.
TEST(Carve, ABoxExactlyOnVoxels)
{
  Scene scene({ 20, 16, 12 });
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    EXPECT_EQ(simulation.carve(box({ 3, 4, 5 }, { 9, 8, 7 })), 6u * 4u * 2u);
    const std::vector<std::uint8_t> left = elements(simulation);
    scene.each(
      [&](int i, int j, int k)
      {
        const bool inside = i >= 3 && i < 9 && j >= 4 && j < 8 && k >= 5 && k < 7;
        ASSERT_EQ(left[scene.grid.at(i, j, k)], inside ? 0 : 1);
      });
    EXPECT_EQ(simulation.carve(box({ -7, -7, -7 }, { 3, 40, 40 })), 3u * 16u * 12u);
  }
}

/// Hexahedra that fill [0, cells * step] on every axis. Inner corners are moved to multiples of `snap`. Neighbours
/// share the triangles between them.
std::vector<Surface> brickwork(int cells, int step, double jitter, double snap, std::uint64_t seed)
{
  Random random(seed);
  const int n = cells + 1;
  std::vector<Vector3> points;
  for (int k = 0; k < n; ++k)
  {
    for (int j = 0; j < n; ++j)
    {
      for (int i = 0; i < n; ++i)
      {
        const int p[3] = { i, j, k };
        Vector3 point;
        for (int a = 0; a < 3; ++a)
        {
          const bool border = p[a] == 0 || p[a] == cells;
          point[a] = step * p[a] + (border ? 0.0 : snap * std::round(random(-jitter, jitter) / snap));
        }
        points.push_back(point);
      }
    }
  }
  std::vector<Surface> result;
  for (int k = 0; k < cells; ++k)
  {
    for (int j = 0; j < cells; ++j)
    {
      for (int i = 0; i < cells; ++i)
      {
        Surface cell = box({}, {});
        const int ids[8] = { 0, 1, n, n + 1, n * n, n * n + 1, n * n + n, n * n + n + 1 };
        for (int c = 0; c < 8; ++c)
        {
          cell.points[c] = points[ids[c] + i + n * (j + n * k)];
        }
        // The diagonal of a face starts at its lowest corner, for both cells.
        cell.triangles.clear();
        for (const auto& f :
          { std::array<int, 4>{ 0, 2, 6, 4 }, std::array<int, 4>{ 1, 3, 7, 5 }, std::array<int, 4>{ 0, 4, 5, 1 },
            std::array<int, 4>{ 2, 6, 7, 3 }, std::array<int, 4>{ 0, 1, 3, 2 }, std::array<int, 4>{ 4, 5, 7, 6 } })
        {
          cell.triangles.push_back({ f[0], f[1], f[2] });
          cell.triangles.push_back({ f[0], f[2], f[3] });
        }
        result.push_back(cell);
      }
    }
  }
  return result;
}

TEST(Carve, SolidsThatShareFacesShareOutTheElements)
{
  Scene scene({ 14, 14, 14 }, 0.2f);
  for (const double snap : { 1.0, 0.5, 0.001 })
  {
    SCOPED_TRACE(snap);
    Simulation simulation = simulate(scene, { 4, 4, 4 });
    std::vector<int> owners(scene.grid.voxels(), 0);
    for (const Surface& cell : brickwork(3, 4, 1.2, snap, 5))
    {
      EXPECT_GT(simulation.carve(cell), 0u);
      const std::vector<std::uint8_t> left = elements(simulation);
      for (std::size_t v = 0; v < left.size(); ++v)
      {
        owners[v] += !left[v];
      }
      simulation.restoreTopology();
    }
    int wrong = 0;
    scene.each(
      [&](int i, int j, int k) { wrong += owners[scene.grid.at(i, j, k)] != (i < 12 && j < 12 && k < 12 ? 1 : 0); });
    EXPECT_EQ(wrong, 0);
  }
}

TEST(Carve, SolidsThatShareFacesShareOutDeformedElements)
{
  // Constraints and pull are multiples of 1/8, so deformed elements lie exactly on faces and edges.
  Scene scene({ 14, 14, 14 }, 0.25f);
  const std::vector<Probe> probes{ probeAt(scene, { 7, 7, 7 }, { 1.5, -1.25, 1.0 }) };
  std::vector<int> owners(scene.grid.voxels(), 0);
  std::vector<oracle::Vector3> places;
  for (const Surface& cell : brickwork(3, 4, 1.2, 0.25, 6))
  {
    Simulation simulation = simulate(scene, { 4, 4, 4 });
    simulation.pull(probes);
    places = state(simulation);
    EXPECT_GT(simulation.carve(cell), 0u);
    const std::vector<std::uint8_t> left = elements(simulation);
    for (std::size_t v = 0; v < left.size(); ++v)
    {
      owners[v] += !left[v];
    }
  }
  int wrong = 0, moved = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const oracle::Vector3& u = places[scene.grid.at(i, j, k)];
      bool inside = true;
      for (const double x : { i + u[0], j + u[1], k + u[2] })
      {
        inside = inside && x >= 0.0 && x < 12.0;
      }
      moved += u != oracle::Vector3{};
      wrong += owners[scene.grid.at(i, j, k)] != (inside ? 1 : 0);
    });
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(moved, 200);
}

TEST(Carve, OnlyTheShapeOfTheSurfaceMatters)
{
  Scene scene({ 16, 16, 16 });
  const Surface ball = sphere({ 8, 8, 8 }, 5.0, 16, 24); // poles and rings on voxels
  Simulation reference = simulate(scene);
  ASSERT_GT(reference.carve(ball), 400u);
  const std::vector<std::uint8_t> expected = elements(reference);

  Surface rotated = ball, degenerate = ball, unused = ball;
  Random random(7);
  for (std::array<int, 3>& t : rotated.triangles)
  {
    if (random.below(2))
    {
      std::swap(t[0], t[1]);
    }
    std::rotate(t.begin(), t.begin() + random.below(3), t.end());
  }
  degenerate.triangles.push_back({ 3, 3, 3 });
  degenerate.triangles.push_back({ 3, 9, 3 });
  degenerate.triangles.push_back({ 4, 4, 5 });
  // An edge that is split on one side only, with a degenerate triangle in between.
  {
    const std::array<int, 3> t = degenerate.triangles.front();
    Vector3 middle;
    for (int a = 0; a < 3; ++a)
    {
      middle[a] = 0.5 * (degenerate.points[t[0]][a] + degenerate.points[t[1]][a]);
    }
    const int m = static_cast<int>(degenerate.points.size());
    degenerate.points.push_back(middle);
    degenerate.triangles.front() = { t[0], m, t[2] };
    degenerate.triangles.push_back({ m, t[1], t[2] });
    degenerate.triangles.push_back({ t[0], t[1], m });
  }
  unused.points.push_back({ 7.3, 5.5, 1.2 });
  for (const auto& [name, surface] : { std::make_pair("rotated", rotated), std::make_pair("separate", soup(ball)),
         std::make_pair("degenerate", degenerate), std::make_pair("unused", unused) })
  {
    SCOPED_TRACE(name);
    Simulation simulation = simulate(scene);
    simulation.carve(surface);
    EXPECT_EQ(elements(simulation), expected);
  }
  Simulation simulation = simulate(scene);
  simulation.carve(both(ball, ball));
  EXPECT_EQ(elements(simulation), expected) << "inside twice is inside";
}

TEST(Carve, AFineSphereIsTheSphere)
{
  Scene scene({ 90, 88, 86 }, 0.2f);
  scene.grid.spacing = { 0.7, 0.7, 0.75 };
  const Vector3 centre{ 30.1, 31.2, 32.3 };
  const double radius = 25.0;
  const Surface fine = sphere(centre, radius, 101, 101);
  ASSERT_GT(fine.triangles.size(), 20000u);
  Simulation simulation = simulate(scene);
  simulation.carve(fine);
  const std::vector<std::uint8_t> left = elements(simulation);
  int wrong = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const Vector3 p = scene.place(i, j, k);
      double square = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        square += (p[a] - centre[a]) * (p[a] - centre[a]);
      }
      // The triangles are at most 0.025 mm below the sphere: r (1 - cos(pi / 101)) for rings and for sectors.
      const double outside = std::sqrt(square) - radius;
      const bool gone = !left[scene.grid.at(i, j, k)];
      wrong += (outside > 1e-3 && gone) || (outside < -0.03 && !gone);
    });
  EXPECT_EQ(wrong, 0);
}

TEST(Carve, SurfacesThatCarveNothingOrAll)
{
  Scene scene({ 8, 8, 8 });
  Simulation simulation = simulate(scene);
  EXPECT_EQ(simulation.carve({}), 0u);
  EXPECT_EQ(simulation.carve({ { { 1, 1, 1 } }, {} }), 0u);
  EXPECT_EQ(simulation.carve(box({ 3.1, 3.1, 3.1 }, { 3.9, 3.9, 3.9 })), 0u);
  EXPECT_EQ(simulation.carve(box({ 30, 30, 30 }, { 39, 39, 39 })), 0u);
  EXPECT_EQ(simulation.carve(box({ -30, -30, -30 }, { -1, 50, 50 })), 0u);
  EXPECT_EQ(simulation.carve(box({ 2, 2, 2 }, { 6, 6, 2 })), 0u) << "flat";
  EXPECT_EQ(elements(simulation), std::vector<std::uint8_t>(512, 1));
  EXPECT_EQ(simulation.carve(box({ -1e6, -1e6, -1e6 }, { 1e6, 1e6, 1e6 })), 512u);
  EXPECT_EQ(elements(simulation), std::vector<std::uint8_t>(512, 0));
  EXPECT_EQ(simulation.measure().displaced, 0u);
  const std::string message = messageOf<InputError>(
    [&] {
      simulation.pull({ probeAt(scene, { 3, 3, 3 }, { 1, 0, 0 }) });
    });
  EXPECT_TRUE(contains(message, "holds no tissue")) << message;
  simulation.relax(3, 0.0);
  simulation.restoreTopology();
  EXPECT_EQ(simulation.pull({ probeAt(scene, { 3, 3, 3 }, { 1, 0, 0 }) })[0].reached[0], 1.0);
}

TEST(Carve, RefusedSurfacesChangeNothing)
{
  Scene scene({ 16, 14, 12 });
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 8, 7, 6 }, { 1.5, 0.5, 0.0 }) });
  const std::vector<float> before = displacements(simulation);
  const Surface whole = sphere({ 8, 7, 6 }, 4.0, 8, 12);

  Surface open = whole;
  open.triangles.pop_back();
  std::string message = messageOf<InputError>([&] { simulation.carve(open); });
  EXPECT_TRUE(contains(message, "not closed") && contains(message, "3 of its edges") && contains(message, "Fill"))
    << message;

  message = messageOf<InputError>([&] { simulation.carve(planeAcrossX(7.5)); });
  EXPECT_TRUE(contains(message, "4 of its edges")) << message;

  Surface torn = soup(whole);
  torn.points[100][0] += 0.01; // forty times the rounding
  message = messageOf<InputError>([&] { simulation.carve(torn); });
  EXPECT_TRUE(contains(message, "not closed") && contains(message, "merge")) << message;

  Surface triple = whole;
  triple.triangles.push_back(whole.triangles[5]); // three triangles at its edges
  message = messageOf<InputError>([&] { simulation.carve(triple); });
  EXPECT_TRUE(contains(message, "3 of its edges")) << message;

  Surface infinite = whole;
  infinite.points[7][2] = std::numeric_limits<double>::quiet_NaN();
  message = messageOf<InputError>([&] { simulation.carve(infinite); });
  EXPECT_TRUE(contains(message, "Point 7 of the carve") && contains(message, "not finite")) << message;

  Surface missing = whole;
  missing.triangles[3][1] = static_cast<int>(whole.points.size());
  message = messageOf<InputError>([&] { simulation.carve(missing); });
  EXPECT_TRUE(contains(message, "names point")) << message;

  EXPECT_TRUE(sameBits(displacements(simulation), before));
  EXPECT_EQ(elements(simulation), std::vector<std::uint8_t>(scene.grid.voxels(), 1));
  EXPECT_EQ(simulation.probes()[0].elements, 1u);
}

// --- What is left

// Tissue that is carved at rest, before or after a wave reaches it, is exactly like air.
TEST(Carve, WhatIsLeftIsAsIfTheRestHadNeverBeen)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 22, 18, 16 }, axes, 8, 0.1, 0.15);
    scene.anchors.faces[0] = true;
    const Surface solid = both(sphere({ 12.2, 9.1, 8.3 }, 4.7, 9, 12), box({ 16.2, -3.0, 2.2 }, { 18.7, 9.3, 19.0 }));
    Simulation first = simulate(scene);
    ASSERT_GT(first.carve(solid), 300u);
    const Scene rest = without(scene, first);
    const std::vector<Probe> probes = compatibleProbes(rest, 3, 3.0, 9);
    Simulation reference = simulate(rest);
    const auto expected = reference.pull(probes);
    const std::vector<float> pulled = displacements(reference);
    reference.relax(12, 0.0);
    const std::vector<float> relaxed = displacements(reference);

    for (const Index3& brick : brickSizes())
    {
      for (const bool reachedBefore : { false, true })
      {
        SCOPED_TRACE(testing::Message() << axes << " axes, brick " << brick[0] << ", reached " << reachedBefore);
        Simulation simulation = simulate(scene, brick);
        if (reachedBefore)
        {
          Random random(3);
          simulation.pull({ probeAt(scene, randomElement(scene, random), { 4.0, 3.0, -4.0 }) });
          simulation.relax(3, 0.0);
          simulation.reset();
        }
        simulation.carve(solid);
        expectConsistent(scene, simulation);
        const auto results = simulation.pull(probes);
        for (std::size_t n = 0; n < results.size(); ++n)
        {
          EXPECT_EQ(results[n].reached, expected[n].reached);
          EXPECT_EQ(results[n].elements, expected[n].elements);
        }
        EXPECT_TRUE(sameBits(displacements(simulation), pulled));
        EXPECT_EQ(clusters(simulation), clusters(reference));
        simulation.relax(12, 0.0);
        EXPECT_TRUE(sameBits(displacements(simulation), relaxed));
        expectConsistent(scene, simulation);
        for (std::size_t n = 0; n < results.size(); ++n)
        {
          const Vector3 a = simulation.probes()[n].force, b = reference.probes()[n].force;
          EXPECT_EQ(a, b);
        }
      }
    }
  }
}

TEST(Carve, TheWaveGoesAroundTheHole)
{
  for (const PropagationMethod method : { PropagationMethod::Envelope, PropagationMethod::Timestamp })
  {
    Scene scene = randomScene({ 24, 20, 6 }, 1, 12, 0.0, 0.0);
    const Surface wall = box({ 10.3, -5.0, -5.0 }, { 13.6, 16.4, 20.0 });
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      simulation.setPropagation(method, ConflictPolicy::Limit);
      simulation.setPropagationTimes(true);
      EXPECT_EQ(simulation.carve(wall), 3u * 17u * 6u);
      const std::vector<Probe> probes{ probeAt(scene, { 6, 4, 3 }, { 8.0, -7.0, 9.0 }) };
      simulation.pull(probes);
      const oracle::Block block = without(scene, simulation).block();
      const auto expected =
        oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes));
      EXPECT_LT(largestDifference(block, state(simulation), expected.state), 1e-5);
      const oracle::Block whole = scene.block();
      const auto straight =
        oracle::propagate(whole, std::vector<oracle::Vector3>(whole.count()), handles(whole, probes));
      const std::size_t behind = scene.grid.at(15, 4, 3);
      EXPECT_GT(expected.state[behind][0], 0.1) << "the wave does not get around";
      EXPECT_LT(expected.state[behind][0], straight.state[behind][0] - 1.0) << "the wave needs no way around";
      expectConsistent(scene, simulation);

      // Also after the wave: a hole has no time.
      const auto timeAt = [&](const Index3& at)
      {
        std::vector<float> times(scene.grid.voxels());
        std::vector<int> fronts(scene.grid.voxels());
        simulation.propagationTimes(times.data());
        simulation.wavefronts(fronts.data());
        EXPECT_EQ(fronts[scene.grid.at(at[0], at[1], at[2])] > 0, times[scene.grid.at(at[0], at[1], at[2])] >= 0.0f);
        return times[scene.grid.at(at[0], at[1], at[2])];
      };
      EXPECT_EQ(timeAt({ 12, 4, 3 }), -1.0f);
      EXPECT_GT(timeAt({ 9, 4, 3 }), 0.0f);
      EXPECT_GT(simulation.carve(box({ -1.0, -5.0, -5.0 }, { 30.0, 40.0, 40.0 })), 1000u);
      EXPECT_EQ(timeAt({ 9, 4, 3 }), -1.0f);
    }
  }
}

// Deform, carve and continue: formula (P) on the remaining tissue, from its state on.
TEST(Carve, TheWaveGoesOnFromADeformedState)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 20, 18, 16 }, axes, 21, 0.05);
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      const Index3 handle = { 4, 9, 8 };
      scene.scalar[scene.grid.at(4, 9, 8)] = 1.0f;
      std::vector<Probe> probes{ probeAt(scene, handle, { 3.0, 2.0, -1.0 }) };
      simulation.pull(probes);
      expectWhatIsInside(scene, simulation, sphere({ 13.2, 9.1, 8.3 }, 3.9, 9, 12));
      const oracle::Block block = without(scene, simulation).block();
      const std::vector<oracle::Vector3> before = state(simulation);
      probes[0].displacement = { 6.0, 5.0, -4.0 };
      simulation.pull(probes);
      const auto expected = oracle::propagate(block, before, handles(block, probes));
      EXPECT_LT(largestDifference(block, state(simulation), expected.state), 1e-5);
      expectConsistent(scene, simulation);
    }
  }
}

TEST(Carve, RelaxationReachesTheOptimumAroundAHole)
{
  Scene scene = randomScene({ 12, 12, 12 }, 1, 31, 0.02, 0.05);
  scene.anchors.faces[0] = true;
  scene.give(10, 9, 6, 0.3f);
  scene.scalar[scene.grid.at(10, 9, 6)] = 1.0f;
  Simulation simulation = simulate(scene);
  const std::vector<Probe> probes{ probeAt(scene, { 10, 9, 6 }, { 2.0, 1.5, -1.8 }) };
  simulation.pull(probes);
  ASSERT_GT(simulation.carve(sphere({ 6.7, 6.1, 5.3 }, 2.9, 9, 12)), 50u);
  const oracle::Block block = without(scene, simulation).block();
  const std::vector<oracle::Vector3> pulled = state(simulation);
  std::vector<char> held = block.anchored;
  held[scene.grid.at(10, 9, 6)] = 1;
  const oracle::Optimum best = oracle::minimise(block, held, pulled);
  ASSERT_LT(best.gap(), 1e-5) << "the oracle has no proof";
  ASSERT_GT(oracle::energy(block, pulled), 1.05 * best.energy) << "nothing to relax: a poor test";
  simulation.relax(3000, 0.0);
  const double energy = oracle::energy(block, state(simulation));
  // The tolerances of TestRelaxation.
  EXPECT_LT(energy, 1.001 * best.energy);
  EXPECT_GT(energy, 0.9999 * best.bound);
  expectConsistent(scene, simulation);
}

TEST(Carve, ABoneWithAHoleThroughIsTwoBones)
{
  for (const int axes : { 1, 3 })
  {
    Scene scene({ 20, 10, 10 }, 0.3f, axes);
    for (int i = 3; i < 17; ++i)
    {
      scene.give(i, 5, 5, 0.0f);
    }
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      simulation.relax(1, 0.0); // clusters exist before the carve
      EXPECT_EQ(simulation.carve(box({ 8.5, 3.5, 3.5 }, { 10.5, 7.5, 7.5 })), 2u * 4u * 4u);
      expectConsistent(scene, simulation);
      simulation.pull({ probeAt(scene, { 4, 5, 5 }, { 0.0, 2.0, 0.0 }) });
      std::vector<float> u = displacements(simulation);
      for (int i = 3; i < 17; ++i)
      {
        EXPECT_EQ(u[3 * scene.grid.at(i, 5, 5) + 1] == 2.0f, i <= 8) << i;
      }
      simulation.relax(20, 0.0);
      u = displacements(simulation);
      for (int i = 11; i < 16; ++i)
      {
        EXPECT_EQ(u[3 * scene.grid.at(i, 5, 5) + 1], u[3 * scene.grid.at(i + 1, 5, 5) + 1]) << i;
      }
      expectConsistent(scene, simulation);
    }
  }
}

TEST(Carve, AProbeLetsGoOfWhatIsCarved)
{
  Scene scene({ 20, 16, 14 }, 0.3f);
  Simulation simulation = simulate(scene);
  const std::vector<Probe> probes{ probeAt(scene, { 6, 8, 7 }, { 2.0, 0.0, 0.0 }, 2.1),
    probeAt(scene, { 16, 8, 7 }, { 0.0, 1.0, 0.0 }, 1.1) };
  const std::size_t whole = simulation.pull(probes)[0].elements;
  ASSERT_EQ(whole, 33u);

  // The lower half of the first handle's tissue, which has moved two voxels.
  expectWhatIsInside(scene, simulation, box({ 5.4, 5.4, 4.4 }, { 10.6, 10.6, 6.6 }));
  auto results = simulation.probes();
  EXPECT_EQ(results[0].elements, 33u - 10u);
  EXPECT_EQ(results[0].reached, (Vector3{ 2.0, 0.0, 0.0 }));
  EXPECT_EQ(results[1].elements, 7u);
  EXPECT_EQ(results[1].reached, (Vector3{ 0.0, 1.0, 0.0 }));

  // Its remaining tissue keeps its place when the rest relaxes.
  simulation.relax(20, 0.0);
  EXPECT_EQ(simulation.probes()[0].reached, (Vector3{ 2.0, 0.0, 0.0 }));
  expectConsistent(scene, simulation);

  // All of the handle's tissue.
  simulation.carve(sphere({ 8.0, 8.0, 7.0 }, 2.9, 16, 16));
  results = simulation.probes();
  EXPECT_EQ(results[0].elements, 0u);
  EXPECT_EQ(results[0].reached, (Vector3{}));
  EXPECT_EQ(results[0].force, (Vector3{}));
  EXPECT_EQ(results[1].elements, 7u);
  simulation.relax(20, 0.0);
  expectConsistent(scene, simulation);
  simulation.reset();
  EXPECT_EQ(simulation.measure().displaced, 0u);
  expectConsistent(scene, simulation);
}

TEST(Carve, AProbeWithoutTissueOfItsOwn)
{
  Scene scene({ 20, 16, 14 }, 0.3f);
  Simulation simulation = simulate(scene);
  std::vector<Probe> probes{ probeAt(scene, { 6, 8, 7 }, { 2.0, 0.0, 0.0 }) };
  simulation.pull(probes);
  probes.push_back(probeAt(scene, { 8, 8, 7 }, {})); // the current place of the first probe's element
  auto results = simulation.pull(probes);
  ASSERT_EQ(results[1].elements, 0u);
  const Vector3 reached = results[1].reached;

  // Elsewhere, then both.
  EXPECT_GT(simulation.carve(sphere({ 15.2, 8.1, 7.3 }, 2.1, 9, 12)), 0u);
  results = simulation.probes();
  EXPECT_EQ(results[0].reached, (Vector3{ 2.0, 0.0, 0.0 }));
  EXPECT_EQ(results[1].reached, reached);
  EXPECT_GT(simulation.carve(sphere({ 8.2, 8.1, 7.3 }, 2.1, 9, 12)), 0u);
  results = simulation.probes();
  for (const ProbeResult& result : results)
  {
    EXPECT_EQ(result.elements, 0u);
    EXPECT_EQ(result.reached, (Vector3{}));
  }
}

// A carve first completes the wave. A refused carve or cut leaves it under way.
TEST(Carve, WhileAWaveIsUnderWay)
{
  for (const PropagationMethod method : { PropagationMethod::Envelope, PropagationMethod::Timestamp })
  {
    Scene scene = randomScene({ 26, 18, 16 }, 1, 71, 0.05);
    const std::vector<Probe> probes = compatibleProbes(scene, 2, 4.0, 72);
    const Surface ball = sphere({ 13.2, 9.1, 8.3 }, 4.2, 9, 12);
    Simulation whole = simulate(scene, { 4, 2, 2 }), simulation = simulate(scene, { 4, 2, 2 });
    whole.setPropagation(method, ConflictPolicy::Limit);
    whole.pull(probes);
    whole.carve(ball);

    simulation.setPropagation(method, ConflictPolicy::Limit);
    simulation.hold(probes);
    ASSERT_FALSE(simulation.propagate(1).finished);
    const std::vector<float> before = displacements(simulation);
    Surface broken = ball;
    broken.triangles.pop_back();
    messageOf<InputError>([&] { simulation.carve(broken); });
    broken.triangles.push_back({ 0, 1, 999999 });
    messageOf<InputError>([&] { simulation.cut(broken); });
    EXPECT_TRUE(sameBits(displacements(simulation), before));

    simulation.carve(ball);
    EXPECT_TRUE(simulation.propagate(0).finished);
    EXPECT_EQ(elements(simulation), elements(whole));
    EXPECT_TRUE(sameBits(displacements(simulation), displacements(whole)));
    expectConsistent(scene, simulation);
  }
}

TEST(Carve, CutsAndCarvesTogether)
{
  Scene scene = randomScene({ 20, 16, 14 }, 1, 41, 0.05);
  const Surface ball = sphere({ 9.2, 8.1, 7.3 }, 4.1, 9, 12);
  const Surface blade = sheet(-3.1, -2.7, 0.83, 30, 28, [](double x, double y) { return 7.3 + 0.2 * x - 0.1 * y; });
  std::vector<std::uint8_t> expected;
  for (const Index3& brick : brickSizes())
  {
    Simulation carved = simulate(scene, brick), cut = simulate(scene, brick);
    const std::size_t all = cut.cut(blade);
    carved.carve(ball);
    const std::size_t left = carved.cut(blade);
    EXPECT_LT(left, all) << "links of carved elements are gone already";
    cut.carve(ball);
    EXPECT_EQ(elements(carved), elements(cut));
    EXPECT_EQ(links(carved), links(cut));
    expectConsistent(scene, carved);
    expected = expected.empty() ? links(carved) : expected;
    EXPECT_EQ(links(carved), expected);

    const Scene rest = without(scene, carved);
    oracle::Block block = rest.block();
    takeLinks(block, expected);
    const std::vector<Probe> probes = compatibleProbes(rest, 1, 4.0, 43);
    carved.pull(probes);
    cut.pull(probes);
    EXPECT_TRUE(sameBits(displacements(carved), displacements(cut)));
    const auto wave = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes));
    EXPECT_LT(largestDifference(block, state(carved), wave.state), 1e-5);
  }
}

TEST(Carve, RestoringBringsEverythingBack)
{
  Scene scene = randomScene({ 22, 18, 16 }, 3, 51, 0.1);
  scene.anchors.faces[2] = true;
  const std::vector<Probe> probes = compatibleProbes(scene, 3, 3.0, 52);
  for (const Index3& brick : brickSizes())
  {
    Simulation untouched = simulate(scene, brick);
    untouched.pull(probes);
    const std::vector<float> pulled = displacements(untouched);
    untouched.relax(8, 0.0);

    Simulation simulation = simulate(scene, brick);
    simulation.carve(sphere({ 4.2, 4.1, 4.3 }, 3.1, 9, 12)); // before any brick has memory
    simulation.pull(probes);
    simulation.carve(sphere({ 11.2, 9.1, 8.3 }, 5.1, 9, 12));
    simulation.cut(planeAcrossX(13.4));
    simulation.relax(3, 0.0);
    simulation.reset();
    EXPECT_NE(elements(simulation), elements(untouched)) << "reset() leaves the hole";
    simulation.restoreTopology();
    EXPECT_EQ(elements(simulation), elements(untouched));
    EXPECT_EQ(links(simulation), links(untouched));
    EXPECT_EQ(clusters(simulation), clusters(untouched));
    simulation.pull(probes);
    EXPECT_TRUE(sameBits(displacements(simulation), pulled));
    simulation.relax(8, 0.0);
    EXPECT_TRUE(sameBits(displacements(simulation), displacements(untouched)));
    const double energy = untouched.measure().energy;
    EXPECT_NEAR(simulation.measure().energy, energy, 1e-6 * energy) << "summed in another order";
  }
}

TEST(Carve, SingleSlice)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    SCOPED_TRACE(axis);
    Index3 size{ 18, 18, 18 };
    size[axis] = 1;
    Scene scene(size, 0.25f);
    Simulation simulation = simulate(scene);
    Vector3 low{ 5.5, 5.5, 5.5 }, high{ 9.5, 11.5, 9.5 };
    low[axis] = -0.5;
    high[axis] = 0.5;
    std::size_t expected = 1;
    for (int a = 0; a < 3; ++a)
    {
      expected *= static_cast<std::size_t>(high[a] - low[a]);
    }
    EXPECT_EQ(simulation.carve(box(low, high)), expected);
    expectConsistent(scene, simulation);
    Index3 grabbed{ 3, 3, 3 };
    grabbed[axis] = 0;
    const std::vector<Probe> probes{ probeAt(scene, grabbed, { 2.0, 1.0, 3.0 }) };
    simulation.pull(probes);
    const oracle::Block block = without(scene, simulation).block();
    const auto wave = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes));
    EXPECT_LT(largestDifference(block, state(simulation), wave.state), 1e-5);
    // The slice is at its place along the axis: a solid next to it does not reach it.
    low[axis] = 10.0;
    high[axis] = 12.0;
    EXPECT_EQ(simulation.carve(box(low, high)), 0u);
  }
}

}
