#pragma once

#include "ArgumentList.h"

#include <condition_variable>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

namespace chainmail
{

/// Builds programs in the background, several at once, in threads that end when there is no more to do.
///
/// There is one set of them in a process. It is made after the drivers were loaded and so ends before they do: a
/// process that ends while programs are built waits for those that have begun and drops the others.
class Builds
{
public:
  using Build = std::packaged_task<cl::Program()>;

  static Builds& ofProcess();

  ~Builds();

  /// Begins this build as soon as a thread is free for it. Where the system gives no thread, it is done at once.
  void add(const std::shared_ptr<Build>& build);

  /// Returns when all builds have been done.
  void finish();

  /// Takes this build before all others that have not begun, since somebody waits for it.
  void hurry(const std::shared_ptr<Build>& build);

private:
  Builds() = default;
  void work();

  std::mutex mutex_;
  std::condition_variable ended_; ///< a thread has
  std::list<std::shared_ptr<Build>> waiting_;
  std::list<std::thread> threads_;
  std::size_t working_ = 0; ///< threads that still take builds
};

}
