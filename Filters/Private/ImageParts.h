// SPDX-License-Identifier: BSD-3-Clause
// Parts of images.

#ifndef ImageParts_h
#define ImageParts_h

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

class vtkMultiProcessStream;

namespace vtkChainMail
{

using Extent = std::array<int, 6>;

bool IsEmpty(const Extent& extent);
bool Contains(const Extent& outer, const Extent& inner);

/// The extent of an image; an empty one for null.
Extent ExtentOf(vtkImageData* image);

/// The extent that two have in common; empty where they have no voxel in common.
Extent Common(const Extent& one, const Extent& other);

vtkIdType VoxelsOf(const Extent& extent);

/// The voxels of `boxes` that are not in `extent`, as boxes that do not overlap if those do not.
std::vector<Extent> Without(const std::vector<Extent>& boxes, const Extent& extent);

/// Extent, origin, spacing and direction, from process to process.
void WriteGeometry(vtkMultiProcessStream& stream, vtkImageData* image);
void ReadGeometry(vtkMultiProcessStream& stream, vtkImageData* image);

/// Names, types and components of the point arrays, in their order.
std::string ListTypes(vtkImageData* image);

/// The bytes of a tuple of an array.
std::size_t BytesOfVoxel(vtkDataArray* array);

/// Copies the values of a box of voxels between arrays over two larger boxes.
void CopyBox(
  const char* from, const Extent& ofFrom, char* to, const Extent& ofTo, const Extent& box, std::size_t bytesOfVoxel);

/// How an image is spread over processes that have a part each.
struct Holding
{
  Extent Whole{ { 0, -1, 0, -1, 0, -1 } };
  /// For each process the voxels that it provides; each voxel is provided by one. Empty: the first process has all.
  std::vector<Extent> Owned;

  bool IsSpread() const { return !this->Owned.empty(); }
};

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
    : Whole(whole)
    , Missing{ whole }
  {
  }

  void Add(vtkImageData* part);
  /// These voxels may be missing. They get no values, and so no memory from the system.
  void LeaveOut(const Extent& extent) { this->Missing = Without(this->Missing, extent); }
  /// To be called after the last part, of which there must be one.
  vtkSmartPointer<vtkImageData> End();

private:
  void Begin(vtkImageData* first);
  void CopyRows(vtkImageData* part, const Extent& extent);
  void CopyVoxels(vtkImageData* part, const Extent& extent);

  Extent Whole;
  std::vector<Extent> Missing; // boxes of voxels that no part had yet, or only as ghosts
  vtkSmartPointer<vtkImageData> Image;
  std::vector<char> Known; // for each voxel, once a part has ghosts: what is known of it
};

}

#endif
