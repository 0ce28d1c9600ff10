// The methods that the engine is compared with do what was published: before they are timed, they are held against
// closed forms and plain runs in double precision.

#include "../Oracles/Optimiser.h"
#include "../Oracles/Propagation.h"
#include "../Oracles/Timestamps.h"
#include "Baselines/DenseSweep.h"
#include "Baselines/MassSpring.h"
#include "Baselines/OverRelaxation.h"
#include "Baselines/PublishedChainMail.h"
#include "Baselines/SerialChainMail.h"
#include "Blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace
{

using baseline::PublishedChainMail;
using Launch = PublishedChainMail::Launch;
using Index3 = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// A path of float32 additions, as long as these blocks allow.
constexpr double rounding = 2e-5;

std::string device()
{
  const char* name = std::getenv("CHAINMAIL_TEST_DEVICE");
  return name ? name : "";
}

oracle::Block oracleOf(const bench::Block& block)
{
  oracle::Block result(block.grid.size);
  for (std::size_t v = 0; v < result.count(); ++v)
  {
    result.give[v].fill(block.constraint(v));
  }
  return result;
}

/// Formula (P): where a pull from rest takes every element.
std::vector<oracle::Vector3> expected(const bench::Block& block, std::size_t element, const Vector3& displacement)
{
  const oracle::Block plain = oracleOf(block);
  const std::vector<double> d = oracle::shortest(plain, 0, { { element, 0.0 } });
  std::vector<oracle::Vector3> u(plain.count());
  for (std::size_t v = 0; v < u.size(); ++v)
  {
    for (int a = 0; a < 3; ++a)
    {
      u[v][a] = std::min(std::max(0.0, displacement[a] - d[v]), displacement[a] + d[v]);
    }
  }
  return u;
}

double largestDifference(const baseline::State& state, const std::vector<oracle::Vector3>& expected)
{
  double worst = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    for (std::size_t v = 0; v < expected.size(); ++v)
    {
      const double d = std::fabs(state[a][v] - expected[v][a]);
      worst = d <= worst ? worst : d; // takes a NaN as well
    }
  }
  return worst;
}

std::size_t moved(const std::vector<oracle::Vector3>& u)
{
  return std::count_if(u.begin(), u.end(), [](const oracle::Vector3& v) { return v != oracle::Vector3{}; });
}

/// Every way to launch, in blocks that the grid is no multiple of.
std::vector<PublishedChainMail::Method> methods(bool timestamps)
{
  return { { Launch::Whole, timestamps, { 16, 4, 4 } }, { Launch::PerBlock, timestamps, { 4, 4, 4 } },
    { Launch::PerBlock, timestamps, { 16, 16, 8 } }, { Launch::Listed, timestamps, { 8, 4, 2 } },
    { Launch::Listed, timestamps, { 32, 4, 16 } } };
}

constexpr Index3 size{ 21, 18, 13 };
constexpr Vector3 displacement{ 1.9, -1.4, 0.6 };

TEST(Baselines, FirstMovedFirstIsRightWhereTissueIsHomogeneous)
{
  const bench::Block block(size, 0.25);
  const std::size_t element = block.grid.at(8, 5, 11);
  baseline::SerialChainMail serial(size, block.constraints());
  const auto u = expected(block, element, displacement);
  for (int again = 0; again < 2; ++again)
  {
    serial.reset();
    EXPECT_EQ(serial.pullFirstMovedFirst(element, displacement), moved(u));
    EXPECT_LT(largestDifference(serial.state(), u), rounding);
  }
  ASSERT_GT(moved(u), 400u);
  ASSERT_LT(moved(u), block.material.size());
}

TEST(Baselines, LargestViolationFirstIsRightWhereTissueIsNot)
{
  bench::Block block = bench::heterogeneousBlock(size, 3);
  bench::addRods(block);
  const std::size_t element = block.grid.at(8, 5, 11);
  const auto u = expected(block, element, displacement);
  baseline::SerialChainMail serial(size, block.constraints());
  EXPECT_EQ(serial.pullLargestViolationFirst(element, displacement), moved(u));
  EXPECT_LT(largestDifference(serial.state(), u), rounding);
  // The other order is not: that is why there are two.
  serial.reset();
  serial.pullFirstMovedFirst(element, displacement);
  EXPECT_GT(largestDifference(serial.state(), u), 0.1);
}

TEST(Baselines, PublishedPropagationIsRightWhereTissueIsHomogeneous)
{
  const bench::Block block(size, 0.25);
  const std::size_t element = block.grid.at(8, 5, 11);
  const auto u = expected(block, element, displacement);
  for (const bool timestamps : { false, true })
  {
    for (const PublishedChainMail::Method& method : methods(timestamps))
    {
      PublishedChainMail published(device(), size, block.constraints(), method);
      published.pull(element, displacement);
      // One link an iteration, and one in which nothing moves any more.
      EXPECT_EQ(published.propagate(), static_cast<int>(std::ceil(1.9 / 0.25)));
      EXPECT_LT(largestDifference(published.state(), u), rounding);
    }
  }
}

TEST(Baselines, TimestampsEqualAPlainRunWhereTissueIsHeterogeneous)
{
  const bench::Block block = bench::heterogeneousBlock(size, 4);
  const oracle::Block plain = oracleOf(block);
  const std::size_t first = block.grid.at(8, 5, 11);
  const std::size_t second = block.grid.at(14, 12, 3);
  oracle::TimestampWaves waves(plain);
  const auto run = [&](std::size_t element, const Vector3& to, int front)
  {
    waves.start(element, to, front);
    waves.held[element] = 1;
    for (; !waves.finished(); waves.iterate())
    {
    }
    std::vector<oracle::Vector3> u;
    for (const auto& e : waves.state)
    {
      u.push_back(e.u);
    }
    return u;
  };
  const auto afterFirst = run(first, displacement, 1);
  const auto afterSecond = run(second, { -1.0, 1.5, 0.5 }, 2);
  for (const PublishedChainMail::Method& method : methods(true))
  {
    PublishedChainMail published(device(), size, block.constraints(), method);
    published.pull(first, displacement);
    published.propagate();
    EXPECT_LT(largestDifference(published.state(), afterFirst), rounding);
    published.pull(second, { -1.0, 1.5, 0.5 });
    published.propagate();
    EXPECT_LT(largestDifference(published.state(), afterSecond), rounding);
  }
}

TEST(Baselines, WithoutTimestampsAWaveGoesAstrayWhereTissueIsHeterogeneous)
{
  bench::Block block = bench::heterogeneousBlock(size, 4);
  bench::addRods(block);
  const std::size_t element = block.grid.at(8, 5, 11);
  PublishedChainMail published(device(), size, block.constraints(), { Launch::PerBlock, false, { 4, 4, 4 } });
  published.pull(element, displacement);
  published.propagate();
  EXPECT_GT(largestDifference(published.state(), expected(block, element, displacement)), 0.01);
}

TEST(Baselines, PublishedRelaxationEqualsAPlainRun)
{
  const bench::Block block = bench::heterogeneousBlock(size, 5);
  const oracle::Block plain = oracleOf(block);
  const auto neighbours = oracle::graph(plain, 0);
  const std::size_t element = block.grid.at(8, 5, 11);
  const std::size_t held = block.grid.at(9, 8, 8);
  for (const bool timestamps : { false, true })
  {
    for (const PublishedChainMail::Method& method : methods(timestamps))
    {
      PublishedChainMail published(device(), size, block.constraints(), method);
      published.hold(held);
      published.pull(element, displacement);
      published.propagate();
      const baseline::State start = published.state();
      std::vector<oracle::Vector3> u(plain.count());
      for (std::size_t v = 0; v < u.size(); ++v)
      {
        u[v] = { start[0][v], start[1][v], start[2][v] };
      }
      EXPECT_EQ(u[held], oracle::Vector3{});
      EXPECT_EQ(published.relax(25, 0.0), 25);
      for (int step = 0; step < 25; ++step)
      {
        const std::vector<oracle::Vector3> before = u;
        for (std::size_t v = 0; v < u.size(); ++v)
        {
          double weight = 0.0;
          oracle::Vector3 sum{};
          for (const oracle::Neighbour& n : neighbours[v])
          {
            weight += 1.0 / (n.limit + 1e-6);
            for (int a = 0; a < 3; ++a)
            {
              sum[a] += before[n.voxel][a] / (n.limit + 1e-6);
            }
          }
          for (int a = 0; a < 3 && v != element && v != held; ++a)
          {
            u[v][a] = sum[a] / weight;
          }
        }
      }
      EXPECT_LT(largestDifference(published.state(), u), rounding);

      // A tolerance ends it; what comes back is rest, everywhere.
      EXPECT_LT(published.relax(5000, 1e-3), 5000);
      published.reset();
      EXPECT_EQ(largestDifference(published.state(), std::vector<oracle::Vector3>(plain.count())), 0.0);
      EXPECT_EQ(published.relax(5, 0.0), 0);
    }
  }
}

TEST(Baselines, OverRelaxationReachesTheOptimum)
{
  const Index3 small{ 9, 8, 7 };
  bench::Block block = bench::heterogeneousBlock(small, 6);
  bench::addRods(block);
  oracle::Block plain = oracleOf(block);
  const std::size_t handle = block.grid.at(7, 3, 3);
  std::vector<char> held(plain.count(), 0);
  for (std::size_t v = 0; v < plain.count(); v += small[0])
  {
    held[v] = 1; // the face x = 0
  }
  held[handle] = 1;
  const std::vector<oracle::Vector3> start = expected(block, handle, { 0.2, -0.3, 0.25 });
  ASSERT_LE(oracle::maxLinkExcess(plain, start), 1e-9);
  baseline::State state;
  for (int a = 0; a < 3; ++a)
  {
    for (std::size_t v = 0; v < plain.count(); ++v)
    {
      state[a].push_back(static_cast<float>(start[v][a]));
      ASSERT_TRUE(v % small[0] != 0 || start[v][a] == 0.0) << "the wave reaches the face that is held";
    }
  }
  const double optimum = oracle::minimise(plain, held, start).energy;
  for (const double omega : { 1.0, 1.6 })
  {
    baseline::OverRelaxation relaxation(small, block.constraints());
    relaxation.start(state, held);
    EXPECT_NEAR(relaxation.energy(), oracle::energy(plain, start), 1e-5 * relaxation.energy());
    EXPECT_GT(relaxation.energy(), 1.5 * optimum);
    for (int n = 0; n < 400; ++n)
    {
      relaxation.sweep(omega);
    }
    EXPECT_NEAR(relaxation.energy(), optimum, 1e-4 * optimum);
  }
}

// Both go over the colours in the same order, so that they agree sweep by sweep, but for single precision.
TEST(Baselines, DenseSweepsAreThoseOfOverRelaxation)
{
  if (!baseline::DenseSweep::runsHere())
  {
    GTEST_SKIP() << "compiled for another processor";
  }
  const Index3 size{ 19, 8, 7 };
  const bench::Block block = bench::heterogeneousBlock(size, 6);
  std::vector<char> held(block.grid.voxels(), 0);
  baseline::State state;
  Random random(4);
  for (int a = 0; a < 3; ++a)
  {
    for (std::size_t v = 0; v < held.size(); ++v)
    {
      held[v] = v % 31 == 0;
      state[a].push_back(static_cast<float>(random(-0.02, 0.02)));
    }
  }
  baseline::OverRelaxation reference(size, block.constraints());
  baseline::DenseSweep dense(size, block.constraints());
  reference.start(state, held);
  dense.start(state, held);
  for (int sweep = 0; sweep < 10; ++sweep)
  {
    reference.sweep(1.5);
    dense.sweep(1.5f);
    const baseline::State expected = reference.state();
    const auto found = dense.state();
    for (int a = 0; a < 3; ++a)
    {
      for (std::size_t v = 0; v < held.size(); ++v)
      {
        ASSERT_NEAR(found[a][v], expected[a][v], 2e-6) << "sweep " << sweep << ", voxel " << v;
      }
    }
  }
  EXPECT_NE(dense.state()[0], state[0]);
}

TEST(Baselines, TetrahedraOfThePaper)
{
  const baseline::MassSpring model(device(), { 35, 35, 35 });
  EXPECT_EQ(model.tetrahedra(), 196520u);
  // Edges of cubes, and one diagonal a face.
  EXPECT_EQ(model.springs(), 3u * 34 * 35 * 35 + 3u * 34 * 34 * 35);
}

// Held at its border, a lattice that is the same seen from both sides of any node comes to rest where the border's
// affine map puts it.
TEST(Baselines, SpringsFindTheAffineMapOfTheirBorder)
{
  const Index3 n{ 9, 8, 7 };
  baseline::MassSpring model(device(), n);
  const auto map = [](int i, int j, int k) {
    return baseline::MassSpring::Place{ 0.05f * i + 0.02f * j, -0.03f * j + 0.01f * k, 0.04f * k - 0.02f * i };
  };
  std::size_t node = 0;
  for (int k = 0; k < n[2]; ++k)
  {
    for (int j = 0; j < n[1]; ++j)
    {
      for (int i = 0; i < n[0]; ++i, ++node)
      {
        if (i == 0 || j == 0 || k == 0 || i == n[0] - 1 || j == n[1] - 1 || k == n[2] - 1)
        {
          model.hold({ node }, map(i, j, k));
        }
      }
    }
  }
  model.step(400, 0.1f);
  const auto u = model.displacements();
  node = 0;
  for (int k = 0; k < n[2]; ++k)
  {
    for (int j = 0; j < n[1]; ++j)
    {
      for (int i = 0; i < n[0]; ++i, ++node)
      {
        for (int a = 0; a < 3; ++a)
        {
          ASSERT_NEAR(u[node][a], map(i, j, k)[a], 1e-4);
        }
      }
    }
  }
}

TEST(Baselines, SpringsKeepTheirEnergy)
{
  baseline::MassSpring model(device(), { 8, 8, 8 });
  EXPECT_EQ(model.energy(), 0.0);
  model.hold({ 0 }, { 0.0f, 0.0f, 0.0f });
  model.hold({ 8 * 8 * 8 - 1 }, { 0.4f, 0.2f, -0.1f });
  model.step(1, 0.0f);
  const double energy = model.energy();
  EXPECT_GT(energy, 0.01);
  for (int n = 0; n < 50; ++n)
  {
    model.step(10, 0.0f);
    // Verlet's energy swings within (omega dt)^2 / 8 of the truth, it does not drift.
    ASSERT_NEAR(model.energy(), energy, 0.25 * energy);
  }
  model.step(2000, 0.05f);
  EXPECT_LT(model.energy(), 0.5 * energy);
}

}
