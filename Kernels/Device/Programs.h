#pragma once

#include "ArgumentList.h"
#include "ProgramCache.h"

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace chainmail
{

/// The text of a kernel file with its headers in place of its #include lines. Compiler messages still name file and
/// line.
std::string sourceOf(const std::string& file);

/// A function that the calling thread calls repeatedly while it waits for the device's compiler. The innermost living
/// object of the thread applies. The function may throw, which ends the wait and leaves the compiler at work.
class WhileCompiling
{
public:
  explicit WhileCompiling(std::function<void()> report)
    : report_(std::move(report))
    , before_(current_)
  {
    current_ = this;
  }
  ~WhileCompiling() { current_ = this->before_; }
  WhileCompiling(const WhileCompiling&) = delete;
  WhileCompiling& operator=(const WhileCompiling&) = delete;

  static void report();

  /// Waits, and calls report(), until `done` returns true. Each call of `done` waits for at most the given time.
  static void wait(const std::function<bool(std::chrono::microseconds)>& done);

private:
  std::function<void()> report_;
  WhileCompiling* before_;
  static thread_local WhileCompiling* current_;
};

/// A program, with a record of its launched kernels.
class Program
{
public:
  explicit Program(const cl::Program& program)
    : program_(program)
  {
  }

  const cl::Program& get() const { return this->program_; }

  /// Whether a kernel was launched with work-groups of this size before. Some drivers compile it at the first such
  /// launch.
  bool wasLaunched(const std::string& kernel, std::size_t items);
  void noteLaunch(const std::string& kernel, std::size_t items);

private:
  cl::Program program_;
  std::mutex mutex_;
  std::set<std::pair<std::string, std::size_t>> launched_;
};

/// The programs of one device. Any thread may call any function at any time.
class Programs
{
public:
  Programs(const cl::Device& device, const cl::Context& context)
    : device_(device)
    , context_(context)
    , cache_(ProgramCache::userFolder())
  {
  }

  /// The program of one .cl file with the given -D options. On first use it is built or taken from the user's cache,
  /// while other threads wait.
  std::shared_ptr<Program> program(const std::string& file, const std::string& defines);

private:
  cl::Device device_;
  cl::Context context_;
  ProgramCache cache_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Program>> programs_;
};

}
