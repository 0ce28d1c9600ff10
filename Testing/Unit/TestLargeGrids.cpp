// Grids of up to 8.6 billion voxels, most of them air. Rows are computed on request, so they need no memory.

#include "Scene.h"

#include <cstring>
#include <map>

namespace
{

using namespace chainmail;

constexpr int width = 32; // width of the small grid [voxels]
constexpr int margin = 5; // air around the tissue in the small grid [voxels]

/// A cube of tissue with a rod of bone, in a grid with `corner` further voxels before it on every axis.
std::shared_ptr<const Model> cube(int corner)
{
  Grid grid;
  grid.size = { corner + width, corner + width, corner + width };
  return std::make_shared<const Model>(grid, 1,
    [grid, corner](std::size_t first, int count, float* out)
    {
      const Index3 at = grid.indexOf(first);
      const auto inside = [corner](int x) { return x >= corner + margin && x < corner + width - margin; };
      for (int n = 0; n < count; ++n)
      {
        const bool tissue = inside(at[0] + n) && inside(at[1]) && inside(at[2]);
        const bool bone = tissue && at[1] == corner + 20 && at[2] == corner + 20;
        out[n] = !tissue ? -std::numeric_limits<float>::infinity()
                 : bone  ? 0.0f
                         : 0.2f + 0.001f * static_cast<float>((at[0] + n - corner) % 7);
      }
    });
}

/// The change of the output by a pull of the cube: the offsets of all changed voxels, by their place relative to the
/// corner.
std::map<Index3, std::array<float, 3>> pulled(int corner)
{
  Simulation simulation(cube(corner), {});
  Probe probe;
  probe.position = { corner + 16.0, corner + 14.0, corner + 15.0 };
  probe.displacement = { 3.5, -2.25, 1.75 };
  probe.radius = 2.0;
  simulation.pull({ probe });
  std::map<Index3, std::array<float, 3>> found;
  simulation.resample({ 0, 0, 0 },
    visitEach(
      [&](const Index3& voxel, const float* offset)
      {
        if (!(offset[0] == 0.0f && offset[1] == 0.0f && offset[2] == 0.0f))
        {
          found[{ voxel[0] - corner, voxel[1] - corner, voxel[2] - corner }] = { offset[0], offset[1], offset[2] };
        }
      }));
  return found;
}

/// The last corner has numbers of voxels that need 31 bits, or 33.
TEST(LargeGrids, TheLastCornerIsResampledAsASmallGridIs)
{
  const auto small = pulled(0);
  EXPECT_GT(small.size(), 5000u);
  for (const int size : { 1024, 2048 })
  {
    const auto large = pulled(size - width);
    ASSERT_EQ(small.size(), large.size());
    for (auto a = small.begin(), b = large.begin(); a != small.end(); ++a, ++b)
    {
      ASSERT_EQ(a->first, b->first);
      ASSERT_EQ(std::memcmp(a->second.data(), b->second.data(), sizeof(a->second)), 0) << a->first[0];
    }
  }
}

TEST(LargeGrids, SmallBricksMayBeTooMany)
{
  Grid grid;
  grid.size = { 4000, 4000, 4000 };
  const auto model =
    std::make_shared<const Model>(grid, 1, [](std::size_t, int count, float* out) { std::fill_n(out, count, 0.2f); });
  Settings settings;
  settings.device = testDevice();
  settings.brickSize = { 4, 2, 2 };
  try
  {
    Simulation simulation(model, settings);
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(std::string(error.what()), "The brick size 4 x 2 x 2 divides the image into more than 2147483647 bricks. "
                                         "Take larger ones, or all 0 for the best size.");
  }
}

}
