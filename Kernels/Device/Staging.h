#pragma once

// Private to the engine, like Context.h.

#include "Programs.h"

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace chainmail
{

/// Host memory to which a device with a memory of its own copies at full speed, because its pages are locked. Locking
/// takes longer than a copy, so blocks are kept for the next copies. May be called from any thread.
class Staging
{
public:
  /// All blocks together take no more than this [bytes]. The offsets and coverages of a batch of resampling take half.
  static constexpr std::size_t most = std::size_t(1) << 27;

  struct Block
  {
    cl::Buffer buffer;
    char* memory = nullptr; ///< mapped as long as the block exists
    std::size_t bytes = 0;
  };
  struct GiveBack
  {
    Staging* staging;
    Block block;
    void operator()(char*) const { this->staging->give(this->block); }
  };
  using Memory = std::unique_ptr<char, GiveBack>;

  Staging(const cl::Context& context, const cl::CommandQueue& queue)
    : context_(context)
    , queue_(queue)
  {
  }

  /// Memory with undefined content. Null if too much is in use, or if the driver has none left.
  Memory take(std::size_t bytes);

  /// The bytes of all blocks, in use and kept.
  std::size_t bytes() const;

private:
  Block make(std::size_t bytes);
  void give(const Block& block);

  cl::Context context_;
  cl::CommandQueue queue_;
  mutable std::mutex mutex_;
  std::vector<Block> kept_; ///< smallest first
  std::size_t bytes_ = 0;
};

}
