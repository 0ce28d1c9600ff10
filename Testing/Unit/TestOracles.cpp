// The oracles are tested without the engine: against closed forms and each other.

#include "../Oracles/Resampling.h"
#include "Scene.h"

namespace
{

/// A chain of elements along x with the given constraints.
oracle::Block chain(const std::vector<double>& give)
{
  oracle::Block block({ static_cast<int>(give.size()), 1, 1 });
  for (std::size_t i = 0; i < give.size(); ++i)
  {
    block.give[i] = { give[i], give[i], give[i] };
  }
  return block;
}

TEST(Oracles, DistancesAlongAChainAreSumsOfMeans)
{
  const oracle::Block block = chain({ 0.1, 0.2, 0.4, 0.0, 0.0 });
  const std::vector<double> d = oracle::shortest(block, 0, { { 0, 0.0 } });
  const double expected[] = { 0.0, 0.15, 0.45, 0.65, 0.65 };
  for (int i = 0; i < 5; ++i)
  {
    EXPECT_NEAR(d[i], expected[i], 1e-15) << i;
  }
}

TEST(Oracles, HomogeneousDistanceIsTheCityBlockOne)
{
  oracle::Block block({ 5, 6, 7 });
  for (auto& g : block.give)
  {
    g = { 0.25, 0.5, 0.125 };
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::vector<double> d = oracle::shortest(block, axis, { { block.at(2, 3, 1), 0.0 } });
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      const oracle::Index3 p = block.index(v);
      const int steps = std::abs(p[0] - 2) + std::abs(p[1] - 3) + std::abs(p[2] - 1);
      EXPECT_EQ(d[v], steps * block.give[0][axis]);
    }
  }
}

TEST(Oracles, DistancesGoAroundRemovedLinks)
{
  oracle::Block block({ 4, 2, 1 });
  for (auto& g : block.give)
  {
    g = { 0.25, 0.25, 0.25 };
  }
  block.cut[block.at(1, 0, 0)] = 1; // between x = 1 and 2 in the row y = 0
  const std::vector<double> d = oracle::shortest(block, 0, { { block.at(1, 0, 0), 0.0 } });
  EXPECT_EQ(d[block.at(2, 0, 0)], 0.75);
  block.cut[block.at(1, 1, 0)] = 1;
  EXPECT_TRUE(std::isinf(oracle::shortest(block, 0, { { 0, 0.0 } })[block.at(2, 0, 0)]));
}

// The paper's propagation shifts one link at a time, in any order. Its fixed point from the source must be (P*).
TEST(Oracles, ClampFormulaEqualsLinkByLinkShifting)
{
  const Scene scene = randomScene({ 7, 6, 5 }, 3, 1);
  const oracle::Block block = scene.block();
  Random random(2);
  const chainmail::Index3 p = randomElement(scene, random);
  oracle::Handle handle;
  handle.elements.assign(1, scene.grid.at(p[0], p[1], p[2]));
  handle.target = { 1.5, -2.0, 0.4 };
  const std::vector<oracle::Vector3> rest(block.count());
  const auto result = oracle::propagate(block, rest, { handle });

  std::vector<oracle::Vector3> shifted = rest;
  shifted[handle.elements[0]] = handle.target;
  for (int axis = 0; axis < 3; ++axis)
  {
    // Elements in the order of their distance from the source. Each is clamped into the box of the element that the
    // path comes from.
    const std::vector<double> d = oracle::shortest(block, axis, { { handle.elements[0], 0.0 } });
    const auto neighbours = oracle::graph(block, axis);
    std::vector<std::size_t> order;
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (std::isfinite(d[v]) && v != handle.elements[0])
      {
        order.push_back(v);
      }
    }
    std::vector<char> done(block.count(), 0);
    done[handle.elements[0]] = 1;
    while (!order.empty())
    {
      std::size_t next = order.size(), from = 0;
      double bound = 0.0;
      for (std::size_t n = 0; n < order.size(); ++n)
      {
        for (const auto& e : neighbours[order[n]])
        {
          if (done[e.voxel] && d[e.voxel] + e.limit <= d[order[n]] + 1e-15 &&
              (next == order.size() || d[order[n]] < d[order[next]]))
          {
            next = n;
            from = e.voxel;
            bound = e.limit;
          }
        }
      }
      ASSERT_LT(next, order.size());
      const std::size_t v = order[next];
      double& u = shifted[v][axis];
      u = std::min(std::max(u, shifted[from][axis] - bound), shifted[from][axis] + bound);
      done[v] = 1;
      order.erase(order.begin() + next);
    }
  }
  EXPECT_LT(largestDifference(block, result.state, shifted), 1e-13);
  EXPECT_LT(oracle::maxLinkExcess(block, result.state), 1e-13);
}

TEST(Oracles, LimitShortensToWhatAChainAllows)
{
  const oracle::Block block = chain({ 0.25, 0.25, 0.25, 0.25, 0.25 });
  const std::vector<oracle::Vector3> rest(5);
  oracle::Handle first{ { 0 }, { 1.0, 0.0, 0.0 }, false };
  oracle::Handle second{ { 4 }, { 5.0, -3.0, 0.5 }, false };
  const auto result = oracle::propagate(block, rest, { first, second });
  EXPECT_EQ(result.reached[0], (oracle::Vector3{ 1.0, 0.0, 0.0 }));
  EXPECT_EQ(result.reached[1], (oracle::Vector3{ 2.0, -1.0, 0.5 }));
}

// Two unknowns between held ends: the optimum by hand.
TEST(Oracles, OptimumOfAChainByHand)
{
  // Ends held at 0 and t, limits all D: free optimum is linear, energy t^2 / (3 (D + eps)).
  const oracle::Block block = chain({ 0.4, 0.4, 0.4, 0.4 });
  std::vector<oracle::Vector3> start(4);
  start[3] = { 0.6, -0.9, 0.0 };
  const oracle::Optimum best = oracle::minimise(block, { 1, 0, 0, 1 }, start, 1e-10);
  const double w = 1.0 / (0.4 + 1e-6);
  EXPECT_NEAR(best.energy, w * (0.6 * 0.6 + 0.9 * 0.9) / 3.0, 1e-8);
  EXPECT_LE(best.gap(), 1e-9);
  EXPECT_NEAR(best.state[1][0], 0.2, 1e-5);
  EXPECT_NEAR(best.state[2][1], -0.6, 1e-5);

  // In a chain pulled to its full length, here 0.4 + 0.25 + 0.4, every link is at its limit.
  const oracle::Block series = chain({ 0.7, 0.1, 0.4, 0.4 });
  start[3] = { 1.05, 0.0, 0.0 };
  const oracle::Optimum full = oracle::minimise(series, { 1, 0, 0, 1 }, start, 1e-10);
  EXPECT_NEAR(full.state[1][0], 0.4, 1e-6);
  EXPECT_NEAR(full.state[2][0], 0.65, 1e-6);
}

// A quarter of every limit has no energy; the rest of the strain is distributed as before.
TEST(Oracles, OptimumOfAPlasticChainByHand)
{
  oracle::Block block = chain({ 0.4, 0.4, 0.4, 0.4 });
  block.slack = 0.25;
  std::vector<oracle::Vector3> start(4);
  start[3] = { 0.6, -0.9, 0.2 };
  const oracle::Optimum best = oracle::minimise(block, { 1, 0, 0, 1 }, start, 1e-10);
  const double w = 1.0 / (0.4 + 1e-6);
  EXPECT_NEAR(
    best.energy, 3.0 * w * (0.1 * 0.1 + 0.2 * 0.2), 1e-8); // strains 0.2, 0.3, of which 0.067, 0.1 have no energy
  EXPECT_NEAR(best.bound, best.energy, 1e-8);
  EXPECT_NEAR(oracle::energy(block, best.state), best.energy, 1e-8);

  // At its full length every link is at its limit, and three quarters of its strain have energy.
  start[3] = { 1.2, 0.0, 0.0 };
  const oracle::Optimum full = oracle::minimise(block, { 1, 0, 0, 1 }, start, 1e-10);
  EXPECT_NEAR(full.energy, 3.0 * w * 0.3 * 0.3, 1e-8);
  EXPECT_NEAR(full.state[1][0], 0.4, 1e-6);
}

TEST(Oracles, OptimumWithAnActiveLimitByHand)
{
  // a b c over e: one free element b with three held neighbours.
  oracle::Block block({ 3, 2, 1 });
  const double give[6] = { 0.6, 0.8, 0.6, 0.0, 0.1, 0.0 };
  for (int v = 0; v < 6; ++v)
  {
    block.give[v] = { give[v], give[v], give[v] };
  }
  block.tissue[3] = block.tissue[5] = 0;
  std::vector<oracle::Vector3> start(6);
  start[2] = { 1.0, 0.0, 0.0 };
  start[0] = { 0.0, 0.0, 0.0 };
  start[4] = { 0.0, 0.0, 0.0 };
  // b: neighbours a (0, D .7), c (1, D .7), e (0, D .45). Free optimum: (1/.7) / (2/.7 + 1/.45) = 0.281: outside
  // |b - 1| <= 0.7, so b = 0.3 at the limit.
  const oracle::Optimum best = oracle::minimise(block, { 1, 0, 1, 0, 1, 0 }, start, 1e-9);
  EXPECT_NEAR(best.state[1][0], 0.3, 1e-7);
  const double e = 1e-6;
  EXPECT_NEAR(best.energy, 0.09 / (0.7 + e) + 0.49 / (0.7 + e) + 0.09 / (0.45 + e), 1e-7);
  EXPECT_LE(best.gap(), 1e-7);
}

// Properties of the optimum itself: the state is feasible, its energy is the reported one, and no random feasible
// change lowers it.
TEST(Oracles, OptimumIsProvenAndNoTrialBeatsIt)
{
  Scene scene = randomScene({ 6, 6, 6 }, 1, 5, 0.1, 0.2);
  scene.anchors.faces[0] = true;
  oracle::Block block = scene.block();
  std::vector<char> held(block.anchored);
  oracle::Handle handle;
  handle.elements.assign(1, block.at(5, 3, 3));
  block.tissue[handle.elements[0]] = 1;
  handle.target = { 1.0, -0.5, 3.0 };
  const auto pulled = oracle::propagate(block, std::vector<oracle::Vector3>(block.count()), { handle });
  held[handle.elements[0]] = 1;
  const oracle::Optimum best = oracle::minimise(block, held, pulled.state);
  EXPECT_LE(best.gap(), 1e-5);
  EXPECT_GE(best.gap(), -1e-9); // a bound above a feasible energy would be wrong
  EXPECT_LT(oracle::maxLinkExcess(block, best.state), 1e-12);
  EXPECT_NEAR(oracle::energy(block, best.state), best.energy, 1e-9 * best.energy);
  EXPECT_LT(best.energy, 0.9 * oracle::energy(block, pulled.state));

  Random random(6);
  for (int trial = 0; trial < 200; ++trial)
  {
    // All states between the optimum and another feasible state are feasible. The other one is (P*) of another pull.
    oracle::Handle other;
    const chainmail::Index3 p = randomElement(scene, random);
    other.elements.assign(1, block.at(p[0], p[1], p[2]));
    std::vector<oracle::Handle> all{ { { handle.elements[0] }, best.state[handle.elements[0]], false }, other };
    for (int a = 0; a < 3; ++a)
    {
      all[1].target[a] = best.state[other.elements[0]][a] + random(-0.05, 0.05);
    }
    const auto moved = oracle::propagate(block, best.state, all);
    EXPECT_GE(oracle::energy(block, moved.state), best.energy * (1.0 - 1e-6));
  }
}

TEST(Oracles, SegmentMeetsTriangle)
{
  const oracle::Vector3 a{ 0.0, -1.0, -1.0 }, b{ 0.0, 2.0, -1.0 }, c{ 0.0, -1.0, 2.0 };
  EXPECT_TRUE(oracle::crossing({ -1, 0, 0 }, { 1, 0, 0 }, a, b, c).crosses);
  EXPECT_TRUE(oracle::crossing({ 1, 0, 0 }, { -1, 0, 0 }, c, b, a).crosses);
  EXPECT_FALSE(oracle::crossing({ -1, 0, 0 }, { -0.1, 0, 0 }, a, b, c).crosses); // ends before
  EXPECT_FALSE(oracle::crossing({ 0.1, 0, 0 }, { 1, 0, 0 }, a, b, c).crosses);   // begins behind
  EXPECT_FALSE(oracle::crossing({ -1, 1, 1 }, { 1, 1, 1 }, a, b, c).crosses);    // passes outside the long edge
  EXPECT_FALSE(oracle::crossing({ -1, -2, 0 }, { 1, -2, 0 }, a, b, c).crosses);
  EXPECT_FALSE(oracle::crossing({ 0.5, -1, 0 }, { 0.5, 1, 0 }, a, b, c).crosses); // parallel
  EXPECT_NEAR(oracle::crossing({ -1, 0, 0 }, { 3, 0, 0 }, a, b, c).margin, 0.25, 1e-15);
}

TEST(Oracles, CutPlaneLeavesTwoParts)
{
  oracle::Block block({ 6, 5, 4 });
  const std::vector<oracle::Vector3> rest(block.count());
  oracle::cut(block, rest, { { 2.3, -9, -9 }, { 2.4, 12, -9 }, { 2.35, -9, 14 }, { 2.45, 12, 14 } },
    { { 0, 1, 2 }, { 1, 2, 3 } });
  int number = 0;
  const std::vector<int> part = oracle::parts(block, &number);
  EXPECT_EQ(number, 2);
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    EXPECT_EQ(part[v], block.index(v)[0] > 2 ? 1 : 0);
  }
}

TEST(Oracles, ClustersAreNumberedByTheirFirstVoxel)
{
  const oracle::Block block = chain({ 0.0, 0.0, 0.3, 0.0, 0.1, 0.0, 0.0 });
  EXPECT_EQ(oracle::clusters(block, 0), (std::vector<int>{ 0, 0, -1, 1, -1, 2, 2 }));
}

TEST(Oracles, PreimageOfALinearField)
{
  oracle::LinearField field;
  field.gradient = { { { 0.25, 0.1, 0.0 }, { -0.05, 0.0, 0.2 }, { 0.0, 0.3, -0.25 } } };
  field.shift = { 1.0, -2.0, 0.5 };
  for (const oracle::Vector3& x : { oracle::Vector3{ 3, 4, 5 }, oracle::Vector3{ -1, 0, 9 } })
  {
    const oracle::Vector3 u = field.at(x);
    const oracle::Vector3 back = field.preimage({ x[0] + u[0], x[1] + u[1], x[2] + u[2] });
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(back[a], x[a], 1e-12);
    }
  }
}

}
