// SPDX-License-Identifier: BSD-3-Clause
// The voxels of the input and of the padded output.

#ifndef Grids_h
#define Grids_h

#include "Model.h"

#include "vtkType.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace vtkChainMail
{

/// Whether a voxel may have this index. Behind the last one there has to be a next integer, at which loops end.
inline bool IsIndex(std::int64_t index)
{
  return index > std::numeric_limits<int>::min() && index < std::numeric_limits<int>::max();
}

/// Whether the extent of an image with `padding` more voxels on every side can be told in integers, and has no more
/// voxels than can be handled. Axes with a single voxel are not padded.
inline bool PaddingFits(const std::array<int, 6>& extent, int padding)
{
  chainmail::Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    std::int64_t first = extent[2 * a];
    std::int64_t last = extent[2 * a + 1];
    first -= last > first ? padding : 0;
    last += last > extent[2 * a] ? padding : 0;
    const std::int64_t size = last - first + 1;
    if (!IsIndex(first) || !IsIndex(last) || !IsIndex(size))
    {
      return false;
    }
    grid.size[a] = static_cast<int>(std::max<std::int64_t>(size, 0));
  }
  return grid.fits();
}

/// The most padding that fits, up to `wanted`.
inline int FittingPadding(const std::array<int, 6>& extent, int wanted)
{
  while (wanted > 0 && !PaddingFits(extent, wanted))
  {
    --wanted;
  }
  return wanted;
}

/// The input's grid and the padded grid of the output. Indices are those of the input, from 0, so output voxels in the
/// padding have a negative index or one beyond the size.
struct Grids
{
  std::array<int, 3> Size;
  std::array<int, 3> Padding;

  bool IsPadded() const { return this->Padding != std::array<int, 3>{ { 0, 0, 0 } }; }
  vtkIdType InputVoxels() const { return static_cast<vtkIdType>(this->Size[0]) * this->Size[1] * this->Size[2]; }
  vtkIdType OutputWidth(int axis) const { return this->Size[axis] + 2 * static_cast<vtkIdType>(this->Padding[axis]); }
  vtkIdType OutputVoxels() const { return this->OutputWidth(0) * this->OutputWidth(1) * this->OutputWidth(2); }
  /// The same for the cells between the voxels.
  Grids Cells() const
  {
    Grids cells = *this;
    for (int& width : cells.Size)
    {
      width = std::max(width - 1, 1);
    }
    return cells;
  }
  vtkIdType InputId(int i, int j, int k) const
  {
    return i + this->Size[0] * (j + this->Size[1] * static_cast<vtkIdType>(k));
  }
  bool IsInput(const std::array<int, 3>& voxel) const
  {
    bool is = true;
    for (int a = 0; a < 3; ++a)
    {
      is = is && voxel[a] >= 0 && voxel[a] < this->Size[a];
    }
    return is;
  }
  vtkIdType OutputId(int i, int j, int k) const
  {
    return (i + this->Padding[0]) +
           this->OutputWidth(0) * ((j + this->Padding[1]) + this->OutputWidth(1) * (k + this->Padding[2]));
  }
};

}

#endif
