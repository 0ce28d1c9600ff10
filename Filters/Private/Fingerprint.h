// SPDX-License-Identifier: BSD-3-Clause
// Compares data by their contents (hashes). Addresses do not suffice: an upstream filter that runs again gives equal
// values in a new array, and an array that is written to stays the same object.

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

/// A 64-bit hash of memory: different contents have the same hash with a probability of 2^-64. It depends on the byte
/// order, so it is not portable between machines.
Fingerprint FingerprintOf(const void* data, std::size_t bytes, Fingerprint before = 0);

/// Another such hash, computed in this thread alone: for parts of something large.
Fingerprint FingerprintOfPart(const char* data, std::size_t bytes);

/// The fingerprint of an array's values, type and number of components; 0 for null.
Fingerprint FingerprintOf(vtkDataArray* array);

/// An array that is compared by its contents.
struct ArrayContents
{
  vtkSmartPointer<vtkDataArray> Array;
  vtkMTimeType Time = 0;
  Fingerprint Values = 0;

  /// `imageTime`: when the image was last modified, because some programs write voxels in place and modify the image
  /// alone. An array that is in `before` with the same times is not read again.
  void Take(vtkDataArray* array, vtkMTimeType imageTime, const ArrayContents& before)
  {
    this->Array = array;
    this->Time = std::max(array->GetMTime(), imageTime);
    this->Values = array == before.Array && this->Time == before.Time ? before.Values : FingerprintOf(array);
  }

  bool operator==(const ArrayContents& other) const { return this->Values == other.Values; }
};

/// An array that outputs share from update to update, as long as its version is current and nobody has written to it. A
/// filter downstream may write to it unnoticed, so its contents are compared.
template <typename ArrayType> class SharedArray
{
public:
  void Set(const vtkSmartPointer<ArrayType>& array, int version)
  {
    this->Array = array;
    this->Version = version;
    this->Values = FingerprintOf(array);
  }
  void Forget() { this->Array = nullptr; }
  bool IsIntact(int version) const
  {
    return this->Array && this->Version == version && FingerprintOf(this->Array) == this->Values;
  }
  ArrayType* Get() const { return this->Array; }

private:
  vtkSmartPointer<ArrayType> Array;
  int Version = 0;
  Fingerprint Values = 0;
};

}

#endif
