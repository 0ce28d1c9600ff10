// SPDX-License-Identifier: BSD-3-Clause
// Double buffering for an array that every update makes anew, of zeros but for a part.

#ifndef ZeroedBuffers_h
#define ZeroedBuffers_h

#include "LentMemory.h"

#include <array>
#include <cstddef>
#include <memory>

class vtkDataArray;

namespace vtkChainMail
{

/// Arrays take turns in two buffers. Pages of memory that an array has written are kept for the next one, because a
/// system takes long to provide new ones, and a virtual machine longer. Pages that were never written take no memory.
class ZeroedBuffers
{
public:
  /// Lends `bytes` bytes of zeros to the array. They are zeros whatever anybody has written to the memory since it was
  /// lent before. Throws std::bad_alloc.
  void Lend(vtkDataArray* array, std::size_t bytes);

  /// Pages of the buffer lent last that hold only zeros go back to the system. To be called when the array is written.
  void Trim();

  /// Lets go of the buffers. Arrays keep theirs.
  void Forget();

private:
  std::array<std::unique_ptr<LentMemory>, 2> Buffers; // the second one was lent last
};

}

#endif
