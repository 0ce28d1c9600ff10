// SPDX-License-Identifier: BSD-3-Clause
#include "LentMemory.h"

#include "vtkAbstractArray.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>

namespace vtkChainMail
{

namespace
{

/// The memory that is lent to arrays.
struct Lent
{
  std::mutex Mutex;
  std::map<void*, std::shared_ptr<char>> Memory;

  // Never deleted: an array may outlive all static objects.
  static Lent& Get()
  {
    static Lent* const lent = new Lent;
    return *lent;
  }
};

}

LentMemory::LentMemory(std::size_t bytes)
  : Memory(static_cast<char*>(std::malloc(std::max<std::size_t>(bytes, 1))), std::free)
  , Bytes(bytes)
{
  if (!this->Memory)
  {
    throw std::bad_alloc();
  }
}

bool LentMemory::IsFree() const
{
  Lent& lent = Lent::Get();
  const std::lock_guard<std::mutex> lock(lent.Mutex);
  return lent.Memory.count(this->GetData()) == 0;
}

void LentMemory::Lend(vtkDataArray* array) const
{
  Lent& lent = Lent::Get();
  {
    const std::lock_guard<std::mutex> lock(lent.Mutex);
    lent.Memory[this->GetData()] = this->Memory;
  }
  const auto values = static_cast<vtkIdType>(this->Bytes / static_cast<std::size_t>(array->GetDataTypeSize()));
  array->SetVoidArray(this->GetData(), values, 0, vtkAbstractArray::VTK_DATA_ARRAY_USER_DEFINED);
  array->SetArrayFreeFunction(&LentMemory::GiveBack);
}

void LentMemory::GiveBack(void* memory)
{
  Lent& lent = Lent::Get();
  std::shared_ptr<char> last; // destroyed after the lock is released
  const std::lock_guard<std::mutex> lock(lent.Mutex);
  const auto found = lent.Memory.find(memory);
  if (found != lent.Memory.end())
  {
    last = std::move(found->second);
    lent.Memory.erase(found);
  }
}

}
