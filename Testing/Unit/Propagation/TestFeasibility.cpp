// The projection of a state to a feasible one: what it leaves alone.

#include "Feasibility.h"

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

}
