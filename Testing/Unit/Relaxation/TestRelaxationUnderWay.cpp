// Relaxation while a wave is under way: which elements may relax, and to which displacements, against a simple run of
// the published rule in double precision.

#include "../../Oracles/Timestamps.h"
#include "Inclusion.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

/// Whether an element may relax: it is not active and has the wave id of all its linked neighbours.
std::vector<char> mayRelax(const oracle::Block& block, const std::vector<oracle::TimestampWaves::Element>& elements)
{
  std::vector<char> result(block.count());
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    result[v] = block.tissue[v] && !elements[v].active;
  }
  for (const oracle::Link& link : oracle::links(block))
  {
    if (elements[link.from].front != elements[link.to].front)
    {
      result[link.from] = result[link.to] = 0;
    }
  }
  return result;
}

/// Weighted mean of the neighbours, and the intersection of their boxes.
struct Around
{
  double mean = 0.0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool any = false;
};

Around around(const std::vector<oracle::Neighbour>& neighbours, const std::vector<oracle::Vector3>& u, int axis)
{
  Around result;
  double weight = 0.0;
  for (const oracle::Neighbour& n : neighbours)
  {
    const double x = u[n.voxel][axis];
    weight += 1.0 / (n.limit + 1e-6);
    result.mean += x / (n.limit + 1e-6);
    result.lower = std::max(result.lower, x - n.limit);
    result.upper = std::min(result.upper, x + n.limit);
  }
  result.any = weight > 0.0;
  result.mean /= weight;
  return result;
}

std::vector<oracle::Vector3> places(const oracle::TimestampWaves& waves)
{
  std::vector<oracle::Vector3> u;
  for (const auto& element : waves.state)
  {
    u.push_back(element.u);
  }
  return u;
}

void setPlaces(oracle::TimestampWaves& waves, const std::vector<oracle::Vector3>& u)
{
  for (std::size_t v = 0; v < u.size(); ++v)
  {
    waves.state[v].u = u[v];
  }
}

constexpr Vector3 pull{ 0.8, -0.6, 0.7 }; // shares of the largest displacement

/// A wave from one element, in the engine and in the oracle.
struct Pair
{
  Scene scene;
  oracle::Block block;
  Simulation simulation;
  oracle::TimestampWaves waves;

  Pair(const Scene& tissue, RelaxationMethod method, const Index3& brick)
    : scene(tissue)
    , block(this->scene.block())
    , simulation(simulate(this->scene, brick))
    , waves(this->block)
  {
    this->simulation.setPropagation(PropagationMethod::Timestamp, ConflictPolicy::Limit);
    this->simulation.setRelaxation(method, 1.0);
    const Probe probe = pullBy(this->scene, pull);
    const std::size_t grabbed = handles(this->block, { probe })[0].elements[0];
    this->simulation.hold({ probe });
    this->waves.held[grabbed] = 1;
    this->waves.start(grabbed, probe.displacement, 1);
  }

  /// One iteration of the wave in the engine and in the oracle.
  bool propagate()
  {
    const PropagateResult result = this->simulation.propagate(1);
    EXPECT_EQ(result.iterations, 1);
    this->waves.iterate();
    if (!result.finished) // the end of the wave also repairs the tissue that the relaxation disturbed
    {
      EXPECT_LT(largestDifference(this->block, state(this->simulation), places(this->waves)), 1e-5);
    }
    return result.finished;
  }
};

/// Constraints with exact sums: engine and oracle find the same earliest arrival.
Scene tissue(std::uint64_t seed, double rigidShare)
{
  const int n = 12;
  Scene scene = randomScene({ n, n, n }, 1, seed, 0.05, rigidShare);
  for (float& c : scene.constraint)
  {
    c = std::round(c * 128.0f) / 128.0f;
  }
  scene.scalar[scene.grid.at(n - 2, n - 3, n / 2)] = 1.0f;
  scene.anchors.faces[0] = true;
  return scene;
}

TEST(RelaxUnderWay, PublishedMethodStepByStep)
{
  for (const Index3& brick : brickSizes())
  {
    Pair pair(tissue(300, 0.0), RelaxationMethod::Paper, brick);
    std::vector<char> held = pair.waves.held;
    int steps = 0;
    std::size_t relaxed = 0;
    while (!pair.propagate() && steps < 40)
    {
      ++steps;
      const std::vector<char> may = mayRelax(pair.block, pair.waves.state);
      const std::vector<oracle::Vector3> before = places(pair.waves);
      std::vector<oracle::Vector3> after = before;
      for (int axis = 0; axis < 3; ++axis)
      {
        const auto graph = oracle::graph(pair.block, axis);
        for (std::size_t v = 0; v < pair.block.count(); ++v)
        {
          const Around near = around(graph[v], before, axis);
          if (may[v] && !held[v] && near.any)
          {
            after[v][axis] = near.mean;
            relaxed += near.mean != before[v][axis];
          }
        }
      }
      setPlaces(pair.waves, after);
      EXPECT_EQ(pair.simulation.relax(1, 0.0).iterations, 1);
      ASSERT_LT(largestDifference(pair.block, state(pair.simulation), after), 1e-5) << "step " << steps;
    }
    EXPECT_GT(steps, 8);
    EXPECT_GT(relaxed, 300u) << "hardly anything could relax: a poor test";
  }
}

// The first sweep after some iterations of the wave: red, then black elements, without bone.
TEST(RelaxUnderWay, FirstProjectedSweep)
{
  for (const int iterations : { 1, 4, 7, 10 })
  {
    Pair pair(tissue(301, 0.03), RelaxationMethod::Projected, { 8, 4, 8 });
    for (int n = 0; n < iterations; ++n)
    {
      ASSERT_FALSE(pair.propagate());
    }
    const std::vector<char> may = mayRelax(pair.block, pair.waves.state);
    std::vector<oracle::Vector3> u = places(pair.waves);
    std::size_t relaxed = 0;
    for (const int colour : { 0, 1 })
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        const auto graph = oracle::graph(pair.block, axis);
        for (std::size_t v = 0; v < pair.block.count(); ++v)
        {
          const oracle::Index3 p = pair.block.index(v);
          const Around near = around(graph[v], u, axis);
          if ((p[0] + p[1] + p[2]) % 2 == colour && may[v] && !pair.waves.held[v] && near.any &&
              pair.block.give[v][axis] > 0.0 && near.lower <= near.upper)
          {
            const double place = std::min(std::max(near.mean, near.lower), near.upper);
            relaxed += place != u[v][axis];
            u[v][axis] = place;
          }
        }
      }
    }
    const RelaxResult result = pair.simulation.relax(1, 0.0);
    EXPECT_EQ(result.iterations, 1);
    EXPECT_FALSE(result.converged);
    EXPECT_LT(largestDifference(pair.block, state(pair.simulation), u), 1e-5) << "after " << iterations;
    if (iterations > 4)
    {
      EXPECT_GT(relaxed, 50u) << "hardly anything could relax: a poor test";
    }
  }
}

// Frame by frame, as in interactive use. In the end the wave has arrived, the state is feasible, and the tissue is
// where it is after a relaxation that waits for the end of the wave.
TEST(RelaxUnderWay, EndsWhereWaitingEnds)
{
  Pair pair(tissue(302, 0.03), RelaxationMethod::Projected, { 8, 4, 8 });
  int frames = 0;
  while (!pair.simulation.propagate(2).finished)
  {
    ++frames;
    pair.simulation.relax(3, 0.0);
  }
  EXPECT_GT(frames, 3);
  EXPECT_LE(oracle::maxLinkExcess(pair.block, state(pair.simulation)), 1e-5);
  pair.simulation.relax(2000, 0.0);
  EXPECT_LE(oracle::maxLinkExcess(pair.block, state(pair.simulation)), 1e-5);

  Simulation waited = simulate(pair.scene);
  waited.pull({ pullBy(pair.scene, pull) });
  waited.relax(2000, 0.0);
  EXPECT_NEAR(pair.simulation.measure().energy, waited.measure().energy, 1e-3 * waited.measure().energy);
}

}
