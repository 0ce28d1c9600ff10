// SPDX-License-Identifier: BSD-3-Clause
#include "OutputBuffer.h"

#include "Threads.h"

#include <algorithm>
#include <atomic>
#include <cstring>

namespace vtkChainMail
{

namespace
{

constexpr std::size_t partSize = std::size_t(1) << 18;

}

OutputBuffer::OutputBuffer(std::size_t bytes)
  : Memory(bytes)
  , Parts((bytes + partSize - 1) / partSize)
  , Touched(this->Parts.size(), 1)
{
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
        if (FingerprintOfPart(this->GetData() + first, std::min(partSize, this->Memory.GetSize() - first)) !=
            this->Parts[n])
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
        this->Parts[n] = FingerprintOfPart(this->GetData() + first, std::min(partSize, this->Memory.GetSize() - first));
        this->Touched[n] = 0;
      }
    });
  this->Number = number;
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

}
