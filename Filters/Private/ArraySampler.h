// SPDX-License-Identifier: BSD-3-Clause
// What samples one point array of an image at displaced places.

#ifndef ArraySampler_h
#define ArraySampler_h

#include "Types.h"

#include "vtkAbstractArray.h"
#include "vtkSmartPointer.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace vtkChainMail
{

/// Tells whether a voxel of the input is tissue at rest. May be called from several threads.
using TissueTest = std::function<bool(vtkIdType)>;

/// Numbers that stand for "not measured": those up to Low and those from High on. Not to be mixed up with the voxels
/// that OutputPadding adds.
struct PaddingValues
{
  double Low = -std::numeric_limits<double>::infinity();
  double High = std::numeric_limits<double>::infinity();

  bool AreThere() const { return std::isfinite(this->Low) || std::isfinite(this->High); }
  bool Has(double value) const { return std::isfinite(value) && (value <= this->Low || value >= this->High); }
  bool operator==(const PaddingValues& other) const { return this->Low == other.Low && this->High == other.High; }
};

/// Whether an offset says that a voxel did not change. NaN does not.
inline bool isAtRest(const float* offset)
{
  return offset[0] == 0.0f && offset[1] == 0.0f && offset[2] == 0.0f;
}

/// Makes one array of the output from one of the input, which stays as it is, update after update.
class ArraySampler
{
public:
  virtual ~ArraySampler() = default;

  /// Begins an update. Returns the number of the resampling since which it needs the changes; 0 for all.
  virtual std::uint64_t Begin() = 0;

  /// Writes the values of the boxes, which do not overlap.
  virtual void Sample(const std::vector<chainmail::ResampledBox>& boxes) = 0;

  /// Ends the update, which is a resampling of this number. Returns the output's array: the input's own one where all
  /// is at rest and there is no padding.
  virtual vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool atRest) = 0;
};

}

#endif
