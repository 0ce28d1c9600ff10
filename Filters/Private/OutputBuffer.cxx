// SPDX-License-Identifier: BSD-3-Clause
#include "OutputBuffer.h"

#include "Threads.h"

#include "vtkAbstractArray.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <new>

namespace vtkChainMail
{

namespace
{

constexpr std::size_t partSize = std::size_t(1) << 18;

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

OutputBuffer::OutputBuffer(std::size_t bytes)
  : Bytes(bytes)
  , Memory(static_cast<char*>(std::malloc(std::max<std::size_t>(bytes, 1))), std::free)
  , Parts((bytes + partSize - 1) / partSize)
  , Touched(this->Parts.size(), 1)
{
  if (!this->Memory)
  {
    throw std::bad_alloc();
  }
}

bool OutputBuffer::IsFree() const
{
  Lent& lent = Lent::Get();
  const std::lock_guard<std::mutex> lock(lent.Mutex);
  return lent.Memory.count(this->GetData()) == 0;
}

std::uint64_t OutputBuffer::GetNumber()
{
  std::atomic<bool> intact{ true };
  if (this->Number != 0)
  {
    chainmail::inParallel(this->Parts.size(),
      [&](std::size_t n)
      {
        const std::size_t first = n * partSize;
        if (FingerprintOfPart(this->GetData() + first, std::min(partSize, this->Bytes - first)) != this->Parts[n])
        {
          intact = false;
        }
      });
  }
  this->Number = intact ? this->Number : 0;
  return this->Number;
}

void OutputBuffer::Touch(std::size_t first, std::size_t bytes)
{
  this->Number = 0;
  for (std::size_t n = first / partSize; n * partSize < first + bytes; ++n)
  {
    this->Touched[n] = 1;
  }
}

void OutputBuffer::Touch(
  const std::vector<chainmail::ResampledBox>& boxes, const Grids& grids, std::size_t bytesOfVoxel)
{
  for (const chainmail::ResampledBox& box : boxes)
  {
    for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
    {
      const auto first = static_cast<std::size_t>(grids.OutputId(box.first[0], box.first[1], k));
      const auto last =
        static_cast<std::size_t>(grids.OutputId(box.first[0] + box.size[0], box.first[1] + box.size[1] - 1, k));
      this->Touch(bytesOfVoxel * first, bytesOfVoxel * (last - first));
    }
  }
}

void OutputBuffer::Finish(std::uint64_t number)
{
  chainmail::inParallel(this->Parts.size(),
    [&](std::size_t n)
    {
      if (this->Touched[n])
      {
        const std::size_t first = n * partSize;
        this->Parts[n] = FingerprintOfPart(this->GetData() + first, std::min(partSize, this->Bytes - first));
        this->Touched[n] = 0;
      }
    });
  this->Number = number;
}

void OutputBuffer::Lend(vtkDataArray* array) const
{
  Lent& lent = Lent::Get();
  {
    const std::lock_guard<std::mutex> lock(lent.Mutex);
    lent.Memory[this->GetData()] = this->Memory;
  }
  const auto values = static_cast<vtkIdType>(this->Bytes / static_cast<std::size_t>(array->GetDataTypeSize()));
  array->SetVoidArray(this->GetData(), values, 0, vtkAbstractArray::VTK_DATA_ARRAY_USER_DEFINED);
  array->SetArrayFreeFunction(&OutputBuffer::GiveBack);
}

std::uint64_t OutputBuffers::Begin()
{
  this->Opened = false;
  for (const auto& buffer : this->Buffers)
  {
    if (buffer && buffer->IsFree())
    {
      this->Current = buffer.get();
      return this->Since = buffer->GetNumber();
    }
  }
  // Arrays use all buffers that there are. So Open() makes a new one, as a copy of the newer buffer if there is one.
  this->Current = nullptr;
  return this->Since = this->Buffers[1] ? this->Buffers[1]->GetNumber() : 0;
}

bool OutputBuffers::Open(std::size_t bytes)
{
  if (this->Opened)
  {
    return false;
  }
  if (!this->Current)
  {
    this->Buffers[0] = std::make_unique<OutputBuffer>(bytes);
    this->Current = this->Buffers[0].get();
    this->Current->TouchAll();
    if (this->Since != 0)
    {
      std::memcpy(this->Current->GetData(), this->Buffers[1]->GetData(), bytes);
    }
  }
  if (this->Current == this->Buffers[0].get())
  {
    std::swap(this->Buffers[0], this->Buffers[1]); // Buffers[1] is the newer one
  }
  this->Opened = true;
  if (this->Since == 0)
  {
    this->Current->TouchAll();
  }
  return this->Since == 0;
}

void OutputBuffer::GiveBack(void* memory)
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
