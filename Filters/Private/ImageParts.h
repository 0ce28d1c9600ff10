// SPDX-License-Identifier: BSD-3-Clause
// An image of which several processes have parts.

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

/// Empty for null.
Extent ExtentOf(vtkImageData* image);

/// Puts parts of an image together. Where they overlap they hold the same, but for voxels that one marks as ghosts, of
/// which it may hold an old copy. Throws InputError where they do not fit together or leave something out.
vtkSmartPointer<vtkImageData> PutTogether(const std::vector<vtkSmartPointer<vtkImageData>>& parts, const Extent& whole);

}

#endif
