// SPDX-License-Identifier: BSD-3-Clause
// Parts of images.

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

/// Assembles an image from its parts, one after the other. Overlapping parts have to hold the same values, except for
/// voxels that a part marks as ghosts, which may be outdated copies. The functions throw InputError where the parts do
/// not form one image.
class Assembly
{
public:
  explicit Assembly(const Extent& whole)
    : Missing{ whole }
  {
  }

  void Add(vtkImageData* part);
  /// To be called after the last part, of which there must be one.
  vtkSmartPointer<vtkImageData> End();

private:
  void Begin(vtkImageData* first);
  void CopyRows(vtkImageData* part, const Extent& extent);
  void CopyVoxels(vtkImageData* part, const Extent& extent);

  std::vector<Extent> Missing; // boxes of voxels that no part had yet, or only as ghosts
  vtkSmartPointer<vtkImageData> Image;
  std::vector<char> Known; // for each voxel, once a part has ghosts: what is known of it
};

}

#endif
