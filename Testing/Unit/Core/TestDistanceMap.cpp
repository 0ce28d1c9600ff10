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
    std::vector<char> isSolid(grid.voxels());
    std::generate(isSolid.begin(), isSolid.end(), [&] { return random.below(200) >= share ? 1 : 0; });
    VoxelSet where(grid); // with some of the voxels that are not solid
    for (std::size_t n = 0; n < grid.voxels(); ++n)
    {
      if (isSolid[n] != 0 || random.below(2) == 0)
      {
        where.insert(n);
      }
    }
    VoxelMap<char> solid(where);
    solid.forEach([&](std::size_t voxel, char& is) { is = isSolid[voxel]; });
    for (const bool halfway : { false, true })
    {
      const std::vector<std::uint16_t> found = mapDistances(grid, solid, halfway);
      auto next = found.begin();
      solid.forEach(
        [&](std::size_t n, char)
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
            expected = isSolid[m] != 0 ? expected : std::min(expected, square);
          }
          for (int a = 0; a < 3; ++a)
          {
            expected = halfway && grid.size[a] > 1 && at[a] == grid.size[a] - 1 ? 0 : expected;
          }
          ASSERT_EQ(*next++, expected) << "trial " << trial << ", voxel " << n << ", halfway " << halfway;
        });
      ASSERT_TRUE(next == found.end());
    }
  }
}

TEST(DistanceMap, FarDistancesCountAsTheFarthest)
{
  Grid grid;
  grid.size = { 400, 1, 1 };
  VoxelSet where(grid);
  for (std::size_t n = 0; n < 400; ++n)
  {
    where.insert(n);
  }
  VoxelMap<char> solid(where, 1);
  std::vector<std::uint16_t> found = mapDistances(grid, solid, false);
  EXPECT_EQ(std::count(found.begin(), found.end(), farthest), 400);
  solid.set(0, 0);
  found = mapDistances(grid, solid, false);
  for (int n = 0; n < 400; ++n)
  {
    EXPECT_EQ(found[n], std::min(4 * n * n, 65535)); // 127 voxels are 64516
  }
}

}
