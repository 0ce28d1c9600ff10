// The coarser grids beside cuts: what a cut separates on the finest grid it separates on all of them. The oracle is the
// plane of the cut itself.

#include "CoarseModel.h"

#include "Scene.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace
{

using namespace chainmail;

/// A plane through a grid, and the sides of it.
struct Plane
{
  Vector3 normal;
  double offset;

  bool isAbove(const Index3& at) const
  {
    return at[0] * this->normal[0] + at[1] * this->normal[1] + at[2] * this->normal[2] > this->offset;
  }
};

/// A plane in any direction, also along the axes and diagonals, near the middle of a grid.
Plane randomPlane(const Grid& grid, Random& random)
{
  Plane plane;
  do
  {
    for (double& n : plane.normal)
    {
      n = random.chance(0.5) ? random(-1.0, 1.0) : random.between(-1, 1);
    }
  } while (plane.normal == Vector3{ 0.0, 0.0, 0.0 });
  plane.offset = 0.013; // through no voxel
  for (int a = 0; a < 3; ++a)
  {
    plane.offset += plane.normal[a] * grid.size[a] * random(0.4, 0.6);
  }
  return plane;
}

/// Removes all links that lead through the plane.
void cut(Bricks& bricks, const Plane& plane)
{
  const Grid& grid = bricks.model().grid();
  for (std::size_t voxel = 0; voxel < grid.voxels(); ++voxel)
  {
    const Index3 at = grid.indexOf(voxel);
    for (int a = 0; a < 3; ++a)
    {
      Index3 next = at;
      ++next[a];
      if (next[a] < grid.size[a] && plane.isAbove(at) != plane.isAbove(next))
      {
        bricks.removeLink(at[0], at[1], at[2], 2 * a + 1);
      }
    }
  }
  bricks.uploadCuts();
}

/// The elements that links join to this one.
std::vector<bool> reachedFrom(const Bricks& bricks, const Index3& first)
{
  const Grid& grid = bricks.model().grid();
  std::vector<bool> reached(grid.voxels(), false);
  std::vector<Index3> waiting{ first };
  reached[grid.at(first[0], first[1], first[2])] = true;
  while (!waiting.empty())
  {
    const Index3 at = waiting.back();
    waiting.pop_back();
    bricks.forNeighbours(at,
      [&](int, const Index3& next)
      {
        const std::size_t n = grid.at(next[0], next[1], next[2]);
        if (!reached[n] && bricks.isElement(next))
        {
          reached[n] = true;
          waiting.push_back(next);
        }
      });
  }
  return reached;
}

/// The sides on which the voxels of a coarser element are: bit 0 below the plane, bit 1 above.
int sidesOf(const Plane& plane, const Grid& finest, const Index3& element, int size)
{
  int sides = 0;
  for (int k = element[2] * size; k < std::min((element[2] + 1) * size, finest.size[2]); ++k)
  {
    for (int j = element[1] * size; j < std::min((element[1] + 1) * size, finest.size[1]); ++j)
    {
      for (int i = element[0] * size; i < std::min((element[0] + 1) * size, finest.size[0]); ++i)
      {
        sides |= plane.isAbove({ i, j, k }) ? 2 : 1;
      }
    }
  }
  return sides;
}

}

TEST(CoarseModel, WhatAPlaneSeparatesStaysSeparate)
{
  const std::shared_ptr<Context> context = Context::of(testDevice());
  for (int seed = 0; seed < 40; ++seed)
  {
    Random random(20261128 + seed);
    const Scene scene({ random.between(24, 33), random.between(24, 33), random.between(24, 33) });
    const Grid& finest = scene.grid;
    const Plane plane = randomPlane(finest, random);
    std::vector<std::unique_ptr<Bricks>> grids;
    grids.push_back(std::make_unique<Bricks>(context, scene.model(), Index3{ 8, 4, 4 }));
    cut(*grids[0], plane);
    for (int size = 2; size <= 4; size *= 2)
    {
      const Bricks& finer = *grids.back();
      grids.push_back(std::make_unique<Bricks>(context, coarserModel(finer, true), Index3{ 8, 4, 4 }));
      Bricks& coarser = *grids.back();
      coarsenCuts(finer, coarser);
      const Grid& grid = coarser.model().grid();
      std::array<std::vector<std::size_t>, 4> elements; // by the sides on which they are
      for (std::size_t n = 0; n < grid.voxels(); ++n)
      {
        elements[sidesOf(plane, finest, grid.indexOf(n), size)].push_back(n);
      }
      ASSERT_FALSE(elements[1].empty() || elements[2].empty());
      const std::vector<bool> reached = reachedFrom(coarser, grid.indexOf(elements[1].front()));
      for (const std::size_t n : elements[1])
      {
        EXPECT_TRUE(reached[n]) << "seed " << seed << ": the cut divides one side of it, size " << size;
      }
      for (const std::size_t n : elements[2])
      {
        EXPECT_FALSE(reached[n]) << "seed " << seed << ": a link leads across the cut, size " << size;
      }
    }
  }
}
