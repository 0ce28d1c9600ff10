// SPDX-License-Identifier: BSD-3-Clause
// What a process finds in its part of an image, for the root.

#ifndef PartTissue_h
#define PartTissue_h

#include "ImageParts.h"

#include "Constraints.h"

#include "vtkImageData.h"

#include <array>
#include <vector>

namespace vtkChainMail
{

/// How an image becomes tissue. Each process makes that of its own part.
struct PartTissue
{
  Extent Whole; ///< of the image
  std::array<double, 3> Spacing;
  int Scalars = 0;              ///< the number of the point array
  int Constraints = -1;         ///< the same of the ConstraintArray; -1: none
  double Threshold = 0.0;       ///< see TissueSource
  double HighPadding = 0.0;     ///< see TissueSource
  std::vector<double> Function; ///< see TissueSource
  std::vector<double> Regions;  ///< see TissueSource
  bool IsRigidAnchored = false; ///< whether rigid tissue is
  chainmail::Index3 Factor{};   ///< voxels of an element of a reduced model

  /// What a part of the image has. `own`: the image of this process, which contains the part.
  chainmail::TissueCounts Count(vtkImageData* own, const Extent& part) const;
  /// The elements that have all their voxels in it.
  chainmail::ReducedBox Reduce(vtkImageData* own, const Extent& part) const;
  chainmail::VoxelBox ElementsIn(const Extent& part) const;

  // From process to process.
  std::vector<char> Pack() const;
  static PartTissue Unpack(const std::vector<char>& bytes);
  static std::vector<char> Pack(const chainmail::TissueCounts& counts);
  static chainmail::TissueCounts UnpackCounts(const std::vector<char>& bytes);
  static std::vector<char> Pack(const chainmail::ReducedBox& box);
  chainmail::ReducedBox UnpackBox(const std::vector<char>& bytes, const Extent& part) const;

private:
  chainmail::Grid GetGrid() const;
  chainmail::VoxelBox BoxOf(const Extent& part) const;
  chainmail::ArrayView ViewOf(vtkImageData* own, int array) const;
  chainmail::Constraints ConstraintsOf(vtkImageData* own) const;
};

/// A material without the arrays.
chainmail::Material ToMaterial(
  double threshold, double highPadding, const std::vector<double>& function, const std::vector<double>& regions);

}

#endif
