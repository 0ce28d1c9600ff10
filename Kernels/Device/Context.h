#pragma once

// Private to the engine: its use of OpenCL. Public headers never include this file.

#include "ArgumentList.h"
#include "Device.h"
#include "Pages.h"
#include "Programs.h"
#include "Staging.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace chainmail
{

struct FoundDevice
{
  cl::Device device;
  DeviceInfo info;
};

/// The device itself, chosen as chooseDevice() does.
FoundDevice findDevice(const std::string& name);

/// The symbolic name of an OpenCL error code.
const char* errorName(cl_int code);

/// Runs `body` and rethrows an OpenCL exception as a DeviceError or MemoryError.
template <typename Body> auto translated(Body&& body) -> decltype(body());

[[noreturn]] void throwTranslated(const cl::Error& error);

/// A kernel, and its program if that is one of Programs.
class Kernel
{
public:
  Kernel(const cl::Kernel& handle) // NOLINT(google-explicit-constructor): a kernel of any other program will do
    : handle_(handle)
  {
  }

private:
  friend class Context;
  Kernel(const std::shared_ptr<Program>& program, const char* name)
    : handle_(program->get(), name)
    , program_(program)
    , name_(name)
  {
  }

  cl::Kernel handle_;
  std::shared_ptr<Program> program_;
  const char* name_ = "";
};

/// A device with its context, an in-order queue and the programs built for it so far. There is one per device and
/// process, shared by simulations in several threads. So any thread may call any of its functions at any time.
class Context
{
public:
  static std::shared_ptr<Context> of(const std::string& deviceName);

  explicit Context(const FoundDevice& found);

  const DeviceInfo& info() const { return this->info_; }
  const cl::Device& device() const { return this->device_; }
  cl::CommandQueue& queue() { return this->queue_; }

  /// A kernel of one .cl file with the given -D options. On first use its program is built or taken from the user's
  /// cache.
  Kernel kernel(const std::string& file, const std::string& defines, const char* name);

  /// Runs a kernel with `groups` work-groups of `items` work-items each. First sets the given arguments (see
  /// ArgumentList); if there are none, the kernel keeps the earlier ones.
  template <typename... Arguments>
  void launch(Kernel kernel, std::size_t groups, std::size_t items, const Arguments&... arguments)
  {
    ArgumentList(kernel.handle_).add(arguments...);
    this->enqueue(kernel, groups, items);
  }
  /// Runs a kernel over `count` items. `count` becomes the kernel's last argument, because the range is rounded up to
  /// whole work-groups. All groups have the same size, because PoCL builds a kernel anew for every other size.
  template <typename... Arguments>
  void launchOver(const Kernel& kernel, std::size_t count, const Arguments&... arguments)
  {
    this->launch(kernel, groupsOver(count), itemsOver, arguments..., static_cast<cl_uint>(count));
  }
  static constexpr std::size_t itemsOver = 64;
  static constexpr std::size_t groupsOver(std::size_t count) { return (count + itemsOver - 1) / itemsOver; }

  /// A device buffer, filled with zeros. Throws MemoryError, whose message names `purpose`, where the device has no
  /// room.
  cl::Buffer allocate(std::size_t bytes, const char* purpose) { return this->allocate(bytes, purpose, bytes); }
  /// The same with zeros only in the first bytes, `zeros` of them (at least 1). The caller writes to the others before
  /// anything reads them.
  cl::Buffer allocate(std::size_t bytes, const char* purpose, std::size_t zeros);

  /// Marks these bytes as undefined. With CHAINMAIL_POISON_BUFFERS in the environment they become 0x41, so tests find
  /// reads of bytes that nothing has written.
  void poison(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes);

  /// The peak of the bytes in buffers since the last call of this function.
  std::size_t takePeakBytes();

  template <typename T> cl::Buffer upload(const std::vector<T>& values, const char* purpose)
  {
    cl::Buffer buffer = this->allocate(sizeof(T) * std::max<std::size_t>(1, values.size()), purpose, 1);
    this->write(buffer, 0, values);
    return buffer;
  }
  /// Writes values at an offset [bytes]. The caller may change them as soon as this returns.
  template <typename T> void write(const cl::Buffer& buffer, std::size_t offset, const std::vector<T>& values)
  {
    this->write(buffer, offset, values.data(), values.size());
  }
  template <typename T> void write(const cl::Buffer& buffer, std::size_t offset, const T* values, std::size_t count)
  {
    if (count > 0)
    {
      this->writeBytes(buffer, offset, reinterpret_cast<const char*>(values), sizeof(T) * count);
    }
  }
  template <typename T> void read(const cl::Buffer& buffer, std::vector<T>& values)
  {
    if (!values.empty())
    {
      this->read(buffer, sizeof(T) * values.size(), values.data());
    }
  }

  using HostBytes = std::unique_ptr<char, std::function<void(char*)>>;

  /// Some of a buffer's current values for the host to read, for the lifetime of this object. If the device shares the
  /// host's memory, nothing is copied.
  template <typename T> class View
  {
  public:
    View(Context& context, const cl::Buffer& buffer, std::size_t first, std::size_t count)
      : values_(context.view(buffer, sizeof(T) * first, sizeof(T) * count))
    {
    }
    const T* get() const { return reinterpret_cast<const T*>(this->values_.get()); }

  private:
    HostBytes values_;
  };

private:
  /// A copy of values that the device may not have read yet.
  using Copy = std::vector<char>;

  void writeBytes(const cl::Buffer& buffer, std::size_t offset, const char* values, std::size_t bytes);
  void read(const cl::Buffer& buffer, std::size_t bytes, void* values);
  void letCopiesGo(const std::function<void()>& wait);
  HostBytes view(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes);
  void unmap(const cl::Buffer& buffer, void* values) noexcept;
  void enqueue(const Kernel& kernel, std::size_t groups, std::size_t items);
  struct PooledAllocation;
  void endWith(cl::Buffer& buffer, std::unique_ptr<PooledAllocation>& lease);
  cl::Buffer inPages(std::size_t bytes, std::size_t zeros);

  cl::Device device_;
  DeviceInfo info_;
  cl::Context context_;
  cl::CommandQueue queue_;
  Staging staging_;
  Programs programs_;
  bool poisons_ = std::getenv("CHAINMAIL_POISON_BUFFERS") != nullptr;

  struct BytesInUse
  {
    std::atomic<std::size_t> now{ 0 };
    std::atomic<std::size_t> most{ 0 };
  };
  std::shared_ptr<BytesInUse> inUse_ = std::make_shared<BytesInUse>(); ///< shared with buffers, which may outlive this
  std::shared_ptr<Pages> pages_ = std::make_shared<Pages>();           ///< likewise

  std::mutex copiesMutex_;
  std::vector<Copy> copies_;
  std::size_t bytesOfCopies_ = 0;
};

/// A small buffer that keeps its memory between uses and grows as needed. Its content is undefined at the beginning of
/// each use.
class Scratch
{
public:
  explicit Scratch(const char* purpose)
    : purpose_(purpose)
  {
  }

  cl::Buffer& sized(Context& context, std::size_t bytes)
  {
    if (bytes > this->bytes_)
    {
      this->buffer_ = cl::Buffer();
      this->bytes_ = bytes + std::min(bytes / 2, std::size_t(1) << 22);
      this->buffer_ = context.allocate(this->bytes_, this->purpose_, 1);
    }
    context.poison(this->buffer_, 0, bytes);
    return this->buffer_;
  }
  template <typename T> cl::Buffer& holding(Context& context, const std::vector<T>& values)
  {
    cl::Buffer& buffer = this->sized(context, sizeof(T) * values.size());
    context.write(buffer, 0, values);
    return buffer;
  }
  const cl::Buffer& get() const { return this->buffer_; }
  std::size_t bytes() const { return this->bytes_; }
  /// Frees the memory if it is more than `most` bytes.
  void trim(std::size_t most)
  {
    if (this->bytes_ > most)
    {
      this->buffer_ = cl::Buffer();
      this->bytes_ = 0;
    }
  }

private:
  const char* purpose_;
  std::size_t bytes_ = 0;
  cl::Buffer buffer_;
};

template <typename Body> auto translated(Body&& body) -> decltype(body())
{
  try
  {
    return body();
  }
  catch (const cl::Error& error)
  {
    throwTranslated(error);
  }
}

}
