// SPDX-License-Identifier: BSD-3-Clause
// Which voxels the deformed image has: the filter's OutputPadding, OutputMagnification and OutputBounds.

#ifndef OutputGrid_h
#define OutputGrid_h

#include "Types.h"

#include "vtkImageData.h"

#include <array>

class vtkChainMailDeformation;

namespace vtkChainMail
{

struct OutputGrid
{
  chainmail::Index3 Padding{};
  chainmail::OutputDetail Detail;

  /// Of `image` no more is read than where its voxels are. Throws InputError, whose message names the property, where
  /// there cannot be such an output.
  OutputGrid(vtkChainMailDeformation* filter, vtkImageData* image);

  /// The extent and the spacing of the deformed image.
  std::array<int, 6> ExtentOf(vtkImageData* image) const;
  std::array<double, 3> SpacingOf(vtkImageData* image) const;
};

/// Throws InputError where the arrays of a deformed image of `image`, with `more` bytes for each voxel, do not fit into
/// the memory that is free.
void RequireMemory(const OutputGrid& grid, vtkImageData* image, std::size_t more);

}

#endif
