// The distance map, compared with the shortest of all distances.

#include "DistanceMap.h"
#include "Random.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace
{

using namespace chainmail;

TEST(DistanceMap, IsTheShortestOfAllDistances)
{
  Random random(31);
  for (int trial = 0; trial < 60; ++trial)
  {
    Grid grid;
    for (int& size : grid.size)
    {
      size = random.below(4) == 0 ? 1 : 2 + random.below(11);
    }
    const int share = 1 + random.below(60); // of voxels that are not solid [1/200]; 0 of them in some trials
    std::vector<char> solid(grid.voxels());
    std::generate(solid.begin(), solid.end(), [&] { return random.below(200) >= share ? 1 : 0; });
    for (const bool halfway : { false, true })
    {
      std::vector<std::uint16_t> found(grid.voxels());
      mapDistances(grid, solid, halfway, found.data());
      for (std::size_t n = 0; n < grid.voxels(); ++n)
      {
        const Index3 at = grid.indexOf(n);
        int expected = 65535;
        for (std::size_t m = 0; m < grid.voxels(); ++m)
        {
          int square = 0;
          for (int a = 0; a < 3; ++a)
          {
            const int way = 2 * (at[a] - grid.indexOf(m)[a]) + (halfway && grid.size[a] > 1 ? 1 : 0);
            square += way * way;
          }
          expected = solid[m] != 0 ? expected : std::min(expected, square);
        }
        for (int a = 0; a < 3; ++a)
        {
          expected = halfway && grid.size[a] > 1 && at[a] == grid.size[a] - 1 ? 0 : expected;
        }
        ASSERT_EQ(found[n], expected) << "trial " << trial << ", voxel " << n << ", halfway " << halfway;
      }
    }
  }
}

TEST(DistanceMap, FarDistancesCountAsTheFarthest)
{
  Grid grid;
  grid.size = { 400, 1, 1 };
  std::vector<char> solid(grid.voxels(), 1);
  std::vector<std::uint16_t> found(grid.voxels());
  mapDistances(grid, solid, false, found.data());
  EXPECT_EQ(std::count(found.begin(), found.end(), farthest), 400);
  solid[0] = 0;
  mapDistances(grid, solid, false, found.data());
  for (int n = 0; n < 400; ++n)
  {
    EXPECT_EQ(found[n], std::min(4 * n * n, 65535)); // 127 voxels are 64516
  }
}

}
