// SPDX-License-Identifier: BSD-3-Clause
// Memory that is lent to arrays. It is used again when no array refers to it any more.

#ifndef LentMemory_h
#define LentMemory_h

#include "vtkDataArray.h"

#include <cstddef>
#include <memory>
#include <utility>

namespace vtkChainMail
{

class LentMemory
{
public:
  /// Undefined content. Throws std::bad_alloc.
  explicit LentMemory(std::size_t bytes);

  /// Takes over `memory`, which has so many bytes.
  LentMemory(std::shared_ptr<char> memory, std::size_t bytes)
    : Memory(std::move(memory))
    , Bytes(bytes)
  {
  }

  char* GetData() const { return this->Memory.get(); }
  std::size_t GetSize() const { return this->Bytes; }

  /// Whether no array refers to the memory any more.
  bool IsFree() const;

  /// Lends all of the memory to an array, until this array and all arrays that share its values are deleted.
  void Lend(vtkDataArray* array) const;

private:
  static void GiveBack(void* memory);

  std::shared_ptr<char> Memory;
  std::size_t Bytes;
};

}

#endif
