// Cuts: which links they remove, against a simple test and by connected components, and their effect on the next pull.

#include "Blades.h"

#include <set>

namespace
{

using namespace chainmail;

/// Connected components after the engine's cuts.
std::vector<int> partsOf(const Scene& scene, const Simulation& simulation, int* number)
{
  oracle::Block block = scene.block();
  takeLinks(block, links(simulation));
  return oracle::parts(block, number);
}

/// The bits of links() agree for both ends, and there are none for air and beyond the grid.
void expectConsistentLinks(const Scene& scene, const std::vector<std::uint8_t>& bits)
{
  oracle::Block block = scene.block();
  takeLinks(block, bits);
  EXPECT_EQ(oracle::linkBits(block), bits);
}

/// The simple test and the engine with the same blade and state; links with a small margin are left out.
void expectNaiveLinks(const Scene& scene, Simulation& simulation, const Surface& blade)
{
  oracle::Block block = scene.block();
  takeLinks(block, links(simulation));
  const std::size_t linksBefore = oracle::links(block).size();
  oracle::Block naive = block;
  const auto margin = oracle::cut(naive, state(simulation), blade.points, blade.triangles);
  const std::size_t removed = simulation.cut(blade);
  const std::vector<std::uint8_t> bits = links(simulation);
  expectConsistentLinks(scene, bits);
  std::size_t unsure = 0, wrong = 0, gone = 0;
  for (const oracle::Link& link : oracle::links(block))
  {
    const bool cutByNaive = naive.cut[link.from] >> link.direction & 1;
    const bool cutByEngine = !(bits[link.from] >> (2 * link.direction + 1) & 1);
    gone += cutByEngine;
    // 1e-5 of a link or a triangle: decisions that rounding of displacements to float32 may reverse.
    if (margin[link.from][link.direction] < 1e-5)
    {
      ++unsure;
    }
    else
    {
      wrong += cutByNaive != cutByEngine;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(removed, gone);
  EXPECT_GT(gone, 0u);
  EXPECT_LT(unsure, linksBefore / 100 + 1) << "the blade is not in general position";
}

TEST(Cut, UncutLinksAreThoseBetweenElements)
{
  Scene scene = randomScene({ 13, 9, 7 }, 1, 1, 0.3);
  for (const Index3& brick : brickSizes())
  {
    EXPECT_EQ(links(simulate(scene, brick)), oracle::linkBits(scene.block()));
  }
}

TEST(Cut, GenericSurfacesCutWhatANaiveTestSays)
{
  Scene scene = randomScene({ 21, 18, 15 }, 1, 2, 0.1);
  scene.grid.spacing = { 0.9, 1.1, 1.7 };
  {
    Simulation simulation = simulate(scene);
    expectNaiveLinks(
      scene, simulation, { { { 3.1, -7.3, 2.2 }, { 17.4, 22.9, 9.1 }, { 9.2, 8.8, 31.7 } }, { { 0, 1, 2 } } });
  }
  {
    Simulation simulation = simulate(scene, { 4, 2, 2 });
    expectNaiveLinks(scene, simulation,
      sheet(-3.1, -2.7, 0.83, 30, 28,
        [](double x, double y) { return 11.3 + 4.1 * std::sin(0.5 * x + 0.1) * std::cos(0.6 * y); }));
  }
  {
    Simulation simulation = simulate(scene);
    const Surface ball = sphere({ 9.3, 8.1, 12.7 }, 6.13, 23, 31);
    expectNaiveLinks(scene, simulation, ball);
    EXPECT_EQ(simulation.cut(ball), 0u) << "a second time there is nothing left to remove";
    expectNaiveLinks(scene, simulation, sphere({ 12.1, 10.2, 9.4 }, 5.77, 19, 23));
  }
}

TEST(Cut, HappensAtTheCurrentDeformation)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 20, 16, 14 }, axes, 3, 0.05);
    scene.grid.spacing = { 1.0, 1.25, 0.75 };
    scene.anchors.faces[0] = true;
    Simulation simulation = simulate(scene, { 8, 4, 4 });
    simulation.pull(compatibleProbes(scene, 3, 3.0, 4));
    simulation.relax(5, 0.0);
    const Surface blade = sheet(-9.0, -8.5, 7.7, 6, 6, [](double x, double y) { return 4.03 + 0.31 * x - 0.17 * y; });
    // The deformation matters: the same blade cuts other links at rest.
    Simulation atRest = simulate(scene);
    atRest.cut(blade);
    expectNaiveLinks(scene, simulation, blade);
    EXPECT_NE(links(simulation), links(atRest));
    EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5) << "removing links keeps a state feasible";
  }
}

// --- Watertight

/// Exactly two components; voxels clearly on one side of z = height(x, y) belong to the same one.
template <typename F> void expectTwoSides(const Scene& scene, const Surface& blade, F&& height, const char* what)
{
  SCOPED_TRACE(what);
  Simulation simulation = simulate(scene);
  EXPECT_GT(simulation.cut(blade), 0u);
  expectConsistentLinks(scene, links(simulation));
  int number = 0;
  const std::vector<int> part = partsOf(scene, simulation, &number);
  EXPECT_EQ(number, 2);
  int side[2] = { -1, -1 }; // the components of the first voxel clearly below and of the first one clearly above
  int wrong = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const Vector3 p = scene.place(i, j, k);
      const double d = p[2] - height(p[0], p[1]);
      if (std::abs(d) > 1e-6)
      {
        const int here = part[scene.grid.at(i, j, k)];
        int& expected = side[d > 0];
        expected = expected < 0 ? here : expected;
        wrong += here != expected;
      }
    });
  EXPECT_NE(side[0], side[1]);
  EXPECT_EQ(wrong, 0);
}

TEST(Cut, APlaneExactlyThroughVoxelCentresHasNoHoles)
{
  Scene scene({ 12, 11, 10 });
  // Vertices near, on and between the columns; edges and diagonals through voxel centres.
  for (const double z : { 4.0, 4.5, 5.0 })
  {
    const auto flat = [z](double, double) { return z; };
    expectTwoSides(scene, sheet(-2.0, -2.0, 20.0, 1, 1, flat), flat, "two triangles");
    expectTwoSides(scene, sheet(-2.0, -2.0, 1.0, 15, 15, flat), flat, "vertices on every voxel");
    expectTwoSides(scene, sheet(-2.5, -2.5, 0.5, 32, 32, flat), flat, "vertices on and between");
  }
  // The same across x and y, exactly on voxels.
  for (int axis : { 0, 1 })
  {
    Surface blade = sheet(-2.0, -2.0, 1.0, 15, 15, [](double, double) { return 4.0; });
    for (Vector3& p : blade.points)
    {
      std::swap(p[axis], p[2]);
    }
    Simulation simulation = simulate(scene);
    simulation.cut(blade);
    int number = 0;
    partsOf(scene, simulation, &number);
    EXPECT_EQ(number, 2);
  }
  // Diagonal planes through voxel centres in two and three axes.
  const auto slope = [](double x, double) { return x - 1.0; };
  expectTwoSides(scene, sheet(-2.0, -2.0, 1.0, 15, 15, slope), slope, "diagonal");
  const auto corner = [](double x, double y) { return 12.0 - x - y; };
  expectTwoSides(scene, sheet(-2.0, -2.0, 1.0, 15, 15, corner), corner, "corner");
}

TEST(Cut, ASteppedSheetThroughVoxelCentresHasNoHoles)
{
  // Heights are multiples of half a voxel, at vertices on every column. So every column is cut exactly at a vertex, and
  // half of them exactly at a voxel.
  Scene scene({ 24, 22, 16 });
  const auto vertex = [](double x, double y)
  { return std::round(2.0 * (7.5 + 4.0 * std::sin(0.6 * x) * std::cos(0.45 * y))) / 2.0; };
  const Surface blade = sheet(-2.0, -2.0, 1.0, 28, 26, vertex);
  ASSERT_GT(blade.triangles.size(), 1000u);
  expectTwoSides(scene, blade, vertex, "on columns");
}

TEST(Cut, AWavySheetOfThousandsOfTrianglesHasNoHoles)
{
  Scene scene({ 40, 36, 30 });
  scene.grid.spacing = { 0.8, 1.0, 1.25 };
  const auto wave = [](double x, double y)
  { return 17.0 + 5.0 * std::sin(0.35 * x) + 3.0 * std::cos(0.5 * y + 0.2 * x); };
  const Surface blade = sheet(-1.3, -1.1, 0.437, 80, 90, wave);
  ASSERT_GT(blade.triangles.size(), 10000u);
  Simulation simulation = simulate(scene);
  simulation.cut(blade);
  int number = 0;
  const std::vector<int> part = partsOf(scene, simulation, &number);
  EXPECT_EQ(number, 2);
  int wrong = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      // The triangles are at most 0.03 from the wave they approximate.
      const Vector3 p = scene.place(i, j, k);
      const double d = p[2] - wave(p[0], p[1]);
      const int expected = part[scene.grid.at(0, 0, d > 0 ? 29 : 0)];
      wrong += std::abs(d) > 0.05 && part[scene.grid.at(i, j, k)] != expected;
    });
  EXPECT_EQ(wrong, 0);
}

TEST(Cut, ClosedSurfacesCutOutTheirInside)
{
  Scene scene({ 26, 26, 26 });
  struct Case
  {
    const char* name;
    Surface surface;
    std::function<double(const Vector3&)> outside; ///< > 0 outside, < 0 inside, about in voxels
  };
  const auto ball = [](Vector3 c, double r)
  {
    return [c, r](const Vector3& p)
    {
      return std::sqrt((p[0] - c[0]) * (p[0] - c[0]) + (p[1] - c[1]) * (p[1] - c[1]) + (p[2] - c[2]) * (p[2] - c[2])) -
             r;
    };
  };
  const auto cube = [](double low, double high)
  {
    return [low, high](const Vector3& p) {
      return std::max({ low - p[0], p[0] - high, low - p[1], p[1] - high, low - p[2], p[2] - high });
    };
  };
  const Case cases[] = {
    { "sphere, centre and poles on voxels", sphere({ 13, 13, 13 }, 8.0, 40, 64), ball({ 13, 13, 13 }, 8.0) },
    { "sphere through (3, 4, 0) voxels", sphere({ 12, 12, 12 }, 5.0, 36, 48), ball({ 12, 12, 12 }, 5.0) },
    { "sphere between voxels", sphere({ 12.5, 12.5, 12.5 }, 7.5, 30, 60), ball({ 12.5, 12.5, 12.5 }, 7.5) },
    { "box exactly on voxels", box({ 6, 6, 6 }, { 17, 17, 17 }), cube(6, 17) },
    { "box between voxels", box({ 6.5, 6.5, 6.5 }, { 17.5, 17.5, 17.5 }), cube(6.5, 17.5) },
  };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.name);
    Simulation simulation = simulate(scene);
    simulation.cut(c.surface);
    int number = 0;
    const std::vector<int> part = partsOf(scene, simulation, &number);
    EXPECT_EQ(number, 2);
    int wrong = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        // The triangles of the spheres are at most 0.06 from them. Voxels on the surface may be on either side.
        const double d = c.outside(scene.place(i, j, k));
        const int here = part[scene.grid.at(i, j, k)];
        wrong += (d > 0.06 && here != 0) || (d < -0.06 && here != 1);
      });
    EXPECT_EQ(wrong, 0);
  }
}

TEST(Cut, WatertightAtADeformation)
{
  Scene scene({ 24, 20, 18 }, 0.25f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 12, 10, 9 }, { 1.5, -1.0, 2.0 }) });
  simulation.cut(
    sheet(-5.0, -5.0, 0.5, 70, 64, [](double x, double y) { return 8.0 + 0.5 * std::round(std::sin(x + y)); }));
  int number = 0;
  partsOf(scene, simulation, &number);
  EXPECT_EQ(number, 2);
}

TEST(Cut, SurfacesThatCutNothing)
{
  Scene scene({ 8, 8, 8 });
  Simulation simulation = simulate(scene);
  const std::vector<std::uint8_t> whole = links(simulation);
  EXPECT_EQ(simulation.cut({}), 0u);
  EXPECT_EQ(simulation.cut(planeAcrossX(-0.5)), 0u);
  EXPECT_EQ(simulation.cut(planeAcrossX(7.5)), 0u);
  // Between two neighbouring rows of links, where it meets no link.
  EXPECT_EQ(simulation.cut({ { { 2.1, 2.2, 2.3 }, { 2.9, 2.3, 2.2 }, { 2.4, 2.8, 2.6 } }, { { 0, 1, 2 } } }), 0u);
  EXPECT_EQ(links(simulation), whole);
}

// --- What a cut does

// Fig. 7: the same pull before and after a cut.
TEST(Cut, Figure7OfThePaper)
{
  Scene scene({ 24, 16, 6 }, 0.2f);
  const oracle::Block whole = scene.block();
  const std::vector<Probe> probes{ probeAt(scene, { 4, 8, 3 }, { 4.0, -4.0, 2.5 }) };
  for (const bool through : { true, false })
  {
    Simulation simulation = simulate(scene);
    simulation.pull(probes);
    const std::vector<float> before = displacements(simulation);
    const std::size_t far = 3 * scene.grid.at(14, 8, 3);
    EXPECT_NEAR(before[far], 4.0 - 10 * 0.2, 1e-5);

    simulation.reset();
    Surface blade = planeAcrossX(9.5);
    if (!through)
    {
      blade.points = { { 9.5, 3.5, -9.0 }, { 9.5, 30.0, -9.0 }, { 9.5, 3.5, 9.0 }, { 9.5, 30.0, 9.0 } };
    }
    EXPECT_EQ(simulation.cut(blade), through ? 16u * 6u : 12u * 6u);
    simulation.pull(probes);
    const std::vector<float> after = displacements(simulation);
    oracle::Block block = whole;
    takeLinks(block, links(simulation));
    const auto expected = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes));
    EXPECT_LT(largestDifference(block, state(simulation), expected.state), 1e-5);
    if (through)
    {
      scene.each(
        [&](int i, int j, int k)
        {
          for (int a = 0; i > 9 && a < 3; ++a)
          {
            ASSERT_EQ(after[3 * scene.grid.at(i, j, k) + a], 0.0f) << "behind the cut";
          }
        });
      EXPECT_EQ(after[3 * scene.grid.at(9, 8, 3)], before[3 * scene.grid.at(9, 8, 3)]);
    }
    else
    {
      // The wave goes around: five rows down, ten across, five up.
      EXPECT_NEAR(after[far], 4.0 - 20 * 0.2, 1e-5);
      EXPECT_NEAR(after[3 * scene.grid.at(12, 3, 3)], 4.0 - 13 * 0.2, 1e-5);
    }
  }
}

TEST(Cut, BothSidesOfAnIncisionMoveApart)
{
  // Fig. 8: an incision from the top, both of its sides pulled at once.
  Scene scene({ 24, 14, 12 }, 0.3f);
  Simulation simulation = simulate(scene);
  Surface blade = planeAcrossX(11.5);
  for (Vector3& p : blade.points)
  {
    p[2] = p[2] > 0 ? p[2] : 5.5; // only the upper half
  }
  simulation.cut(blade);
  oracle::Block block = scene.block();
  takeLinks(block, links(simulation));
  const std::vector<Probe> probes{ probeAt(scene, { 11, 7, 11 }, { -1.5, 0.0, 0.0 }),
    probeAt(scene, { 12, 7, 11 }, { 1.5, 0.0, 0.0 }) };
  const auto results = simulation.pull(probes);
  // Together they request 3. The path around the incision's floor has 6 + 1 + 6 links of 0.3 = 3.9.
  EXPECT_EQ(results[0].reached[0], -1.5);
  EXPECT_EQ(results[1].reached[0], 1.5);
  const auto expected = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), handles(block, probes));
  EXPECT_LT(largestDifference(block, state(simulation), expected.state), 1e-5);
  simulation.relax(30, 0.0);
  EXPECT_LE(oracle::maxLinkExcess(block, state(simulation)), 1e-5);
}

TEST(Cut, ACutBoneIsTwoBones)
{
  Scene scene({ 20, 10, 10 }, 0.3f);
  for (int i = 3; i < 17; ++i)
  {
    scene.give(i, 5, 5, 0.0f);
  }
  scene.give(5, 8, 8, 0.0f); // a second rigid element
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    oracle::Block block = scene.block();
    EXPECT_EQ(clusters(simulation), oracle::clusters(block, 0));
    simulation.cut(planeAcrossX(9.5));
    takeLinks(block, links(simulation));
    EXPECT_EQ(clusters(simulation), oracle::clusters(block, 0));
    const std::vector<int> label = clusters(simulation);
    EXPECT_NE(label[scene.grid.at(9, 5, 5)], label[scene.grid.at(10, 5, 5)]);
    EXPECT_EQ(std::set<int>(label.begin(), label.end()), (std::set<int>{ -1, 0, 1, 2 }));

    simulation.pull({ probeAt(scene, { 4, 5, 5 }, { 0.0, 2.0, 0.0 }) });
    const std::vector<float> u = displacements(simulation);
    for (int i = 3; i < 17; ++i)
    {
      EXPECT_EQ(u[3 * scene.grid.at(i, 5, 5) + 1], i < 10 ? 2.0f : 0.0f) << i;
    }
    // Relaxation moves each half as one.
    simulation.relax(20, 0.0);
    const std::vector<float> v = displacements(simulation);
    for (int i = 3; i < 16; ++i)
    {
      if (i != 9)
      {
        EXPECT_EQ(v[3 * scene.grid.at(i, 5, 5)], v[3 * scene.grid.at(i + 1, 5, 5)]);
      }
    }
  }
}

TEST(Cut, ClustersOfRandomTissueOnEachAxis)
{
  for (int axes : { 1, 3 })
  {
    Scene scene = randomScene({ 19, 15, 11 }, axes, 90, 0.1, 0.35);
    if (axes == 3)
    {
      Random random(91);
      for (float& c : scene.constraint)
      {
        c = random(0, 1) < 0.3 ? 0.0f : c;
      }
    }
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      oracle::Block block = scene.block();
      for (int round = 0; round < 2; ++round)
      {
        const std::vector<int> label = clusters(simulation);
        for (int a = 0; a < axes; ++a)
        {
          const std::vector<int> expected = oracle::clusters(block, a);
          for (std::size_t v = 0; v < block.count(); ++v)
          {
            ASSERT_EQ(label[v * axes + a], expected[v]) << "axis " << a << ", voxel " << v << ", round " << round;
          }
        }
        simulation.cut(planeAcrossX(8.5));
        takeLinks(block, links(simulation));
      }
    }
  }
}

TEST(Cut, RestoringUndoesAllCuts)
{
  Scene scene({ 20, 10, 10 }, 0.3f);
  for (int i = 3; i < 17; ++i)
  {
    scene.give(i, 5, 5, 0.0f);
  }
  Simulation simulation = simulate(scene), fresh = simulate(scene);
  const std::vector<std::uint8_t> whole = links(simulation);
  simulation.cut(planeAcrossX(9.5));
  simulation.cut(sphere({ 6, 5, 5 }, 3.3, 9, 12));
  simulation.pull({ probeAt(scene, { 15, 5, 5 }, { 3.0, 0.0, 0.0 }) });
  simulation.reset();
  EXPECT_NE(links(simulation), whole) << "reset keeps cuts";
  simulation.restoreTopology();
  EXPECT_EQ(links(simulation), whole);
  EXPECT_EQ(clusters(simulation), clusters(fresh));
  const std::vector<Probe> probes{ probeAt(scene, { 15, 5, 5 }, { 1.0, 2.0, -0.5 }) };
  simulation.pull(probes);
  fresh.pull(probes);
  simulation.relax(10, 0.0);
  fresh.relax(10, 0.0);
  EXPECT_TRUE(sameBits(displacements(simulation), displacements(fresh)));
}

// Restoring the topology of tissue that was pulled apart must not leave links beyond their limits.
TEST(Cut, RestoringADeformedStateIsFeasible)
{
  Scene scene({ 16, 8, 8 }, 0.3f);
  Simulation simulation = simulate(scene);
  simulation.cut(planeAcrossX(7.5));
  simulation.pull({ probeAt(scene, { 12, 4, 4 }, { 5.0, 0.0, 0.0 }) });
  simulation.restoreTopology();
  EXPECT_LE(oracle::maxLinkExcess(scene.block(), state(simulation)), 1e-5);
  EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
}

TEST(Cut, OddTrianglesDoNoHarm)
{
  Scene scene({ 8, 8, 8 });
  Simulation simulation = simulate(scene);
  const std::vector<std::uint8_t> whole = links(simulation);
  // A triangle without area cuts nothing: a point, an edge twice.
  EXPECT_EQ(simulation.cut({ { { 3.5, 3.0, 3.0 }, { 3.5, 3.0, 3.0 }, { 3.5, 5.0, 3.0 } },
              { { 0, 1, 2 }, { 0, 0, 0 }, { 2, 1, 2 } } }),
    0u);
  EXPECT_EQ(links(simulation), whole);

  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : { nan, inf, -inf })
  {
    Surface surface = planeAcrossX(3.5);
    surface.points[2][1] = bad;
    const std::string message = messageOf<InputError>([&] { simulation.cut(surface); });
    EXPECT_TRUE(contains(message, "finite")) << message;
  }
  for (const int bad : { -1, 4 })
  {
    Surface surface = planeAcrossX(3.5);
    surface.triangles[1][2] = bad;
    const std::string message = messageOf<InputError>([&] { simulation.cut(surface); });
    EXPECT_FALSE(message.empty());
  }
  EXPECT_EQ(links(simulation), whole) << "a refused surface must cut nothing";
  EXPECT_EQ(simulation.cut(planeAcrossX(3.5)), 64u);
}

}
