// Extreme inputs: which properties still hold, and how well.
// Each test prints its measurements as "NUMERICS: name | figure"; Testing/Numerics.md lists them.

#include "Blades.h"
#include "Figures.h"
#include "Picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

namespace
{

using namespace chainmail;
using Values = std::vector<oracle::Vector3>;

class Stopwatch
{
public:
  double seconds() const
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - this->start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Pulls from rest. Returns the largest distance from formula (P*), in fractions of the spacing.
double pullAgainstFormula(Simulation& simulation, const oracle::Block& block, const std::vector<Probe>& probes)
{
  simulation.pull(probes);
  const auto expected = oracle::propagate(block, Values(block.count()), handles(block, probes));
  return largestDifference(block, state(simulation), expected.state);
}

/// Relaxes sweep by sweep: the energy must fall, and links must keep within their limits. Returns the largest excess.
double relaxAndWatch(Simulation& simulation, const oracle::Block& block, int sweeps, double unit)
{
  double before = oracle::energy(block, state(simulation)), excess = 0.0;
  for (int sweep = 0; sweep < sweeps; ++sweep)
  {
    simulation.relax(1, 0.0);
    const Values now = state(simulation);
    const double energy = oracle::energy(block, now);
    // Displacements are rounded by at most `unit`, which changes each link's energy.
    EXPECT_LE(energy, before * (1.0 + 1e-6) + unit * unit * 1e6) << "sweep " << sweep;
    before = energy;
    excess = std::max(excess, oracle::maxLinkExcess(block, now));
  }
  return excess;
}

// Constraints of 9e-7 and 0.9 next to each other: nearly rigid lumps and a rod in tissue of the softest kind.
TEST(Extremes, StiffnessOfOneToAMillion)
{
  Scene scene({ 15, 13, 12 }, 0.9f);
  Random random(1000);
  scene.each(
    [&](int i, int j, int k)
    {
      if (random(0.0, 1.0) < 0.2 || (i > 3 && i < 12 && j == 6 && k == 6))
      {
        scene.give(i, j, k, 9e-7f);
      }
    });
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  const std::vector<Probe> probes{ probeAt(scene, { 13, 3, 3 }, { 2.2, -1.9, 1.6 }),
    probeAt(scene, { 12, 10, 9 }, { -0.9, 1.1, 1.3 }) };
  expectAtMost(
    "stiffness 1 : 1e6, propagation against Dijkstra", pullAgainstFormula(simulation, block, probes), 1e-5, "spacings");
  expectAtMost(
    "stiffness 1 : 1e6, link excess over 100 sweeps", relaxAndWatch(simulation, block, 100, 1.2e-7), 1e-5, "spacings");
  const double few = oracle::energy(block, state(simulation));
  EXPECT_GT(few, 50.0) << "hardly anything is strained: a poor test";
  simulation.relax(5000, 0.0);
  const Values relaxed = state(simulation);
  std::vector<char> held = block.anchored;
  for (const oracle::Handle& handle : handles(block, probes))
  {
    for (const std::size_t v : handle.elements)
    {
      held[v] = 1;
    }
  }
  const oracle::Optimum best = oracle::minimise(block, held, relaxed, 1e-4);
  const double energy = oracle::energy(block, relaxed);
  EXPECT_GT(energy, 0.9999 * best.bound);
  record("stiffness 1 : 1e6, gap of the oracle's proof", best.gap(), "");
  record("stiffness 1 : 1e6, energy over the optimum after 100 sweeps", few / best.energy, "");
  // This is not a good result. Nearly rigid lumps hold each other in place, like rigid elements that do not move as
  // one. Such tissue should be made rigid. After 100 sweeps the energy is 1.36 times the optimum, in the end 1.28
  // times. Above 1.32 the other 5000 sweeps would change almost nothing. Below 1.2 the solution would be better than
  // Numerics.md says.
  expectAtMost("stiffness 1 : 1e6, energy over the optimum after 5100 sweeps", energy / best.energy, 1.32);
  EXPECT_GT(energy / best.energy, 1.2);
  Simulation coarse = simulate(scene);
  coarse.setCoarseToFine(true);
  coarse.pull(probes);
  coarse.relax(100, 0.0);
  // Coarser grids move lumps as a whole, which leaves a third of that.
  expectAtMost("stiffness 1 : 1e6, energy over the optimum after 100 sweeps from coarser grids",
    oracle::energy(block, state(coarse)) / best.energy, 1.15);
  EXPECT_GT(oracle::energy(block, state(coarse)) / best.energy, 1.05);
  struct Ratio
  {
    float stiff;
    const char* name;
    double allowed; ///< ratio of the energy to the optimum, which the oracle knows to 1e-4
  };
  // Stiffer lumps move more slowly, up to a single body: measured 1.02, 1.00 and 1.00.
  for (const Ratio& ratio : { Ratio{ 9e-5f, "stiffness 1 : 1e4", 1.04 }, Ratio{ 9e-3f, "stiffness 1 : 100", 1.005 },
         Ratio{ 0.0f, "rigid", 1.001 } })
  {
    Scene other = scene;
    for (float& c : other.constraint)
    {
      c = c < 0.1f ? ratio.stiff : c;
    }
    const oracle::Block otherBlock = other.block();
    Simulation settled = simulate(other);
    settled.pull(probes);
    const oracle::Optimum optimum = oracle::minimise(otherBlock, held, state(settled), 1e-4);
    settled.relax(5100, 0.0);
    const double energyOfOther = oracle::energy(otherBlock, state(settled));
    expectAtMost(std::string(ratio.name) + ", energy over the optimum after 5100 sweeps",
      energyOfOther / optimum.energy, ratio.allowed);
    EXPECT_GT(energyOfOther, 0.9999 * optimum.bound);
  }
}

// A pull of 1e-6 of the spacing, in tissue so stiff that it propagates.
TEST(Extremes, DisplacementOfAMillionthOfTheSpacing)
{
  Scene scene({ 24, 9, 8 }, 1e-7f);
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  const std::vector<Probe> probes{ probeAt(scene, { 20, 4, 4 }, { 1e-6, -1e-6, 1e-6 }) };
  expectAtMost("displacement 1e-6 spacings, propagation against Dijkstra, of the displacement",
    pullAgainstFormula(simulation, block, probes) / 1e-6, 1e-6);
  EXPECT_GT(simulation.measure().displaced, 500u);
  double excess = 0.0, before = oracle::energy(block, state(simulation));
  for (int sweep = 0; sweep < 50; ++sweep)
  {
    simulation.relax(1, 0.0);
    const double energy = oracle::energy(block, state(simulation));
    EXPECT_LE(energy, before * (1.0 + 1e-6));
    before = energy;
    excess = std::max(excess, oracle::maxLinkExcess(block, state(simulation)));
  }
  expectAtMost("displacement 1e-6 spacings, link excess, of the displacement", excess / 1e-6, 1e-6);
}

TEST(Extremes, DisplacementOfAThousandSpacings)
{
  Scene scene = randomScene({ 17, 14, 13 }, 1, 1010, 0.05, 0.1);
  const oracle::Block block = scene.block();
  Random random(1011);
  Simulation simulation = simulate(scene);
  const Index3 p = randomElement(scene, random);
  const std::vector<Probe> probes{ probeAt(scene, p, { 1e3, -1e3, 1e3 }) };
  expectAtMost("displacement 1e3 spacings, propagation against Dijkstra", pullAgainstFormula(simulation, block, probes),
    1e-3, "spacings"); // a unit in the last place is 6e-5; paths have about fifteen links
  expectAtMost("displacement 1e3 spacings, link excess over 100 sweeps", relaxAndWatch(simulation, block, 100, 6.2e-5),
    2e-4, "spacings");
}

TEST(Extremes, SpacingsFromAThousandthToAMillion)
{
  const Scene one = randomScene({ 15, 13, 11 }, 1, 1020, 0.1, 0.05);
  const std::vector<Probe> probes = compatibleProbes(one, 3, 2.0, 1021);
  Simulation reference = simulate(one);
  reference.pull(probes);
  reference.relax(30, 0.0);
  const Values expected = state(reference);
  for (const Vector3& spacing :
    { Vector3{ 1e-3, 1e-3, 1e-3 }, Vector3{ 1e6, 1e6, 1e6 }, Vector3{ 0.1, 1.0, 10.0 }, Vector3{ 1e-3, 1.0, 1e6 } })
  {
    Scene scene = one;
    scene.grid.spacing = spacing;
    std::vector<Probe> scaled = probes;
    for (Probe& probe : scaled)
    {
      for (int a = 0; a < 3; ++a)
      {
        probe.position[a] *= spacing[a];
        probe.displacement[a] *= spacing[a];
      }
    }
    Simulation simulation = simulate(scene);
    const double formula = pullAgainstFormula(simulation, scene.block(), scaled);
    simulation.relax(30, 0.0);
    char name[96];
    std::snprintf(name, sizeof name, "spacing %g x %g x %g, ", spacing[0], spacing[1], spacing[2]);
    expectAtMost(std::string(name) + "propagation against Dijkstra", formula, 1e-5, "spacings");
    // Displacement / spacing may round differently by a unit in the last place. 30 sweeps propagate the difference.
    expectAtMost(std::string(name) + "relaxed against spacing 1",
      largestDifference(scene.block(), state(simulation), expected), 1e-5, "spacings");
    std::size_t offsets = 0, wrong = 0;
    simulation.resample({ 0, 0, 0 }, visitEach(
                                       [&](const Index3&, const float* offset)
                                       {
                                         for (int a = 0; a < 3; ++a)
                                         {
                                           ++offsets;
                                           wrong += std::abs(offset[a]) > 20.0f;
                                         }
                                       }));
    EXPECT_GT(offsets, 0u);
    EXPECT_EQ(wrong, 0u);
  }
}

TEST(Extremes, NothingGives)
{
  Scene scene({ 40, 33, 27 }, 0.0f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 39, 0, 13 }, { 123.456, -0.001, 7.0 }) });
  for (const int sweeps : { 0, 50 })
  {
    simulation.relax(sweeps, 0.0);
    const std::vector<float> u = displacements(simulation);
    std::size_t wrong = 0;
    for (std::size_t v = 0; v < u.size(); v += 3)
    {
      wrong += u[v] != 123.456f || u[v + 1] != -0.001f || u[v + 2] != 7.0f;
    }
    expectAtMost(
      "constraint 0 everywhere, elements that do not move exactly along, " + std::to_string(sweeps) + " sweeps",
      static_cast<double>(wrong), 0.0);
  }
  const std::vector<int> label = clusters(simulation);
  EXPECT_EQ(*std::min_element(label.begin(), label.end()), 0);
  EXPECT_EQ(*std::max_element(label.begin(), label.end()), 0);

  // Held at one end and pulled at the other, rigid tissue does not move at all.
  scene.anchors.faces[0] = true;
  Simulation held = simulate(scene);
  const auto results = held.pull({ probeAt(scene, { 39, 0, 13 }, { 123.456, -0.001, 7.0 }) });
  EXPECT_EQ(results[0].reached, (Vector3{ 0.0, 0.0, 0.0 }));
  EXPECT_EQ(held.measure().displaced, 0u);
}

TEST(Extremes, EverythingGives)
{
  Scene scene({ 21, 18, 15 }, 0.99f);
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  expectAtMost("constraint 0.99 everywhere, propagation against Dijkstra",
    pullAgainstFormula(simulation, block, { probeAt(scene, { 17, 9, 7 }, { 9.0, -11.0, 12.0 }) }), 1e-5, "spacings");
  expectAtMost("constraint 0.99 everywhere, link excess over 60 sweeps", relaxAndWatch(simulation, block, 60, 1.2e-6),
    1e-5, "spacings");
}

// --- Sizes

TEST(Extremes, ASheetOf512Squared)
{
  Scene scene = randomScene({ 512, 512, 1 }, 1, 1030, 0.05, 0.02);
  scene.scalar[scene.grid.at(255, 256, 0)] = 1.0f;
  scene.give(255, 256, 0, 0.3f);
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  const Stopwatch watch;
  expectAtMost("512 x 512 x 1, propagation against Dijkstra",
    pullAgainstFormula(simulation, block, { probeAt(scene, { 255, 256, 0 }, { 40.0, -35.0, 20.0 }) }), 1e-4,
    "spacings"); // paths of about 200 links, each rounded to at most 4e-6
  EXPECT_GT(simulation.measure().displaced, 30000u);
  const double before = oracle::energy(block, state(simulation));
  simulation.relax(40, 1e-3);
  const Values relaxed = state(simulation);
  EXPECT_LT(oracle::energy(block, relaxed), before);
  expectAtMost("512 x 512 x 1, link excess after 40 sweeps", oracle::maxLinkExcess(block, relaxed), 1e-5, "spacings");
  record("512 x 512 x 1, whole test", watch.seconds(), "s");
}

TEST(Extremes, AChainOf512)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    Index3 size{ 1, 1, 1 }, held{ 0, 0, 0 };
    size[axis] = 512;
    held[axis] = 511;
    Scene scene(size, 0.3f);
    scene.anchors.faces[2 * axis] = true;
    const oracle::Block block = scene.block();
    Simulation simulation = simulate(scene);
    const std::string name = std::string("chain of 512 along ") + "xyz"[axis];
    expectAtMost(name + ", propagation against Dijkstra",
      pullAgainstFormula(simulation, block, { probeAt(scene, held, { 70.0, -100.0, 153.0 }) }), 2e-3,
      "spacings"); // 511 sums of the same limit near 100, each with an error of up to 4e-6, mostly of the same sign
    simulation.relax(40, 0.0);
    expectAtMost(
      name + ", link excess after 40 sweeps", oracle::maxLinkExcess(block, state(simulation)), 3e-5, "spacings");
  }
}

TEST(Extremes, SixteenMillionElements)
{
  // Homogeneous, so distances have a closed form: links along the three axes.
  const int n = 256;
  Grid grid;
  grid.size = { n, n, n };
  const std::vector<std::uint8_t> tissue(grid.voxels(), 1);
  ArrayView view;
  view.data = tissue.data();
  view.type = ArrayView::Type::UInt8;
  Material material;
  material.constraint = [](double) { return 0.25; };
  Anchors anchors;
  anchors.faces.fill(false);
  Settings settings;
  settings.device = testDevice();
  Simulation simulation(std::make_shared<Model>(grid, view, material, anchors), settings);
  Probe probe;
  probe.position = { 100.0, 140.0, 120.0 };
  probe.displacement = { 120.0, -100.0, 60.0 };
  const Stopwatch pull;
  simulation.pull({ probe });
  record("256^3 elements, pull that reaches all", pull.seconds(), "s");
  const Statistics statistics = simulation.measure();
  EXPECT_EQ(statistics.displaced, grid.voxels());
  record("256^3 elements, device memory",
    static_cast<double>(statistics.deviceBytes) / static_cast<double>(grid.voxels()), "bytes an element");
  // Every value is a multiple of 1/4 below 2^24 / 4, so all sums are exact.
  std::vector<float> u(3 * grid.voxels());
  simulation.displacements(u.data());
  std::size_t wrong = 0;
  for (std::size_t v = 0; v < grid.voxels(); ++v)
  {
    const Index3 p = grid.indexOf(v);
    const double d = 0.25 * (std::abs(p[0] - 100) + std::abs(p[1] - 140) + std::abs(p[2] - 120));
    for (int a = 0; a < 3; ++a)
    {
      const double t = probe.displacement[a];
      const double expected = t > 0.0 ? std::max(0.0, t - d) : std::min(0.0, t + d);
      wrong += u[3 * v + a] != expected;
    }
  }
  expectAtMost("256^3 elements, values that are not exact", static_cast<double>(wrong), 0.0);
  u = std::vector<float>();
  const Stopwatch relax;
  simulation.relax(2, 0.0);
  record("256^3 elements, a sweep", relax.seconds() / 2.0, "s");
  const Statistics relaxed = simulation.measure();
  EXPECT_LT(relaxed.energy, statistics.energy);
  expectAtMost("256^3 elements, link excess after 2 sweeps", relaxed.maxLinkExcess, 3e-5, "spacings");
}

TEST(Extremes, ASingleElement)
{
  Scene scene({ 1, 1, 1 }, 0.3f);
  Simulation simulation = simulate(scene);
  EXPECT_EQ(simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 1e3, -1e-6, 0.25 }, 5.0) })[0].elements, 1u);
  EXPECT_EQ(displacements(simulation), (std::vector<float>{ 1e3f, -1e-6f, 0.25f }));
  const RelaxResult result = simulation.relax(10, 1e-3);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(displacements(simulation), (std::vector<float>{ 1e3f, -1e-6f, 0.25f }));
  const Statistics statistics = simulation.measure();
  EXPECT_EQ(statistics.energy, 0.0);
  EXPECT_EQ(statistics.maxLinkExcess, 0.0);
  EXPECT_EQ(statistics.displaced, 1u);
  EXPECT_EQ(simulation.probes()[0].force, (Vector3{ 0.0, 0.0, 0.0 }));
  EXPECT_EQ(simulation.cut(planeAcrossX(1000.5)), 0u);
  EXPECT_EQ(links(simulation), (std::vector<std::uint8_t>{ 0 }));
  resample(simulation, { 2, 2, 2 });
  EXPECT_EQ(simulation.carve(box({ 999.0, -1.0, -1.0 }, { 1001.0, 1.0, 1.0 })), 1u);
  EXPECT_EQ(displacements(simulation), (std::vector<float>{ 0.0f, 0.0f, 0.0f }));
  simulation.relax(3, 0.0);
  resample(simulation, { 2, 2, 2 });
  simulation.restoreTopology();
  EXPECT_EQ(simulation.pull({ probeAt(scene, { 0, 0, 0 }, { 1.0, 2.0, 3.0 }) })[0].reached, (Vector3{ 1.0, 2.0, 3.0 }));
}

// --- Numbers

TEST(Extremes, AThousandProbes)
{
  Scene scene = randomScene({ 40, 34, 22 }, 1, 1040, 0.1, 0.0);
  for (float& c : scene.constraint)
  {
    c = std::max(c, 0.05f);
  }
  const oracle::Block block = scene.block();
  // Targets from a field whose strain is below all limits of 0.05.
  const auto field = [](const Index3& p, int a)
  { return 0.9 * std::sin(0.03 * p[0] + a) + 0.7 * std::cos(0.025 * p[1] - a) + 0.02 * p[2]; };
  Random random(1041);
  std::vector<Probe> probes;
  std::vector<char> taken(scene.grid.voxels(), 0);
  while (probes.size() < 1000)
  {
    const Index3 p = randomElement(scene, random);
    char& mark = taken[scene.grid.at(p[0], p[1], p[2])];
    if (!mark)
    {
      mark = 1;
      probes.push_back(probeAt(scene, p, { field(p, 0), field(p, 1), field(p, 2) }));
    }
  }
  Simulation simulation = simulate(scene);
  const Stopwatch watch;
  const auto results = simulation.pull(probes);
  record("1000 compatible probes, pull", watch.seconds(), "s");
  std::size_t wrong = 0;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      wrong += results[n].reached[a] != static_cast<float>(probes[n].displacement[a]);
    }
  }
  expectAtMost("1000 compatible probes, places not reached exactly", static_cast<double>(wrong), 0.0);
  // All probes at once: formula (P*) with each probe as a source.
  double worst = 0.0;
  const Values got = state(simulation);
  for (int a = 0; a < 3; ++a)
  {
    std::vector<std::pair<std::size_t, double>> up, down;
    for (std::size_t n = 0; n < probes.size(); ++n)
    {
      const std::size_t v = oracle::grab(block, probes[n].position, 0.0)[0];
      up.push_back({ v, probes[n].displacement[a] });
      down.push_back({ v, -probes[n].displacement[a] });
    }
    const std::vector<double> high = oracle::shortest(block, a, up), low = oracle::shortest(block, a, down);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.tissue[v])
      {
        worst = std::max(worst, std::abs(got[v][a] - std::min(std::max(0.0, -low[v]), high[v])));
      }
    }
  }
  expectAtMost("1000 compatible probes, propagation against Dijkstra", worst, 1e-5, "spacings");
  simulation.relax(20, 0.0);
  expectAtMost("1000 compatible probes, link excess after 20 sweeps", oracle::maxLinkExcess(block, state(simulation)),
    1e-5, "spacings");

  // All probes in conflict, one after the other.
  for (Probe& probe : probes)
  {
    probe.displacement = { random(-9.0, 9.0), random(-9.0, 9.0), random(-9.0, 9.0) };
  }
  Simulation against = simulate(scene);
  const Stopwatch pulls;
  against.pull(probes);
  record("1000 contradicting probes, pull", pulls.seconds(), "s");
  expectAtMost(
    "1000 contradicting probes, link excess", oracle::maxLinkExcess(block, state(against)), 2e-5, "spacings");
}

TEST(Extremes, TwoHundredCuts)
{
  Scene scene({ 26, 25, 24 }, 0.3f);
  scene.anchors.faces[0] = true;
  Random random(1050);
  Simulation simulation = simulate(scene);
  oracle::Block naive = scene.block();
  std::size_t removed = 0, unsure = 0;
  const Values rest(naive.count());
  const Stopwatch watch;
  for (int n = 0; n < 200; ++n)
  {
    Surface blade;
    for (int p = 0; p < 4; ++p)
    {
      blade.points.push_back({ random(-4.0, 30.0), random(-4.0, 30.0), random(-4.0, 30.0) });
    }
    blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
    removed += simulation.cut(blade);
    for (const Vector3& margin : oracle::cut(naive, rest, blade.points, blade.triangles))
    {
      unsure += std::min({ margin[0], margin[1], margin[2] }) < 1e-3; // places are rounded to 1/4096 of a voxel
    }
  }
  record("200 cuts, all", watch.seconds(), "s");
  const std::vector<std::uint8_t> bits = links(simulation);
  oracle::Block block = scene.block();
  const std::size_t whole = oracle::links(block).size();
  takeLinks(block, bits);
  EXPECT_EQ(oracle::linkBits(block), bits);
  EXPECT_EQ(whole - oracle::links(block).size(), removed);
  std::size_t different = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    different += block.cut[v] != naive.cut[v];
  }
  record("200 cuts, share of links removed", static_cast<double>(removed) / static_cast<double>(whole), "");
  expectAtMost("200 cuts, elements with other links than a naive test finds", static_cast<double>(different),
    static_cast<double>(unsure));
  int parts = 0;
  oracle::parts(block, &parts);
  record("200 cuts, parts left", parts, "");
  const std::vector<Probe> probes{ probeAt(scene, { 22, 12, 12 }, { 2.0, 3.0, -1.0 }, 2.5) };
  expectAtMost(
    "200 cuts, propagation against Dijkstra", pullAgainstFormula(simulation, block, probes), 1e-5, "spacings");
  expectAtMost("200 cuts, link excess over 20 sweeps", relaxAndWatch(simulation, block, 20, 1.2e-6), 1e-5, "spacings");
}

// --- Long use

/// The memory of this process; 0 on systems without /proc.
std::size_t residentBytes()
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
  {
    if (line.compare(0, 6, "VmRSS:") == 0)
    {
      return 1024 * std::stoull(line.substr(6));
    }
  }
  return 0;
}

TEST(Extremes, ManyUpdates)
{
  constexpr int updates = CHAINMAIL_LONG ? 100000 : 3000;
  Scene scene({ 12, 9, 8 }, 0.3f);
  for (int i = 3; i < 8; ++i)
  {
    scene.give(i, 4, 4, 0.0f);
  }
  scene.anchors.faces[0] = true;
  const oracle::Block block = scene.block();
  Simulation simulation = simulate(scene);
  Probe probe = probeAt(scene, { 10, 4, 4 }, {});
  std::size_t bytes = 0, resident = 0;
  double excess = 0.0;
  const Stopwatch watch;
  for (int n = 1; n <= updates; ++n)
  {
    // A closed path that never repeats a place, up to the limits of the tissue and back.
    const double t = 0.37 * n;
    probe.displacement = { 1.2 * std::sin(t), 1.9 * std::sin(0.71 * t + 1.0), 1.4 * std::cos(0.53 * t) };
    simulation.hold({ probe });
    simulation.propagate();
    simulation.relax(1, 1e-3);
    if (n % (updates / 10) == 0)
    {
      excess = std::max(excess, oracle::maxLinkExcess(block, state(simulation)));
    }
    if (n == updates / 10)
    {
      bytes = simulation.measure().deviceBytes;
      resident = residentBytes();
    }
  }
  record("many updates, an update", 1e3 * watch.seconds() / updates, "ms");
  expectAtMost("many updates, link excess", excess, 1e-5, "spacings");
  EXPECT_EQ(simulation.measure().deviceBytes, bytes);
  const double growth = static_cast<double>(residentBytes()) - static_cast<double>(resident);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  (void)growth; // not known on such systems
#else
  expectAtMost("many updates, growth of the process after the first tenth", std::max(0.0, growth / 1e6), 8.0, "MB");
#endif
  EXPECT_EQ(simulation.probes()[0].elements, 1u);

  // The optimum is unique, so the relaxed state does not depend on the path.
  simulation.relax(5000, 1e-6);
  Simulation fresh = simulate(scene);
  fresh.pull({ probe });
  fresh.relax(5000, 1e-6);
  expectAtMost("many updates, drift from a fresh simulation when settled",
    largestDifference(block, state(simulation), state(fresh)), 1e-4, "spacings");
  simulation.reset();
  for (const float u : displacements(simulation))
  {
    ASSERT_EQ(u, 0.0f);
  }
}

// --- Folding

/// Signed volume of the parallelepiped of an element's links to its three lower neighbours.
double volumeAt(const Scene& scene, const Values& u, int i, int j, int k)
{
  const auto along = [&](int a)
  {
    const oracle::Vector3& here = u[scene.grid.at(i, j, k)];
    const oracle::Vector3& there = u[scene.grid.at(i - (a == 0), j - (a == 1), k - (a == 2))];
    oracle::Vector3 edge{ here[0] - there[0], here[1] - there[1], here[2] - there[2] };
    edge[a] += 1.0;
    return edge;
  };
  return oracle::dot(oracle::cross(along(0), along(1)), along(2));
}

// Above a constraint of 1/3 cells may invert. With all faces held the map is continuous, so tissue covers every voxel
// at least once. Nothing may be vacated, and every voxel must show tissue that is there. Which of several places it
// shows depends on neither bricks nor runs.
TEST(Extremes, FoldedTissueIsWholeAndTheSameEveryTime)
{
  Scene scene({ 20, 18, 16 }, 0.95f);
  scene.anchors.faces.fill(true);
  // The probes are compatible: for probes in conflict the last bit depends on bricks.
  const std::vector<Probe> probes = compatibleProbes(scene, 5, 5.0, 1060, 1.2);
  std::vector<float> first;
  for (int run = 0; run < 4; ++run)
  {
    Simulation simulation = simulate(scene, brickSizes()[run % 3]);
    simulation.pull(probes);
    simulation.relax(5, 0.0);
    const Values u = state(simulation);
    const Picture picture = resample(simulation);
    if (run > 0)
    {
      EXPECT_TRUE(sameBits(picture.offset, first)) << "run " << run; // none is NaN, see below
      continue;
    }
    first = picture.offset;
    std::size_t folded = 0, holes = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        folded += i > 0 && j > 0 && k > 0 && volumeAt(scene, u, i, j, k) < 0.0;
        holes += picture.vacated(i, j, k);
      });
    record("folded tissue, cells turned inside out", static_cast<double>(folded), "");
    EXPECT_GE(folded, 10u) << "nothing folds: a poor test";
    expectAtMost("folded tissue, voxels without material", static_cast<double>(holes), 0.0);
    double worst = 0.0;
    scene.each(
      [&](int i, int j, int k)
      {
        const Vector3 o = picture(i, j, k);
        const double x[3] = { i + o[0], j + o[1], k + o[2] };
        int low[3];
        double t[3];
        for (int a = 0; a < 3; ++a)
        {
          low[a] = std::min(std::max(static_cast<int>(std::floor(x[a])), 0), scene.grid.size[a] - 2);
          t[a] = x[a] - low[a];
          worst = std::max({ worst, -t[a], t[a] - 1.0 });
        }
        for (int a = 0; a < 3; ++a)
        {
          double moved = x[a];
          for (int n = 0; n < 8; ++n)
          {
            const double w = (n & 1 ? t[0] : 1 - t[0]) * (n & 2 ? t[1] : 1 - t[1]) * (n & 4 ? t[2] : 1 - t[2]);
            moved += w * u[scene.grid.at(low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2))][a];
          }
          worst = std::max(worst, std::abs(moved - (a == 0 ? i : a == 1 ? j : k)));
        }
      });
    // Near a face of a cell the local coordinates may have an error of 1e-4, and displacements differ by up to 0.95 of
    // that on each axis.
    expectAtMost("folded tissue, how far the material shown is from its voxel", worst, 1e-3, "voxels");
  }
}

}
