// What limits a probe: Simulation::limiter().

#include "Scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{

using namespace chainmail;
using What = Limiter::What;

TEST(Limiter, TheFaceOnTheSideThatHolds)
{
  Scene bar({ 12, 3, 3 }, 0.25f);
  bar.grid.spacing = { 2.0, 1.0, 1.0 };
  bar.anchors.faces[0] = bar.anchors.faces[1] = true;
  Simulation simulation = simulate(bar);
  for (const double sign : { 1.0, -1.0 })
  {
    // Nearer to x-: in both directions this face limits it, to three links.
    auto results = simulation.pull({ probeAt(bar, { 3, 1, 1 }, { 44.0 * sign, 0.0, 0.1 }) });
    EXPECT_NEAR(results[0].reached[0], sign * 1.5, 1e-4);
    EXPECT_EQ(simulation.limiter(0).what, What::Face);
    EXPECT_EQ(simulation.limiter(0).face, 0);
    EXPECT_FALSE(simulation.limiter(0).bone);
    simulation.relax(10, 0.0);
    EXPECT_EQ(simulation.limiter(0).face, 0) << "relaxed tissue is as tight there";
    simulation.pull({ probeAt(bar, { 9, 1, 1 }, { 44.0 * sign, 0.0, 0.1 }) });
    EXPECT_EQ(simulation.limiter(0).what, What::Face);
    EXPECT_EQ(simulation.limiter(0).face, 1);
    simulation.reset();
  }
  // Less than the tissue allows: nothing limits it.
  simulation.pull({ probeAt(bar, { 3, 1, 1 }, { 1.4, 0.0, 0.1 }) });
  EXPECT_EQ(simulation.limiter(0).what, What::Nothing);
}

TEST(Limiter, AnchoredBoneAndTheFaceThatABoneTouches)
{
  Scene bar({ 12, 3, 3 }, 0.25f);
  for (int i = 0; i < 3; ++i)
  {
    bar.give(i, 1, 1, 0.0f);
  }
  bar.anchors.rigid = true;
  {
    Simulation simulation = simulate(bar);
    simulation.pull({ probeAt(bar, { 6, 1, 1 }, { 0.0, 30.0, 0.0 }) });
    EXPECT_EQ(simulation.limiter(0).what, What::Rigid);
    EXPECT_FALSE(simulation.limiter(0).bone);
  }
  bar.anchors.rigid = false;
  bar.anchors.faces[0] = true;
  Simulation simulation = simulate(bar);
  const Probe tissue = probeAt(bar, { 6, 1, 1 }, { 0.0, 30.0, 0.0 });
  simulation.pull({ tissue });
  EXPECT_EQ(simulation.limiter(0).what, What::Face);
  EXPECT_FALSE(simulation.limiter(0).bone);
  simulation.pull({ tissue, probeAt(bar, { 2, 1, 1 }, { 5.0, 0.0, 0.0 }) });
  EXPECT_EQ(simulation.probes()[1].reached, Vector3{});
  EXPECT_EQ(simulation.limiter(1).what, What::Face);
  EXPECT_EQ(simulation.limiter(1).face, 0);
  EXPECT_TRUE(simulation.limiter(1).bone) << "the bone that it grips is anchored";
}

TEST(Limiter, AnotherProbe)
{
  Scene bar({ 12, 3, 3 }, 0.25f);
  for (int i = 8; i < 12; ++i)
  {
    bar.give(i, 1, 1, 0.0f);
  }
  Probe anchor = probeAt(bar, { 1, 1, 1 }, {});
  anchor.anchor = true;
  Simulation simulation = simulate(bar);
  simulation.pull({ probeAt(bar, { 4, 1, 1 }, { 3.0, 0.0, 0.0 }), probeAt(bar, { 11, 1, 1 }, { 0.0, 0.0, 3.0 }), anchor,
    probeAt(bar, { 8, 1, 1 }, { 0.0, 9.0, 0.0 }), probeAt(bar, { 4, 1, 1 }, { 7.0, 0.0, 0.0 }) });
  EXPECT_EQ(simulation.limiter(0).what, What::Probe);
  EXPECT_EQ(simulation.limiter(0).probe, 2u) << "the anchor came later, but it moves for nobody";
  EXPECT_EQ(simulation.limiter(2).what, What::Nothing) << "an anchor is where it is to be";
  EXPECT_EQ(simulation.limiter(3).what, What::Probe);
  EXPECT_EQ(simulation.limiter(3).probe, 1u);
  EXPECT_TRUE(simulation.limiter(3).bone) << "both grip one bone";
  EXPECT_EQ(simulation.limiter(4).what, What::Nothing) << "it holds no tissue of its own";
  EXPECT_THROW(simulation.limiter(5), InputError);
}

TEST(Limiter, UnderLatestTheProbeThatDragsItAlong)
{
  const Scene bar({ 20, 1, 1 }, 0.25f);
  Simulation simulation = simulate(bar);
  simulation.setPropagation(PropagationMethod::Envelope, ConflictPolicy::Latest);
  const std::vector<Probe> probes{ probeAt(bar, { 5, 0, 0 }, { 3.0, 0.0, 0.0 }),
    probeAt(bar, { 9, 0, 0 }, { -3.0, 0.0, 0.0 }) };
  simulation.pull(probes);
  EXPECT_NEAR(simulation.probes()[0].reached[0], -2.0, 1e-4);
  EXPECT_EQ(simulation.limiter(0).what, What::Probe);
  EXPECT_EQ(simulation.limiter(0).probe, 1u);
  EXPECT_EQ(simulation.limiter(1).what, What::Nothing);
}

TEST(Limiter, NothingWhileAWaveIsUnderWay)
{
  Scene bar({ 200, 2, 2 }, 0.25f);
  bar.anchors.faces[0] = true;
  Simulation simulation = simulate(bar, { 4, 2, 2 });
  simulation.hold({ probeAt(bar, { 199, 0, 0 }, { 60.0, 0.0, 0.0 }) });
  EXPECT_EQ(simulation.limiter(0).what, What::Nothing);
  ASSERT_FALSE(simulation.propagate(2).finished);
  EXPECT_EQ(simulation.limiter(0).what, What::Nothing);
  simulation.propagate();
  EXPECT_EQ(simulation.limiter(0).what, What::Face);
}

TEST(Limiter, WhereACutEndsWhatHeld)
{
  Scene bar({ 12, 3, 3 }, 0.25f);
  bar.anchors.faces[0] = bar.anchors.faces[1] = true;
  Simulation simulation = simulate(bar);
  const Probe probe = probeAt(bar, { 3, 1, 1 }, { 30.0, 0.0, 0.0 });
  Surface blade;
  blade.points = { { 1.5, -9.0, -9.0 }, { 1.5, 30.0, -9.0 }, { 1.5, -9.0, 30.0 } };
  blade.triangles = { { 0, 1, 2 } };
  EXPECT_EQ(simulation.cut(blade), 9u);
  simulation.pull({ probe });
  EXPECT_EQ(simulation.limiter(0).what, What::Face);
  EXPECT_EQ(simulation.limiter(0).face, 1);
}

TEST(Limiter, OfAReducedModelTheFaceOfTheWholeOne)
{
  Scene block({ 24, 13, 13 }, 0.25f);
  block.anchors.faces[3] = true;
  Settings settings;
  settings.device = testDevice();
  settings.modelReduction = 2;
  Simulation simulation(block.model(), settings);
  simulation.pull({ probeAt(block, { 12, 6, 6 }, { 0.0, -50.0, 0.0 }, 1.5) });
  EXPECT_EQ(simulation.limiter(0).what, What::Face);
  EXPECT_EQ(simulation.limiter(0).face, 3);
}

/// The room that the named holder leaves a probe on an axis, by Dijkstra's algorithm: the minimum over the holder's
/// elements s of sign * u(s) + d(h, s) - sign * u(h). It is 0 for an active constraint.
double roomTo(const oracle::Block& block, const std::vector<oracle::Vector3>& u, const std::vector<std::size_t>& handle,
  const std::vector<std::size_t>& holder, int axis, double sign)
{
  std::vector<std::pair<std::size_t, double>> sources;
  for (const std::size_t v : holder)
  {
    sources.push_back({ v, sign * u[v][axis] });
  }
  const std::vector<double> bound = oracle::shortest(block, axis, sources);
  double room = std::numeric_limits<double>::infinity();
  for (const std::size_t v : handle)
  {
    room = std::min(room, bound[v] - sign * u[v][axis]);
  }
  return room;
}

// In random tissue: a named holder leaves no room, and where none is named there is room.
TEST(Limiter, InRandomTissueItBinds)
{
  int named[4] = {};
  for (std::uint64_t seed = 0; seed < 10; ++seed)
  {
    SCOPED_TRACE(seed);
    const int axes = seed % 2 == 0 ? 1 : 3;
    Scene scene = randomScene({ 17, 14, 13 }, axes, 3500 + seed, 0.1, 0.08);
    scene.grid.spacing = { 0.7, 1.3, 2.1 };
    scene.anchors.faces[seed % 6] = scene.anchors.faces[(seed + 3) % 6] = true;
    scene.anchors.rigid = seed % 5 == 0;
    const oracle::Block block = scene.block();
    Random random(3600 + seed);
    std::vector<Probe> probes;
    for (int n = 0; n < 8; ++n)
    {
      const double reach = n % 2 == 0 ? 9.0 : 0.3;
      probes.push_back(probeAt(scene, randomElement(scene, random),
        { random(-reach, reach), random(-reach, reach), random(-reach, reach) }, n % 3 == 0 ? 1.6 : 0.0));
    }
    probes[2].anchor = true;
    Simulation simulation = simulate(scene);
    const auto handle = handles(block, [&] { // anchors grab first
      std::vector<Probe> anchorsFirst = probes;
      std::rotate(anchorsFirst.begin(), anchorsFirst.begin() + 2, anchorsFirst.begin() + 3);
      return anchorsFirst;
    }());
    const auto handleOf = [&](std::size_t n) { return handle[n == 2 ? 0 : n < 2 ? n + 1 : n].elements; };
    const auto results = simulation.pull(probes);
    simulation.relax(seed % 3 == 0 ? 4 : 0, 0.0);
    const auto u = state(simulation);
    for (std::size_t n = 0; n < probes.size(); ++n)
    {
      SCOPED_TRACE("probe " + std::to_string(n));
      const Limiter limiter = simulation.limiter(n);
      ++named[static_cast<int>(limiter.what)];
      if (probes[n].anchor || handleOf(n).empty())
      {
        EXPECT_EQ(limiter.what, What::Nothing);
        continue;
      }
      int axis = 0;
      double lack = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        const double here = probes[n].displacement[a] - results[n].reached[a];
        axis = std::abs(here) > std::abs(lack) ? a : axis;
        lack = std::abs(here) > std::abs(lack) ? here : lack;
      }
      const double sign = lack > 0.0 ? 1.0 : -1.0;
      std::vector<std::size_t> holder;
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        const Index3 p = block.index(v);
        bool onFace = false;
        for (int face = 0; face < 6; ++face)
        {
          onFace = onFace || (scene.anchors.faces[face] && (limiter.what != What::Face || limiter.face == face) &&
                               p[face / 2] == (face % 2 == 0 ? 0 : block.size[face / 2] - 1));
        }
        if (block.anchored[v] && (limiter.what == What::Nothing || (limiter.what == What::Face && onFace) ||
                                   (limiter.what == What::Rigid && !onFace)))
        {
          holder.push_back(v);
        }
      }
      for (std::size_t m = 0; m < probes.size(); ++m)
      {
        if (m != n && (limiter.what == What::Nothing || (limiter.what == What::Probe && limiter.probe == m)))
        {
          const auto elements = handleOf(m);
          holder.insert(holder.end(), elements.begin(), elements.end());
        }
      }
      const double room = roomTo(block, u, handleOf(n), holder, axis, sign);
      if (limiter.what == What::Nothing)
      {
        EXPECT_LE(std::abs(lack), 1e-4) << "it got less than it asked for";
      }
      else
      {
        EXPECT_GT(std::abs(lack), 0.0);
        EXPECT_NEAR(room, 0.0, 1e-2); // a handle that is held on both sides has a little room
      }
    }
  }
  for (const int times : named)
  {
    EXPECT_GT(times, 0) << "each answer has to be given";
  }
}

}
