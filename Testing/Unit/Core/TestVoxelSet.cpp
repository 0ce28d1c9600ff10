// Sets of voxels, and the cavities in them, compared with searches that visit voxel after voxel.

#include "Cavities.h"
#include "Random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace
{

using namespace chainmail;

/// A grid whose rows and layers seldom end with a word of the set.
Grid randomGrid(Random& random, int most)
{
  Grid grid;
  for (int& size : grid.size)
  {
    size = random.oneIn(5) ? 1 : random.between(2, most);
  }
  return grid;
}

std::vector<char> randomFlags(Random& random, const Grid& grid, double share)
{
  std::vector<char> flags(grid.voxels());
  std::generate(flags.begin(), flags.end(), [&] { return random.chance(share) ? 1 : 0; });
  return flags;
}

VoxelSet setOf(const Grid& grid, const std::vector<char>& flags)
{
  VoxelSet set(grid);
  for (std::size_t n = 0; n < flags.size(); ++n)
  {
    if (flags[n] != 0)
    {
      set.insert(n);
    }
  }
  return set;
}

/// Whether two voxels share a face.
bool touch(const Index3& a, const Index3& b)
{
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) == 1;
}

TEST(VoxelSet, NumbersItsMembersInAscendingOrder)
{
  Random random(3);
  for (int trial = 0; trial < 40; ++trial)
  {
    const Grid grid = randomGrid(random, trial < 38 ? 20 : 60); // the last ones have more than one block of words
    const std::vector<char> flags = randomFlags(random, grid, random(0.0, 1.0));
    VoxelMap<int> map(setOf(grid, flags), 7);
    std::vector<std::size_t> visited;
    map.forEach([&](std::size_t voxel, int value) { visited.push_back(value == 7 ? voxel : VoxelSet::none); });
    std::size_t next = 0;
    for (std::size_t n = 0; n < flags.size(); ++n)
    {
      ASSERT_EQ(map.where().contains(n), flags[n] != 0);
      ASSERT_EQ(map.where().numberOf(n), flags[n] != 0 ? next : VoxelSet::none);
      ASSERT_EQ(map.at(n), flags[n] != 0 ? 7 : 0);
      if (flags[n] != 0)
      {
        ASSERT_EQ(visited.at(next), n);
        ++next;
      }
    }
    ASSERT_EQ(visited.size(), next);
    ASSERT_EQ(map.where().count(), next);
  }
}

// It may add more than what it has to, but only across the ends of rows and layers: never in the middle of a grid.
TEST(VoxelSet, GrowsStepByStep)
{
  Random random(4);
  for (int trial = 0; trial < 60; ++trial)
  {
    const Grid grid = randomGrid(random, 12);
    const bool isInside = random.oneIn(2);
    std::vector<char> start = randomFlags(random, grid, 0.02);
    std::vector<char> others = randomFlags(random, grid, random(0.3, 1.0));
    for (std::size_t n = 0; isInside && n < others.size(); ++n)
    {
      const Index3 at = grid.indexOf(n);
      const bool isLast = at[0] + 1 == grid.size[0] || at[1] + 1 == grid.size[1];
      start[n] = isLast ? 0 : start[n];
      others[n] = isLast ? 0 : others[n];
    }
    const int steps = random.between(0, 6);
    VoxelSet grown = setOf(grid, start);
    grown.growInto(setOf(grid, others), grid, steps);

    std::vector<char> expected = start;
    for (int step = 0; step < steps; ++step)
    {
      const std::vector<char> before = expected;
      for (std::size_t n = 0; n < expected.size(); ++n)
      {
        for (std::size_t m = 0; m < expected.size() && others[n] != 0; ++m)
        {
          expected[n] = before[m] != 0 && touch(grid.indexOf(n), grid.indexOf(m)) ? 1 : expected[n];
        }
      }
    }
    for (std::size_t n = 0; n < expected.size(); ++n)
    {
      ASSERT_TRUE(expected[n] == 0 || grown.contains(n)) << "trial " << trial << ", voxel " << n;
      ASSERT_TRUE(!grown.contains(n) || start[n] != 0 || others[n] != 0);
      ASSERT_TRUE(!isInside || grown.contains(n) == (expected[n] != 0)) << "trial " << trial << ", voxel " << n;
    }
  }
}

/// Spreads `mark` from marked voxels to open ones (0) that touch them and for which isWithin(voxel), until none is
/// left.
template <typename IsWithin>
void spread(const Grid& grid, std::vector<char>& state, char mark, const IsWithin& isWithin)
{
  for (bool isDone = false; !isDone;)
  {
    isDone = true;
    for (std::size_t n = 0; n < state.size(); ++n)
    {
      const Index3 at = grid.indexOf(n);
      for (int d = 0; d < 6 && state[n] == 0 && isWithin(at); ++d)
      {
        Index3 next = at;
        next[d / 2] += d % 2 == 0 ? -1 : 1;
        if (grid.contains(next[0], next[1], next[2]) && isWithin(next) &&
            state[grid.at(next[0], next[1], next[2])] == mark)
        {
          state[n] = mark;
          isDone = false;
        }
      }
    }
  }
}

TEST(Cavities, AreWhatNoPathReaches)
{
  constexpr char solid = 1;
  constexpr char outside = 2;
  constexpr char reached = 3;
  Random random(5);
  int filled = 0;
  int cutOpen = 0; // on a face of the grid
  for (int trial = 0; trial < 150; ++trial)
  {
    const Grid grid = randomGrid(random, 9);
    const double share = random(0.3, 0.8);
    const double shareOutside = random.oneIn(2) ? 0.0 : 0.02;
    std::vector<char> state(grid.voxels());
    std::generate(state.begin(), state.end(),
      [&] { return random.chance(shareOutside) ? outside
                   : random.chance(share)      ? solid
                                               : char(0); });

    VoxelSet found(grid);
    VoxelSet others(grid);
    for (std::size_t n = 0; n < state.size(); ++n)
    {
      if (state[n] != 0)
      {
        (state[n] == solid ? found : others).insert(n);
      }
    }
    fillCavities(grid, others, found);

    std::vector<char> expected = state;
    for (int face = 0; face < 6; ++face)
    {
      const int across = face / 2;
      const auto isInFace = [&](const Index3& at) { return at[across] == (face % 2) * (grid.size[across] - 1); };
      for (std::size_t n = 0; n < state.size(); ++n)
      {
        const Index3 at = grid.indexOf(n);
        bool isSide = false;
        for (int a = 0; a < 3; ++a)
        {
          isSide = isSide || (a != across && (at[a] == 0 || at[a] + 1 == grid.size[a]));
        }
        expected[n] = state[n] == 0 && isInFace(at) && isSide ? reached : expected[n];
      }
      spread(grid, expected, reached, isInFace);
    }
    const auto everywhere = [](const Index3&) { return true; };
    spread(grid, expected, reached, everywhere);
    for (char& value : expected) // what touches the one may touch the other, too
    {
      value = value == reached ? outside : value;
    }
    spread(grid, expected, outside, everywhere);
    for (std::size_t n = 0; n < state.size(); ++n)
    {
      ASSERT_EQ(found.contains(n), expected[n] != outside) << "trial " << trial << ", voxel " << n;
      filled += expected[n] == 0 ? 1 : 0;
      const Index3 at = grid.indexOf(n);
      cutOpen += expected[n] == 0 && (at[0] == 0 || at[1] == 0 || at[2] == 0) ? 1 : 0;
    }
  }
  EXPECT_GT(filled, 500);
  EXPECT_GT(cutOpen, 50);
}

}
