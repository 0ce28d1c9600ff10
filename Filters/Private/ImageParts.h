// SPDX-License-Identifier: BSD-3-Clause
// Assembles an image of which several processes have parts.

#ifndef ImageParts_h
#define ImageParts_h

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <vector>

namespace vtkChainMail
{

using Extent = std::array<int, 6>;

bool IsEmpty(const Extent& extent);
bool Contains(const Extent& outer, const Extent& inner);

/// The extent of an image; an empty one for null.
Extent ExtentOf(vtkImageData* image);

/// The part of an image with this extent, with all field data; the image itself where that is all. Empty where the
/// image has no voxel there.
vtkSmartPointer<vtkImageData> Cut(vtkImageData* image, const Extent& part);

/// Assembles the parts of an image. Overlapping parts have to hold the same values, except for voxels that a part marks
/// as ghosts, which may be outdated copies. Throws InputError where parts do not fit together or leave voxels out.
vtkSmartPointer<vtkImageData> PutTogether(const std::vector<vtkSmartPointer<vtkImageData>>& parts, const Extent& whole);

}

#endif
