// SPDX-License-Identifier: BSD-3-Clause
// The interface of samplers, each of which samples one point array of an image at displaced places.

#ifndef ArraySampler_h
#define ArraySampler_h

#include "Types.h"

#include "vtkAbstractArray.h"
#include "vtkDataArray.h"
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

/// Values of voxels that are not at their own place in the output: those of tissue that moves into it from elsewhere.
struct FarValues
{
  vtkSmartPointer<vtkDataArray> Array; // null where there are none
  chainmail::VoxelBox Box;
  TissueTest IsTissue; // for numbers of voxels in this array
};

/// Numbers that stand for "not measured": those up to Low and those from High on. Not to be confused with the voxels
/// that OutputPadding adds.
struct PaddingValues
{
  double Low = -std::numeric_limits<double>::infinity();
  double High = std::numeric_limits<double>::infinity();

  bool AreThere() const { return std::isfinite(this->Low) || std::isfinite(this->High); }
  bool Has(double value) const { return std::isfinite(value) && (value <= this->Low || value >= this->High); }
  bool operator==(const PaddingValues& other) const { return this->Low == other.Low && this->High == other.High; }
};

/// Whether the offset of a voxel is 0: it did not change. False for NaN.
inline bool isAtRest(const float* offset)
{
  return offset[0] == 0.0f && offset[1] == 0.0f && offset[2] == 0.0f;
}

/// Makes one output array from one input array, again in every update as long as the input array does not change.
class ArraySampler
{
public:
  virtual ~ArraySampler() = default;

  /// Begins an update. Returns the number of the resampling from which its buffer continues: Sample() needs all boxes
  /// that changed since. 0: all boxes.
  virtual std::uint64_t Begin() = 0;

  /// Writes the values of the boxes, which do not overlap.
  virtual void Sample(const std::vector<chainmail::ResampledBox>& boxes) = 0;

  /// Ends the update, which is a resampling of this number. Returns the output array: the input array itself where
  /// everything is at rest and the grids are equal.
  virtual vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool atRest) = 0;
};

}

#endif
