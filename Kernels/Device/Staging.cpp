#include "Staging.h"

#include <algorithm>

namespace chainmail
{

namespace
{

/// Sizes of blocks are multiples of this [bytes], so that copies of similar size share a block.
constexpr std::size_t granularity = std::size_t(1) << 22;

bool isSmaller(const Staging::Block& a, const Staging::Block& b)
{
  return a.bytes < b.bytes;
}

}

Staging::Memory Staging::take(std::size_t bytes)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  Block block;
  block.bytes = bytes;
  const auto best = std::lower_bound(this->kept_.begin(), this->kept_.end(), block, isSmaller);
  if (best != this->kept_.end())
  {
    block = *best;
    this->kept_.erase(best);
  }
  else
  {
    block = this->make((bytes + granularity - 1) / granularity * granularity);
  }
  char* const memory = block.memory;
  return Memory(memory, GiveBack{ this, std::move(block) });
}

std::size_t Staging::bytes() const
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  return this->bytes_;
}

/// A new block, for which kept ones that are too small make room. It has no memory where there is none.
Staging::Block Staging::make(std::size_t bytes)
{
  while (this->bytes_ + bytes > most && !this->kept_.empty())
  {
    this->queue_.enqueueUnmapMemObject(this->kept_.front().buffer, this->kept_.front().memory);
    this->bytes_ -= this->kept_.front().bytes;
    this->kept_.erase(this->kept_.begin());
  }
  Block block;
  if (this->bytes_ + bytes > most)
  {
    return block;
  }
  try
  {
    block.buffer = cl::Buffer(this->context_, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes);
    block.memory =
      static_cast<char*>(this->queue_.enqueueMapBuffer(block.buffer, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes));
  }
  catch (const cl::Error&)
  {
    return {}; // whoever asked does without
  }
  block.bytes = bytes;
  this->bytes_ += bytes;
  return block;
}

void Staging::give(const Block& block)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  this->kept_.insert(std::upper_bound(this->kept_.begin(), this->kept_.end(), block, isSmaller), block);
}

}
