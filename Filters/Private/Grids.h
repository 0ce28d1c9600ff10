// SPDX-License-Identifier: BSD-3-Clause
// The voxels of the input and of the padded output.

#ifndef Grids_h
#define Grids_h

#include "Model.h"
#include "Types.h"

#include "vtkType.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <tuple>

namespace vtkChainMail
{

/// Whether a voxel may have this index. The next integer has to exist, too, because loops end there.
inline bool IsIndex(std::int64_t index)
{
  return index > std::numeric_limits<int>::min() && index < std::numeric_limits<int>::max();
}

/// Whether the extent of an image with `padding` more voxels on every side fits into integers, and its number of voxels
/// into the engine's limit. Axes with a single voxel are not padded.
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

/// The largest padding that fits, at most `wanted`.
inline int FittingPadding(const std::array<int, 6>& extent, int wanted)
{
  while (wanted > 0 && !PaddingFits(extent, wanted))
  {
    --wanted;
  }
  return wanted;
}

/// The grids of the input and of the output, which may be padded, be a part of the input, and be finer. Indices of both
/// count from the input's first voxel. Output voxel Finer * i has the position of input voxel i. A process may hold
/// only a box of the input, in which all voxels lie that its output shows.
struct Grids
{
  std::array<int, 3> Size;  // of the input
  chainmail::VoxelBox Held; // the voxels of the input that this process has
  std::array<int, 3> First; // lowest voxel of the output
  std::array<int, 3> Width; // size of the output
  int Finer = 1;
  bool AreCells = false; // the grids are those of cells, not of voxels

  Grids(const chainmail::Index3& size, const chainmail::VoxelBox& held, const chainmail::Index3& padding,
    const chainmail::OutputDetail& detail)
    : Size(size)
    , Held(held)
    , Finer(detail.finer)
  {
    for (int a = 0; a < 3; ++a)
    {
      const int first = std::max(-padding[a], detail.first[a]);
      const int last = std::min(size[a] - 1 + padding[a], detail.last[a]);
      this->First[a] = detail.finer * first;
      this->Width[a] = detail.finer * (last - first) + 1;
    }
  }

  bool operator==(const Grids& other) const
  {
    const auto all = [](const Grids& g)
    { return std::tie(g.Size, g.Held.first, g.Held.size, g.First, g.Width, g.Finer, g.AreCells); };
    return all(*this) == all(other);
  }

  /// Whether the output has the voxels of the input that this process has, and no others.
  bool AreAlike() const
  {
    return this->Finer == 1 && this->Width == this->Held.size && this->First == this->Held.first;
  }
  /// Whether all output voxels are within the input.
  bool IsWithinInput() const
  {
    const std::array<int, 3> last{ { this->First[0] + this->Width[0] - 1, this->First[1] + this->Width[1] - 1,
      this->First[2] + this->Width[2] - 1 } };
    return this->IsInput(this->First) && this->IsInput(last);
  }
  vtkIdType InputVoxels() const { return static_cast<vtkIdType>(this->Held.voxels()); }
  vtkIdType OutputVoxels() const { return static_cast<vtkIdType>(this->Width[0]) * this->Width[1] * this->Width[2]; }
  /// The same for the cells between the voxels.
  Grids Cells() const
  {
    Grids cells = *this;
    for (int a = 0; a < 3; ++a)
    {
      cells.Size[a] = std::max(cells.Size[a] - 1, 1);
      cells.Held.size[a] = std::max(cells.Held.size[a] - 1, 1);
      cells.Width[a] = std::max(cells.Width[a] - 1, 1);
    }
    cells.AreCells = true;
    return cells;
  }
  vtkIdType InputId(int i, int j, int k) const { return static_cast<vtkIdType>(this->Held.at(i, j, k)); }
  /// The voxel of the input that is nearest to an index along an axis, among those that this process has.
  double Inside(double index, int axis) const
  {
    const double first = this->Held.first[axis];
    return std::min(std::max(index, first), first + this->Held.size[axis] - 1);
  }
  vtkIdType OutputId(int i, int j, int k) const
  {
    return (i - this->First[0]) +
           this->Width[0] * ((j - this->First[1]) + this->Width[1] * static_cast<vtkIdType>(k - this->First[2]));
  }

  /// The position of an output index along an axis, in input indices.
  double PlaceOf(int index) const
  {
    const double place = this->Finer == 1 ? index : (this->AreCells ? index + 0.5 : index) / this->Finer;
    return this->AreCells && this->Finer > 1 ? place - 0.5 : place;
  }
  /// Whether an output voxel has the position of an input voxel.
  bool IsOnInput(const std::array<int, 3>& voxel) const
  {
    return this->Finer == 1 || (voxel[0] % this->Finer == 0 && voxel[1] % this->Finer == 0 &&
                                 voxel[2] % this->Finer == 0 && !this->AreCells);
  }
  /// Whether an output voxel lies within the input.
  bool IsInput(const std::array<int, 3>& voxel) const
  {
    bool is = true;
    for (int a = 0; a < 3; ++a)
    {
      const int last = this->AreCells ? this->Finer * this->Size[a] - 1 : this->Finer * (this->Size[a] - 1);
      is = is && voxel[a] >= 0 && voxel[a] <= last;
    }
    return is;
  }
  /// Calls f(voxel, count) for each row along x in slice k that has output voxels within the input, with the first of
  /// these and their number.
  template <typename F> void ForRows(int k, const F& f) const
  {
    const int low = std::max(this->First[0], 0);
    int high = this->First[0] + this->Width[0] - 1;
    while (high >= low && !this->IsInput({ { high, 0, 0 } }))
    {
      --high;
    }
    for (int j = this->First[1]; j < this->First[1] + this->Width[1] && low <= high; ++j)
    {
      if (this->IsInput({ { low, j, k } }))
      {
        f(std::array<int, 3>{ { low, j, k } }, high - low + 1);
      }
    }
  }
};

}

#endif
