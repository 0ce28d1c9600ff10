// SPDX-License-Identifier: BSD-3-Clause
// What a process finds in its part of an image, for the root.

#ifndef PartSurvey_h
#define PartSurvey_h

#include "ImageParts.h"

#include "ReducedBox.h"

#include "vtkDataArray.h"

#include <vector>

namespace vtkChainMail
{

/// Whether each value of an array can be counted: whole numbers of up to 16 bits, one for each voxel.
bool IsCountable(vtkDataArray* array);

/// The values of a part of such an array, and how many voxels have each: one after the other. Empty for other arrays.
std::vector<double> CountValues(vtkDataArray* array, const Extent& ofArray, const Extent& part);

/// How elements of a reduced model are made of the voxels of an image.
struct Reduction
{
  Extent Whole;                               ///< of the image
  chainmail::Index3 Factor;                   ///< voxels of an element
  chainmail::ConstraintsOfValues Constraints; ///< of all values of tissue

  /// The elements that have all their voxels in a part of the image.
  chainmail::VoxelBox ElementsIn(const Extent& part) const;
  /// These elements, of an array that IsCountable().
  chainmail::ReducedBox Reduce(vtkDataArray* array, const Extent& ofArray, const Extent& part) const;

  std::vector<char> Pack() const;
  static Reduction Unpack(const std::vector<char>& bytes);
  static std::vector<char> Pack(const chainmail::ReducedBox& box);
  chainmail::ReducedBox Unpack(const std::vector<char>& bytes, const Extent& part) const;

private:
  chainmail::Grid GetGrid() const;
};

}

#endif
