// SPDX-License-Identifier: BSD-3-Clause
#include "ZeroedBuffers.h"

#include "Threads.h"

#include "vtkDataArray.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace vtkChainMail
{

namespace
{

/// So many arrays of a buffer, one after the other, may leave a page unused before it goes back to the system.
constexpr unsigned char mostIdle = 3;

#ifdef __linux__

constexpr bool pagesAreKnown = true;

std::size_t sizeOfPage()
{
  static const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return size;
}

std::shared_ptr<char> newPages(std::size_t bytes)
{
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED)
  {
    throw std::bad_alloc();
  }
  return { static_cast<char*>(memory), [bytes](char* begin) { munmap(begin, bytes); } };
}

bool isZero(const char* page, std::size_t size)
{
  std::uint64_t first = 0;
  std::memcpy(&first, page, sizeof(first));
  return first == 0 && std::memcmp(page, page + sizeof(first), size - sizeof(first)) == 0;
}

/// Where a page is.
enum class Place
{
  Memory,
  Nowhere, ///< it was never written
  Disk     ///< or, where the system does not tell, nowhere
};

/// The system's table of the pages of this process (pagemap in the manual of Linux).
class PageTable
{
public:
  PageTable() = default;
  PageTable(const PageTable&) = delete;
  PageTable& operator=(const PageTable&) = delete;
  ~PageTable()
  {
    if (this->File >= 0)
    {
      close(this->File);
    }
  }

  /// The places of `count` pages from an address on.
  std::vector<Place> PlacesOf(char* begin, std::size_t count) const
  {
    std::vector<Place> places(count, Place::Memory);
    std::vector<std::uint64_t> entries(count);
    const std::size_t bytes = count * sizeof(entries[0]);
    const auto first = reinterpret_cast<std::uintptr_t>(begin) / sizeOfPage() * sizeof(entries[0]);
    if (this->File >= 0 &&
        pread(this->File, entries.data(), bytes, static_cast<off_t>(first)) == static_cast<ssize_t>(bytes))
    {
      std::transform(entries.begin(), entries.end(), places.begin(),
        [](std::uint64_t entry) {
          return entry >> 63 & 1 ? Place::Memory : entry >> 62 & 1 ? Place::Disk : Place::Nowhere;
        });
      return places;
    }
    std::vector<unsigned char> isThere(count, 1);
    mincore(begin, count * sizeOfPage(), isThere.data()); // where it fails, pages count as being there
    std::transform(isThere.begin(), isThere.end(), places.begin(),
      [](unsigned char there) { return there & 1 ? Place::Memory : Place::Disk; });
    return places;
  }

private:
  int File = open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
};

/// Calls visit(page, end, place) for runs of pages of the buffer that are in the same place, from several threads.
template <typename Visit> void forRunsOfPages(const LentMemory& buffer, const Visit& visit)
{
  const std::size_t size = sizeOfPage();
  const std::size_t portion = size << 10;
  const std::size_t whole = (buffer.GetSize() + size - 1) / size * size;
  const PageTable table;
  chainmail::inParallel((whole + portion - 1) / portion,
    [&](std::size_t n)
    {
      char* const begin = buffer.GetData() + n * portion;
      const std::size_t pages = std::min(portion, whole - n * portion) / size;
      const std::vector<Place> places = table.PlacesOf(begin, pages);
      for (std::size_t first = 0, last = 0; first < pages; first = last)
      {
        while (last < pages && places[last] == places[first])
        {
          ++last;
        }
        visit(begin + first * size, begin + last * size, places[first]);
      }
    });
}

/// The system provides zeros when these pages are used again.
void dropPages(char* first, char* end)
{
  if (first != end)
  {
    madvise(first, static_cast<std::size_t>(end - first), MADV_DONTNEED);
  }
}

/// Pages that may be on a disk are dropped. Pages that were never written are zeros as they are. To drop each of the
/// many runs of them between rows of moved tissue, too, would take long: where threads do so at the same time, the
/// system interrupts all cores for each of them.
void makeZero(const LentMemory& buffer)
{
  const std::size_t size = sizeOfPage();
  forRunsOfPages(buffer,
    [size](char* first, char* end, Place place)
    {
      if (place == Place::Disk)
      {
        dropPages(first, end);
      }
      for (char* page = first; place == Place::Memory && page != end; page += size)
      {
        if (!isZero(page, size)) // who reads pages that were never written has one page of zeros for all of them
        {
          std::memset(page, 0, size);
        }
      }
    });
}

void dropIdlePages(const LentMemory& buffer, std::vector<unsigned char>& idleFor)
{
  const std::size_t size = sizeOfPage();
  idleFor.resize((buffer.GetSize() + size - 1) / size, 0);
  forRunsOfPages(buffer,
    [&](char* first, char* end, Place place)
    {
      unsigned char* idle = idleFor.data() + static_cast<std::size_t>(first - buffer.GetData()) / size;
      if (place != Place::Memory)
      {
        std::fill_n(idle, static_cast<std::size_t>(end - first) / size, static_cast<unsigned char>(0));
        return;
      }
      char* dropped = first; // begin of a run of pages to drop
      for (char* page = first; page != end; page += size, ++idle)
      {
        *idle = isZero(page, size) ? static_cast<unsigned char>(*idle + 1) : 0;
        if (*idle > mostIdle)
        {
          *idle = 0;
        }
        else
        {
          dropPages(dropped, page);
          dropped = page + size;
        }
      }
      dropPages(dropped, end);
    });
}

#else

constexpr bool pagesAreKnown = false;

std::shared_ptr<char> newPages(std::size_t bytes)
{
  std::shared_ptr<char> memory(static_cast<char*>(std::calloc(bytes, 1)), std::free);
  if (!memory)
  {
    throw std::bad_alloc();
  }
  return memory;
}

void makeZero(const LentMemory&)
{
}

void dropIdlePages(const LentMemory&, std::vector<unsigned char>&)
{
}

#endif

}

void ZeroedBuffers::Lend(vtkDataArray* array, std::size_t bytes)
{
  Buffer& buffer = this->Buffers[0];
  if (pagesAreKnown && buffer.Memory && buffer.Memory->GetSize() == bytes && buffer.Memory->IsFree())
  {
    makeZero(*buffer.Memory);
  }
  else
  {
    buffer = Buffer();
    buffer.Memory = std::make_unique<LentMemory>(newPages(std::max<std::size_t>(bytes, 1)), bytes);
  }
  buffer.Memory->Lend(array);
  std::swap(this->Buffers[0], this->Buffers[1]);
}

void ZeroedBuffers::Trim()
{
  Buffer& last = this->Buffers[1];
  if (last.Memory)
  {
    dropIdlePages(*last.Memory, last.IdleFor);
  }
}

void ZeroedBuffers::Forget()
{
  this->Buffers = {};
}

}
