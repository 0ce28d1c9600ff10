// The projection of a state to a feasible one, against Dijkstra's algorithm in double precision, and what it leaves
// alone.

#include "Feasibility.h"

#include "ElementRule.h"
#include "Elements.h"
#include "Scene.h"

#include <algorithm>
#include <set>

namespace
{

using namespace chainmail;

// A feasible bump in tissue at rest. The bricks around it have no state, and need none.
TEST(Feasibility, TissueAtRestAroundAFeasibleStateGetsNoState)
{
  for (const Index3& size : { Index3{ 4, 4, 4 }, Index3{ 8, 4, 4 }, Index3{ 16, 4, 4 }, Index3{ 32, 4, 4 } })
  {
    const Scene scene({ 96, 24, 24 }, 0.9f);
    Bricks bricks(Context::of(testDevice()), scene.model(), size);
    EnvelopePropagation propagation(bricks);
    Feasibility feasibility(bricks);
    std::set<int> touched;
    std::vector<std::size_t> voxels;
    std::vector<float> bump;
    for (int k = 8; k < 16; ++k)
    {
      for (int j = 8; j < 16; ++j)
      {
        for (int i = 32; i < 64; ++i)
        {
          const int depth = std::min({ i - 31, 64 - i, j - 7, 16 - j, k - 7, 16 - k });
          touched.insert(bricks.brickAt(i, j, k));
          voxels.push_back(scene.grid.at(i, j, k));
          bump.insert(bump.end(), { 0.0f, 0.8f * static_cast<float>(depth), -0.6f * static_cast<float>(depth) });
        }
      }
    }
    const std::vector<int> moved(touched.begin(), touched.end());
    bricks.makeUpdatable(moved);
    bricks.markDirty(bricks.slotsOf(moved));
    const Elements elements(bricks, voxels);
    elements.setDisplacements(bump);
    const int states = bricks.states();
    EXPECT_LT(states, bricks.slots()) << "all bricks have a state";

    EXPECT_TRUE(feasibility.run(propagation, [] {}));
    EXPECT_EQ(bricks.states(), states) << size[0];
    EXPECT_EQ(elements.displacements(), bump) << size[0];
  }
}

/// Small differences between neighbours everywhere, and few large ones: what passes through tissue first is overtaken.
/// Held elements have the same displacement, so they are compatible.
std::vector<float> roughDisplacements(
  const std::vector<std::size_t>& voxels, const std::set<std::size_t>& held, Random& random)
{
  std::vector<float> u;
  for (const std::size_t voxel : voxels)
  {
    for (const float place : { 0.9f, -0.4f, 0.2f })
    {
      const double rough = random.oneIn(300) ? random(-6.0, 6.0) : random(-0.3, 0.3);
      u.push_back(held.count(voxel) > 0 ? place : static_cast<float>(rough));
    }
  }
  return u;
}

/// Formula of the projection: the mean of both bounds, clamped to what held elements allow.
std::vector<double> projected(const oracle::Block& block, const std::vector<std::size_t>& voxels,
  const std::set<std::size_t>& held, const std::vector<float>& u)
{
  std::vector<double> result(u.size());
  for (int axis = 0; axis < 3; ++axis)
  {
    std::vector<std::pair<std::size_t, double>> up, down, heldUp, heldDown;
    for (std::size_t n = 0; n < voxels.size(); ++n)
    {
      const double place = u[3 * n + axis];
      up.push_back({ voxels[n], place });
      down.push_back({ voxels[n], -place });
      if (held.count(voxels[n]) > 0)
      {
        heldUp.push_back(up.back());
        heldDown.push_back(down.back());
      }
    }
    const std::vector<double> upper = oracle::shortest(block, axis, up);
    const std::vector<double> lower = oracle::shortest(block, axis, down);
    const std::vector<double> high = oracle::shortest(block, axis, heldUp);
    const std::vector<double> low = oracle::shortest(block, axis, heldDown);
    for (std::size_t n = 0; n < voxels.size(); ++n)
    {
      const std::size_t v = voxels[n];
      result[3 * n + axis] = std::min(std::max(0.5 * (upper[v] - lower[v]), -low[v]), high[v]);
    }
  }
  return result;
}

TEST(Feasibility, IsTheMeanOfBothBoundsAtAllBrickSizes)
{
  for (std::uint64_t seed = 0; seed < 4; ++seed)
  {
    const Scene scene = randomScene({ 70, 26, 22 }, seed % 2 == 0 ? 1 : 3, 9300 + seed);
    Random random(9400 + seed);
    std::vector<std::size_t> voxels;
    scene.each(
      [&](int i, int j, int k)
      {
        if (scene.tissue(scene.grid.at(i, j, k)))
        {
          voxels.push_back(scene.grid.at(i, j, k));
        }
      });
    std::set<std::size_t> held;
    while (held.size() < 3 * seed)
    {
      const Index3 p = randomElement(scene, random);
      held.insert(scene.grid.at(p[0], p[1], p[2]));
    }
    const std::vector<float> u = roughDisplacements(voxels, held, random);
    const oracle::Block block = scene.block();
    const std::vector<double> expected = projected(block, voxels, held, u);

    std::vector<float> first;
    for (const Index3& size : brickSizes())
    {
      Bricks bricks(Context::of(testDevice()), scene.model(), size);
      EnvelopePropagation propagation(bricks);
      Feasibility feasibility(bricks);
      std::set<int> touched;
      for (const std::size_t voxel : voxels)
      {
        const Index3 at = scene.grid.indexOf(voxel);
        touched.insert(bricks.brickAt(at[0], at[1], at[2]));
      }
      const std::vector<int> all(touched.begin(), touched.end());
      bricks.makeUpdatable(all);
      bricks.markDirty(bricks.slotsOf(all));
      const Elements handle(bricks, std::vector<std::size_t>(held.begin(), held.end()));
      std::vector<float> constraints = handle.constraints();
      std::transform(
        constraints.begin(), constraints.end(), constraints.begin(), [](float c) { return rule::asHeld(c, true); });
      handle.setConstraints(constraints);
      const Elements elements(bricks, voxels);
      elements.setDisplacements(u);

      EXPECT_TRUE(feasibility.run(propagation, [] {}));
      const std::vector<float> found = elements.displacements();
      double off = 0.0;
      for (std::size_t n = 0; n < found.size(); ++n)
      {
        off = std::max(off, std::fabs(found[n] - expected[n]));
        if (held.count(voxels[n / 3]) > 0)
        {
          ASSERT_EQ(found[n], u[n]) << "a held element moves";
        }
      }
      // Sums of up to some 100 links in float32, of displacements up to 6. Measured: up to 1.9e-6.
      EXPECT_LT(off, 6e-6) << "seed " << seed;
      first = first.empty() ? found : first;
      EXPECT_TRUE(sameBits(found, first)) << "seed " << seed << ", bricks of " << size[0];
    }
  }
}

}
