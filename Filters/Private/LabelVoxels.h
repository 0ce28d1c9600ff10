// SPDX-License-Identifier: BSD-3-Clause
// The voxels of labels of an image, for probes that grip bodies by their labels.

#ifndef LabelVoxels_h
#define LabelVoxels_h

#include "Fingerprint.h"

#include "Model.h"

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

namespace vtkChainMail
{

class SpreadImage;

/// Caches the voxels of labels from update to update, as long as the contents of the array do not change.
class LabelVoxels
{
public:
  struct Body
  {
    std::shared_ptr<const std::vector<std::size_t>> Voxels; ///< ascending
    Fingerprint Number = 0;                                 ///< hash of the label and its voxels
  };

  /// Finds the voxels of the labels `wanted`; one pass finds all that are not cached. `spread`: the image that the
  /// array is a part of, or null.
  void Read(const ArrayContents& labels, SpreadImage* spread, const chainmail::Grid& grid,
    const std::vector<vtkTypeInt64>& wanted);

  /// The array of the last Read().
  const ArrayContents& GetContents() const { return this->Labels; }

  /// The voxels of a label; Read() has to have found it.
  const Body& Get(vtkTypeInt64 label) const { return this->Known.at(label); }

private:
  ArrayContents Labels;
  std::map<vtkTypeInt64, Body> Known;
};

}

#endif
