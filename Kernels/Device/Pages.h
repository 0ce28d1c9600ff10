#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>

namespace chainmail
{

/// Host memory for the buffers of processors, in huge pages of 2 MB where the system provides them. Fields are read
/// brick by brick, all over memory. With small pages a processor's translation buffer (TLB) would hold too few of them.
/// New pages are zero and take no memory until the first write.
///
/// Buffers of zeros get new pages, which return to the system with the buffer. (A heap would keep freed memory below
/// other memory in use.) Buffers with undefined content are temporary: they come and go with each update. Their pages
/// are kept for the next temporary buffers, because a system takes long to provide new ones, and a virtual machine
/// longer. Where no kept range is large enough, pages of smaller ones are moved together. Kept bytes are at most twice
/// the bytes in use, so none remain after the last buffer. Kept and used bytes together never exceed the peak of the
/// used ones, both for temporary buffers and for all. May be called from any thread.
class Pages
{
public:
  struct GiveBack
  {
    std::shared_ptr<Pages> pages;
    std::size_t bytes;
    bool zeros; ///< as requested in take()
    void operator()(char* memory) const { this->pages->give(memory, this->bytes, this->zeros); }
  };
  using Memory = std::unique_ptr<char, GiveBack>;

  /// Whether allocation in huge pages is implemented for this system.
#ifdef __linux__
  static constexpr bool areKnown = true;
#else
  static constexpr bool areKnown = false;
#endif

  /// Memory from the beginning of a page on, filled with zeros or with undefined content. Null if the system has none
  /// left.
  static Memory take(const std::shared_ptr<Pages>& pages, std::size_t bytes, bool zeros);

  /// The bytes kept for later buffers.
  std::size_t kept() const;

  Pages() = default;
  ~Pages();
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

private:
  using Ranges = std::map<char*, std::size_t>; ///< sizes [bytes] by address; no two ranges are adjacent

  char* takeKept(std::size_t bytes);
  char* gatherKept(std::size_t bytes);
  Ranges::iterator smallestKept();
  void shorten(Ranges::iterator range, std::size_t bytes);
  void give(char* memory, std::size_t bytes, bool zeros);
  void keep(char* memory, std::size_t bytes);
  std::size_t mostKept() const;
  void trim(std::size_t most);

  mutable std::mutex mutex_;
  Ranges kept_;
  std::size_t keptBytes_ = 0;
  std::size_t inUse_ = 0;
  std::size_t mostInUse_ = 0;
  std::size_t passing_ = 0; ///< share of inUse_ that temporary buffers have
  std::size_t mostPassing_ = 0;
};

}
