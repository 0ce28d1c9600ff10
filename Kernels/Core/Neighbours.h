#pragma once

#include "Model.h"

#include <array>
#include <cstddef>

namespace chainmail
{

/// How far apart neighbours along each axis are in the order of voxels.
inline std::array<std::size_t, 3> stridesOf(const Grid& grid)
{
  return { 1, static_cast<std::size_t>(grid.size[0]), static_cast<std::size_t>(grid.size[0]) * grid.size[1] };
}

/// The neighbours of a voxel: visit(voxel).
template <typename Visit> void forFaces(const Grid& grid, std::size_t voxel, const Visit& visit)
{
  const Index3 at = grid.indexOf(voxel);
  const std::array<std::size_t, 3> strides = stridesOf(grid);
  for (int a = 0; a < 3; ++a)
  {
    if (at[a] > 0)
    {
      visit(voxel - strides[a]);
    }
    if (at[a] + 1 < grid.size[a])
    {
      visit(voxel + strides[a]);
    }
  }
}

/// Visits every line of voxels along an axis: visit(first voxel, stride).
template <typename Visit> void forLines(const Grid& grid, int axis, const Visit& visit)
{
  const std::size_t stride = stridesOf(grid)[axis];
  const int inner = axis == 0 ? 1 : 0;
  const int outer = axis == 2 ? 1 : 2;
  Index3 at{ 0, 0, 0 };
  for (at[outer] = 0; at[outer] < grid.size[outer]; ++at[outer])
  {
    for (at[inner] = 0; at[inner] < grid.size[inner]; ++at[inner])
    {
      visit(grid.at(at[0], at[1], at[2]), stride);
    }
  }
}

}
