// SPDX-License-Identifier: BSD-3-Clause
// Whether data are the same as before, told by their contents: an upstream filter that runs again gives equal values in
// a new array, and an array that is written to stays the same object.

#ifndef Fingerprint_h
#define Fingerprint_h

#include "vtkDataArray.h"
#include "vtkType.h"

#include <cstddef>

namespace vtkChainMail
{

using Fingerprint = vtkTypeUInt64;

/// 64 bits that stand for the contents of memory: different contents have the same ones with a chance of 2^-64. For
/// this process's own use: they depend on the order of bytes in a word.
Fingerprint FingerprintOf(const void* data, std::size_t bytes, Fingerprint before = 0);

/// Those of all values of an array, its type and its number of components; 0 for null.
Fingerprint FingerprintOf(vtkDataArray* array);

}

#endif
