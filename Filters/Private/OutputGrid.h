// SPDX-License-Identifier: BSD-3-Clause
// Which voxels the deformed image has: the properties OutputPadding, OutputMagnification and OutputBounds.

#ifndef OutputGrid_h
#define OutputGrid_h

#include "Properties.h"

#include "Types.h"

#include "vtkImageData.h"

#include <array>

namespace vtkChainMail
{

struct OutputGrid
{
  chainmail::Index3 Padding{};
  chainmail::OutputDetail Detail;

  /// Only the geometry of `image` is read. Throws InputError, whose message names the property, where such an output is
  /// impossible.
  OutputGrid(const Properties& properties, vtkImageData* image);

  /// The extent and the spacing of the deformed image.
  std::array<int, 6> ExtentOf(vtkImageData* image) const;
  std::array<double, 3> SpacingOf(vtkImageData* image) const;
};

/// Throws InputError where the arrays of this part of the deformed image, and `more` bytes for each voxel, do not fit
/// into the free main memory.
void RequireMemory(const OutputGrid& grid, vtkImageData* image, const std::array<int, 6>& extent, std::size_t more);

}

#endif
