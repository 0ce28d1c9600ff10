#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>

namespace chainmail
{

/// Memory of the process for the buffers of a device that is a processor, in pages of 2 MB, as far as the system has
/// them: fields are read brick by brick, from all over, and few of their many small pages would be known to a processor
/// at a time. New pages hold zeros and take no room until somebody writes there.
///
/// Buffers that begin with zeros have new pages, which go back to the system with them; a heap would keep what lies
/// below other memory in use. Buffers that begin with anything come and go with each update. Their pages are kept for
/// the next ones of this kind, since a system takes long to hand out new ones, and a virtual machine longer. With what
/// is kept such buffers, and all buffers, never have more than they once had, and no more is kept than twice what is in
/// use, so nothing when the last buffer is gone. May be called from any thread.
class Pages
{
public:
  struct GiveBack
  {
    std::shared_ptr<Pages> pages;
    std::size_t bytes;
    bool zeros; ///< as asked for
    void operator()(char* memory) const { this->pages->give(memory, this->bytes, this->zeros); }
  };
  using Memory = std::unique_ptr<char, GiveBack>;

  /// Whether it is known how this system hands out pages.
#ifdef __linux__
  static constexpr bool areKnown = true;
#else
  static constexpr bool areKnown = false;
#endif

  /// Memory from the beginning of a page on, which holds zeros, or anything. Null where the system has none.
  static Memory take(const std::shared_ptr<Pages>& pages, std::size_t bytes, bool zeros);

  /// Bytes that no buffer has.
  std::size_t kept() const;

  Pages() = default;
  ~Pages();
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

private:
  using Ranges = std::map<char*, std::size_t>; ///< bytes by where they begin, of which no two touch

  char* takeKept(std::size_t bytes);
  void give(char* memory, std::size_t bytes, bool zeros);
  void keep(char* memory, std::size_t bytes);
  std::size_t mostKept() const;
  void trim(std::size_t most);

  mutable std::mutex mutex_;
  Ranges kept_;
  std::size_t keptBytes_ = 0;
  std::size_t inUse_ = 0;
  std::size_t mostInUse_ = 0;
  std::size_t passing_ = 0; ///< what buffers have of it that come and go
  std::size_t mostPassing_ = 0;
};

}
