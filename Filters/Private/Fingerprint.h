// SPDX-License-Identifier: BSD-3-Clause
// Whether data are the same as before, told by their contents: an upstream filter that runs again gives equal values in
// a new array, and an array that is written to stays the same object.

#ifndef Fingerprint_h
#define Fingerprint_h

#include "vtkDataArray.h"
#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <algorithm>
#include <cstddef>

namespace vtkChainMail
{

using Fingerprint = vtkTypeUInt64;

/// 64 bits that stand for the contents of memory: different contents have the same ones with a chance of 2^-64. For
/// this process's own use: they depend on the order of bytes in a word.
Fingerprint FingerprintOf(const void* data, std::size_t bytes, Fingerprint before = 0);

/// Those of all values of an array, its type and its number of components; 0 for null.
Fingerprint FingerprintOf(vtkDataArray* array);

/// An array by its contents: an upstream filter that runs again gives the same values in another one.
struct ArrayContents
{
  vtkSmartPointer<vtkDataArray> Array;
  vtkMTimeType Time = 0;
  Fingerprint Values = 0;

  /// `imageTime`: voxels are also written in place, and then somebody says so of the image alone. What is known of the
  /// array from `before` is not looked at again.
  void Take(vtkDataArray* array, vtkMTimeType imageTime, const ArrayContents& before)
  {
    this->Array = array;
    this->Time = std::max(array->GetMTime(), imageTime);
    this->Values = array == before.Array && this->Time == before.Time ? before.Values : FingerprintOf(array);
  }

  bool operator==(const ArrayContents& other) const { return this->Values == other.Values; }
};

/// An array that outputs share from update to update, as long as nobody has written to it: what reads an output may
/// also write to it, as far as this filter can tell.
template <typename ArrayType> class SharedArray
{
public:
  void Set(const vtkSmartPointer<ArrayType>& array)
  {
    this->Array = array;
    this->Values = FingerprintOf(array);
  }
  void Forget() { this->Array = nullptr; }
  bool IsIntact() const { return this->Array && FingerprintOf(this->Array) == this->Values; }
  ArrayType* Get() const { return this->Array; }

private:
  vtkSmartPointer<ArrayType> Array;
  Fingerprint Values = 0;
};

}

#endif
