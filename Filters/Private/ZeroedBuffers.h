// SPDX-License-Identifier: BSD-3-Clause
// Double buffering for an array that every update makes anew, of zeros but for a part.

#ifndef ZeroedBuffers_h
#define ZeroedBuffers_h

#include "LentMemory.h"

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

class vtkDataArray;

namespace vtkChainMail
{

/// Arrays take turns in two buffers. Pages of memory that an array has written are kept for the next ones, because a
/// system takes long to provide new ones, and a virtual machine longer. Pages that the next four arrays of a
/// buffer have not written go back to the system. Pages that were never written take no memory.
class ZeroedBuffers
{
public:
  /// Lends `bytes` bytes of zeros to the array. They are zeros whatever anybody has written to the memory since it was
  /// lent before. Throws std::bad_alloc.
  void Lend(vtkDataArray* array, std::size_t bytes);

  /// To be called when the array that was lent last is written: pages that are not needed go back to the system.
  void Trim();

  /// Lets go of the buffers. Arrays keep theirs.
  void Forget();

private:
  struct Buffer
  {
    std::unique_ptr<LentMemory> Memory;
    std::vector<unsigned char> IdleFor; // of each page in memory, how many arrays it has not been needed for
  };

  std::array<Buffer, 2> Buffers; // the second one was lent last
};

}

#endif
