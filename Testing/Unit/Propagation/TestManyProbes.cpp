// Hundreds and thousands of probes: compatible ones are one wave, and a few in conflict take a few more.

#include "Scene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

constexpr int side = 41;

/// A smooth displacement field that is 0 on the faces of the block.
Vector3 smoothField(const Index3& p)
{
  const double pi = std::acos(-1.0);
  const double bump =
    std::sin(pi * p[0] / (side - 1)) * std::sin(pi * p[1] / (side - 1)) * std::sin(pi * p[2] / (side - 1));
  return { 0.6 * bump, -0.5 * bump, 0.4 * bump };
}

/// A block with held faces and `count` probes inside, each on an element of its own.
struct Crowd
{
  Crowd(std::size_t count, std::uint64_t seed)
    : scene({ side, side, side })
  {
    Random random(seed);
    this->scene.anchors.faces.fill(true);
    this->scene.each([&](int i, int j, int k) { this->scene.give(i, j, k, static_cast<float>(random(0.1, 0.4))); });
    std::vector<char> taken(this->scene.grid.voxels(), 0);
    while (this->probes.size() < count)
    {
      const Index3 p{ 1 + random.below(side - 2), 1 + random.below(side - 2), 1 + random.below(side - 2) };
      char& here = taken[this->scene.grid.at(p[0], p[1], p[2])];
      if (!here)
      {
        here = 1;
        this->places.push_back(p);
        this->probes.push_back(probeAt(this->scene, p, smoothField(p)));
      }
    }
  }

  Scene scene;
  std::vector<Index3> places;
  std::vector<Probe> probes;
};

/// The number of waves since the start.
int waves(const Simulation& simulation)
{
  std::vector<int> fronts(simulation.model().grid().voxels());
  simulation.wavefronts(fronts.data());
  return *std::max_element(fronts.begin(), fronts.end());
}

/// Formula (P*) from rest, with the displacements that the probes reached.
void expectFormula(const Crowd& crowd, const std::vector<ProbeResult>& results, const std::vector<float>& u)
{
  const oracle::Block block = crowd.scene.block();
  for (int a = 0; a < 3; ++a)
  {
    std::vector<std::pair<std::size_t, double>> up, down;
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.anchored[v])
      {
        up.push_back({ v, 0.0 });
        down.push_back({ v, 0.0 });
      }
    }
    for (std::size_t n = 0; n < results.size(); ++n)
    {
      const Index3& p = crowd.places[n];
      up.push_back({ crowd.scene.grid.at(p[0], p[1], p[2]), results[n].reached[a] });
      down.push_back({ crowd.scene.grid.at(p[0], p[1], p[2]), -results[n].reached[a] });
    }
    const std::vector<double> upper = oracle::shortest(block, a, up);
    const std::vector<double> lower = oracle::shortest(block, a, down);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      ASSERT_NEAR(u[3 * v + a], std::min(std::max(0.0, -lower[v]), upper[v]), 1e-5) << "voxel " << v << " axis " << a;
    }
  }
}

void expectAllOf(const Probe& probe, const ProbeResult& result, std::size_t n)
{
  EXPECT_EQ(result.elements, 1u) << "probe " << n;
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_EQ(result.reached[a], static_cast<float>(probe.displacement[a])) << "probe " << n << " axis " << a;
  }
}

TEST(ManyProbes, FiveThousandThatFitTogetherAreOneWaveAndTheFormula)
{
  Crowd crowd(5000, 3100);
  Simulation simulation = simulate(crowd.scene);
  simulation.setPropagationTimes(true);
  const auto results = simulation.pull(crowd.probes);
  EXPECT_EQ(waves(simulation), 1);
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    expectAllOf(crowd.probes[n], results[n], n);
  }
  const std::vector<float> u = displacements(simulation);
  expectFormula(crowd, results, u);

  // The bits do not depend on the order of the probes.
  std::reverse(crowd.probes.begin(), crowd.probes.end());
  Simulation reversed = simulate(crowd.scene);
  reversed.pull(crowd.probes);
  EXPECT_TRUE(sameBits(displacements(reversed), u));
}

TEST(ManyProbes, DraggedThroughDeformedTissueTheyRemainOneWaveEach)
{
  Crowd crowd(2000, 3200);
  Simulation simulation = simulate(crowd.scene);
  simulation.setPropagationTimes(true);
  for (int step = 1; step <= 3; ++step)
  {
    for (std::size_t n = 0; n < crowd.probes.size(); ++n)
    {
      const Vector3 whole = smoothField(crowd.places[n]);
      for (int a = 0; a < 3; ++a)
      {
        crowd.probes[n].displacement[a] = whole[a] * step / 3.0;
      }
    }
    const auto results = simulation.pull(crowd.probes);
    EXPECT_EQ(waves(simulation), step);
    simulation.relax(2, 0.0);
    for (std::size_t n = 0; n < results.size(); ++n)
    {
      expectAllOf(crowd.probes[n], results[n], n);
    }
  }
  // Other probes continue from the current places of the tissue: each one grabs the element at its position.
  const std::vector<float> u = displacements(simulation);
  std::vector<Probe> others = crowd.probes;
  for (std::size_t n = 0; n < others.size(); ++n)
  {
    const Index3& p = crowd.places[n];
    for (int a = 0; a < 3; ++a)
    {
      others[n].position[a] += u[3 * crowd.scene.grid.at(p[0], p[1], p[2]) + a];
      others[n].displacement[a] = 0.0;
    }
  }
  const auto results = simulation.pull(others);
  EXPECT_TRUE(sameBits(displacements(simulation), u));
  EXPECT_TRUE(
    std::all_of(results.begin(), results.end(), [](const ProbeResult& result) { return result.elements == 1; }));
}

// Earlier probes have precedence over a probe in conflict with them; all others reach their targets. The number of
// waves grows with the depth of the conflict among the probes, not with their number.
TEST(ManyProbes, OneThatDoesNotFitCostsFewWaves)
{
  Crowd crowd(32, 3300);
  crowd.probes[20].displacement[1] += 7.0;
  Simulation simulation = simulate(crowd.scene);
  simulation.setPropagationTimes(true);
  const auto results = simulation.pull(crowd.probes);
  EXPECT_LE(waves(simulation), 6); // bisection: 2^5 parts
  EXPECT_GT(waves(simulation), 1);
  EXPECT_LT(results[20].reached[1], crowd.probes[20].displacement[1] - 1.0);
  EXPECT_GT(results[20].reached[1], crowd.probes[20].displacement[1] - 7.0);
  expectFormula(crowd, results, displacements(simulation));
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    if (n != 20)
    {
      expectAllOf(crowd.probes[n], results[n], n);
    }
  }
}

// More probes in conflict share, in one wave: only the conflicting ones, and only on that axis.
TEST(ManyProbes, OneOfAThousandThatDoesNotFitSharesWithThoseAround)
{
  Crowd crowd(1000, 3300);
  // The probe in the middle, far from the faces, which would limit it.
  const auto fromMiddle = [&](std::size_t n)
  {
    const Index3& p = crowd.places[n];
    return std::abs(p[0] - side / 2) + std::abs(p[1] - side / 2) + std::abs(p[2] - side / 2);
  };
  std::size_t odd = 0;
  for (std::size_t n = 1; n < crowd.places.size(); ++n)
  {
    odd = fromMiddle(n) < fromMiddle(odd) ? n : odd;
  }
  crowd.probes[odd].displacement[1] += 4.0;
  Simulation simulation = simulate(crowd.scene);
  simulation.setPropagationTimes(true);
  simulation.hold(crowd.probes);
  const PropagateResult found = simulation.propagate(0);
  const auto results = simulation.probes();
  EXPECT_EQ(waves(simulation), 1);
  EXPECT_GT(found.shared, 1u);
  EXPECT_LT(found.shared, 500u);
  expectFormula(crowd, results, displacements(simulation));
  std::size_t others = 0;
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    for (int a : { 0, 2 })
    {
      EXPECT_EQ(results[n].reached[a], static_cast<float>(crowd.probes[n].displacement[a])) << "probe " << n;
    }
    const double more = results[n].reached[1] - crowd.probes[n].displacement[1];
    others += more != 0.0 && n != odd ? 1 : 0;
    EXPECT_TRUE(n == odd ? more < -1.0 : more > -1e-5) << "probe " << n << " by " << more;
  }
  EXPECT_GE(others, found.shared - 1);
}

// The forces of all handles are computed together. A single handle without contact to others has the same force.
TEST(ManyProbes, ForcesAreThoseOfSingleProbes)
{
  Scene scene = randomScene({ 24, 20, 18 }, 1, 3400, 0.1, 0.3);
  const oracle::Block block = scene.block();
  std::vector<Probe> probes = compatibleProbes(scene, 12, 1.0, 3401, 1.5);
  Simulation simulation = simulate(scene);
  simulation.pull(probes);
  simulation.relax(5, 0.0);
  const auto results = simulation.probes();
  const auto u = state(simulation);
  const std::vector<int> bones = oracle::clusters(block, 0);
  const auto handle = handles(block, probes);
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    std::vector<char> together(block.count(), 0);
    for (const std::size_t held : handle[n].elements)
    {
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        together[v] = together[v] || v == held || (bones[held] >= 0 && bones[v] == bones[held]);
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      double force = 0.0;
      double scale = 1.0;
      for (const oracle::Link& link : oracle::links(block))
      {
        if (together[link.from] != together[link.to])
        {
          const std::size_t in = together[link.from] ? link.from : link.to;
          const std::size_t out = together[link.from] ? link.to : link.from;
          const double term = 2.0 * (u[in][a] - u[out][a]) / (oracle::limit(block, link, a) + 1e-6);
          force += term;
          scale += std::abs(term);
        }
      }
      EXPECT_NEAR(results[n].force[a], force, 1e-4 * scale) << "probe " << n << " axis " << a;
    }
  }
}

}
