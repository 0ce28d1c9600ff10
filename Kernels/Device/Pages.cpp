#include "Pages.h"

#include <algorithm>
#include <cstdint>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace chainmail
{

namespace
{

constexpr std::size_t pageSize = std::size_t(1) << 21;

std::size_t wholePages(std::size_t bytes)
{
  return (bytes + pageSize - 1) / pageSize * pageSize;
}

#ifdef __linux__

char* fromSystem(std::size_t bytes)
{
  void* const mapped = mmap(nullptr, bytes + pageSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED)
  {
    return nullptr;
  }
  char* const begin = static_cast<char*>(mapped);
  const std::size_t past = reinterpret_cast<std::uintptr_t>(begin) % pageSize;
  const std::size_t before = past == 0 ? 0 : pageSize - past;
  if (before > 0)
  {
    munmap(begin, before);
  }
  munmap(begin + before + bytes, pageSize - before);
  madvise(begin + before, bytes, MADV_HUGEPAGE);
  return begin + before;
}

void toSystem(char* memory, std::size_t bytes)
{
  munmap(memory, bytes);
}

/// Moves a page to the address of another one, which goes back to the system. Returns false where the system refuses:
/// then both stay.
bool movePage(char* from, char* to)
{
  if (mremap(from, pageSize, pageSize, MREMAP_MAYMOVE | MREMAP_FIXED, to) != MAP_FAILED)
  {
    return true;
  }
  // A system without memory may have let go of the other page.
  mmap(to, pageSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
  return false;
}

#else

char* fromSystem(std::size_t)
{
  return nullptr;
}

void toSystem(char*, std::size_t)
{
}

bool movePage(char*, char*)
{
  return false;
}

#endif

}

Pages::~Pages()
{
  this->trim(0);
}

Pages::Memory Pages::take(const std::shared_ptr<Pages>& pages, std::size_t bytes, bool zeros)
{
  const std::size_t whole = wholePages(bytes);
  const std::lock_guard<std::mutex> lock(pages->mutex_);
  char* memory = zeros ? nullptr : pages->takeKept(whole);
  if (!memory)
  {
    memory = fromSystem(whole);
  }
  if (!memory)
  {
    pages->trim(0);
    memory = fromSystem(whole);
  }
  if (memory)
  {
    pages->inUse_ += whole;
    pages->passing_ += zeros ? 0 : whole;
    pages->mostInUse_ = std::max(pages->mostInUse_, pages->inUse_);
    pages->mostPassing_ = std::max(pages->mostPassing_, pages->passing_);
    pages->trim(pages->mostKept());
  }
  return Memory(memory, GiveBack{ pages, whole, zeros });
}

std::size_t Pages::kept() const
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  return this->keptBytes_;
}

/// Takes from the smallest kept range that is large enough (best fit), or gathers smaller ones. Null if nothing is
/// kept.
char* Pages::takeKept(std::size_t bytes)
{
  auto best = this->kept_.end();
  for (auto range = this->kept_.begin(); range != this->kept_.end(); ++range)
  {
    if (range->second >= bytes && (best == this->kept_.end() || range->second < best->second))
    {
      best = range;
    }
  }
  if (best == this->kept_.end())
  {
    return this->gatherKept(bytes);
  }
  char* const memory = best->first;
  const std::size_t left = best->second - bytes;
  this->kept_.erase(best);
  if (left > 0)
  {
    this->kept_[memory + bytes] = left;
  }
  this->keptBytes_ -= bytes;
  return memory;
}

/// Moves kept pages to a new range of addresses, those of the smallest ranges first, so large ones stay whole. Pages
/// that are missing are new. Null if nothing is kept.
char* Pages::gatherKept(std::size_t bytes)
{
  char* const begin = this->kept_.empty() ? nullptr : fromSystem(bytes);
  for (char* page = begin; begin && page != begin + bytes && !this->kept_.empty(); page += pageSize)
  {
    const auto smallest = this->smallestKept();
    if (!movePage(smallest->first + smallest->second - pageSize, page))
    {
      break;
    }
    this->shorten(smallest, pageSize);
  }
  return begin;
}

Pages::Ranges::iterator Pages::smallestKept()
{
  return std::min_element(this->kept_.begin(), this->kept_.end(),
    [](const Ranges::value_type& a, const Ranges::value_type& b) { return a.second < b.second; });
}

/// Removes the last `bytes` bytes of a kept range.
void Pages::shorten(Ranges::iterator range, std::size_t bytes)
{
  range->second -= bytes;
  this->keptBytes_ -= bytes;
  if (range->second == 0)
  {
    this->kept_.erase(range);
  }
}

void Pages::give(char* memory, std::size_t bytes, bool zeros)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  this->inUse_ -= bytes;
  if (zeros)
  {
    toSystem(memory, bytes);
  }
  else
  {
    this->passing_ -= bytes;
    this->keep(memory, bytes);
  }
  if (this->inUse_ == 0)
  {
    this->mostInUse_ = this->mostPassing_ = 0;
  }
  this->trim(this->mostKept());
}

void Pages::keep(char* memory, std::size_t bytes)
{
  this->keptBytes_ += bytes;
  auto next = this->kept_.lower_bound(memory);
  if (next != this->kept_.end() && memory + bytes == next->first)
  {
    bytes += next->second;
    next = this->kept_.erase(next);
  }
  if (next != this->kept_.begin() && std::prev(next)->first + std::prev(next)->second == memory)
  {
    std::prev(next)->second += bytes;
    return;
  }
  this->kept_[memory] = bytes;
}

std::size_t Pages::mostKept() const
{
  // Between updates the displacement and the constraint are in use. During an update its temporary buffers may take
  // twice as much: the states before a wave and before a relaxation, and the bounds of displacements.
  return std::min({ 2 * this->inUse_, this->mostInUse_ - this->inUse_, this->mostPassing_ - this->passing_ });
}

/// Returns kept memory beyond `most` bytes to the system, from the smallest ranges first.
void Pages::trim(std::size_t most)
{
  while (this->keptBytes_ > most)
  {
    const auto smallest = this->smallestKept();
    const std::size_t goes = std::min(smallest->second, this->keptBytes_ - most);
    toSystem(smallest->first + smallest->second - goes, goes);
    this->shorten(smallest, goes);
  }
}

}
