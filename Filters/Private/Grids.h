// SPDX-License-Identifier: BSD-3-Clause
// The voxels of the input and of the padded output.

#ifndef Grids_h
#define Grids_h

#include "Model.h"

#include "vtkType.h"

#include <algorithm>
#include <array>

namespace vtkChainMail
{

/// The size of an image with `padding` more voxels on every side. Axes with a single voxel are not padded.
inline chainmail::Grid Padded(const std::array<int, 3>& size, int padding)
{
  chainmail::Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = size[a] + (size[a] > 1 ? 2 * padding : 0);
  }
  return grid;
}

/// The most padding, up to `wanted`, with which the image has no more voxels than can be handled.
inline int FittingPadding(const std::array<int, 3>& size, int wanted)
{
  while (wanted > 0 && !Padded(size, wanted).fits())
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
