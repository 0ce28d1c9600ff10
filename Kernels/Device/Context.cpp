#include "Context.h"

#include "Error.h"
#include "Notices.h"
#include "Pocl.h"
#include "PoclCache.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <mutex>
#include <sstream>
#include <thread>

namespace chainmail
{

namespace
{

/// Smaller buffers of a processor are allocated by its driver.
constexpr std::size_t fewestBytesOfPages = std::size_t(1) << 20;

/// Up to this size [bytes] a write goes through a copy. Waiting until the device has read a few values would take
/// longer than all else. For more values a copy saves nothing.
constexpr std::size_t mostBytesCopied = std::size_t(1) << 17;

/// OpenCL does not promise that a polled event ever becomes complete. After this time the host waits for the event, and
/// stops reporting that something is being compiled.
constexpr std::chrono::minutes longestAsking(2);

/// Copies live until something waits for the queue. With more bytes of copies than this, write() itself waits for it.
constexpr std::size_t mostBytesOfCopies = std::size_t(1) << 23;

std::string megabytes(std::size_t bytes)
{
  std::ostringstream text;
  text << (bytes + (1u << 20) - 1) / (1u << 20) << " MiB";
  return text.str();
}

}

const char* errorName(cl_int code)
{
  switch (code)
  {
#define CHAINMAIL_NAME(name)                                                                                           \
  case name:                                                                                                           \
    return #name
    CHAINMAIL_NAME(CL_DEVICE_NOT_FOUND);
    CHAINMAIL_NAME(CL_DEVICE_NOT_AVAILABLE);
    CHAINMAIL_NAME(CL_COMPILER_NOT_AVAILABLE);
    CHAINMAIL_NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE);
    CHAINMAIL_NAME(CL_OUT_OF_RESOURCES);
    CHAINMAIL_NAME(CL_OUT_OF_HOST_MEMORY);
    CHAINMAIL_NAME(CL_BUILD_PROGRAM_FAILURE);
    CHAINMAIL_NAME(CL_INVALID_VALUE);
    CHAINMAIL_NAME(CL_INVALID_DEVICE);
    CHAINMAIL_NAME(CL_INVALID_CONTEXT);
    CHAINMAIL_NAME(CL_INVALID_COMMAND_QUEUE);
    CHAINMAIL_NAME(CL_INVALID_MEM_OBJECT);
    CHAINMAIL_NAME(CL_INVALID_BUILD_OPTIONS);
    CHAINMAIL_NAME(CL_INVALID_PROGRAM);
    CHAINMAIL_NAME(CL_INVALID_PROGRAM_EXECUTABLE);
    CHAINMAIL_NAME(CL_INVALID_KERNEL_NAME);
    CHAINMAIL_NAME(CL_INVALID_KERNEL);
    CHAINMAIL_NAME(CL_INVALID_ARG_INDEX);
    CHAINMAIL_NAME(CL_INVALID_ARG_VALUE);
    CHAINMAIL_NAME(CL_INVALID_ARG_SIZE);
    CHAINMAIL_NAME(CL_INVALID_KERNEL_ARGS);
    CHAINMAIL_NAME(CL_INVALID_WORK_DIMENSION);
    CHAINMAIL_NAME(CL_INVALID_WORK_GROUP_SIZE);
    CHAINMAIL_NAME(CL_INVALID_WORK_ITEM_SIZE);
    CHAINMAIL_NAME(CL_INVALID_GLOBAL_OFFSET);
    CHAINMAIL_NAME(CL_INVALID_EVENT_WAIT_LIST);
    CHAINMAIL_NAME(CL_INVALID_OPERATION);
    CHAINMAIL_NAME(CL_INVALID_BUFFER_SIZE);
    CHAINMAIL_NAME(CL_INVALID_GLOBAL_WORK_SIZE);
#undef CHAINMAIL_NAME
  case -1001:
    return "CL_PLATFORM_NOT_FOUND_KHR";
  default:
    return "unknown error";
  }
}

void throwTranslated(const cl::Error& error)
{
  const std::string text = std::string("OpenCL call ") + error.what() + " failed with " + errorName(error.err()) +
                           " (" + std::to_string(error.err()) + ").";
  switch (error.err())
  {
  case CL_MEM_OBJECT_ALLOCATION_FAILURE:
  case CL_OUT_OF_RESOURCES:
  case CL_OUT_OF_HOST_MEMORY:
  case CL_INVALID_BUFFER_SIZE:
    throw MemoryError(text + " The device has too little free memory for this scene: close other programs that use it, "
                             "crop the scan, or choose another device.");
  default:
    throw DeviceError(text);
  }
}

std::shared_ptr<Context> Context::of(const std::string& deviceName)
{
  static std::mutex mutex;
  // Never destroyed: the driver may end before static objects do, or this process may be a fork of the driver's.
  static auto& contexts = *new std::map<cl_device_id, std::shared_ptr<Context>>;
  const FoundDevice found = findDevice(deviceName);
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<Context>& context = contexts[found.device()];
  if (!context)
  {
    context = std::make_shared<Context>(found);
    if (found.info.endsLoops())
    {
      giveNotice(
        "\"" + found.info.name +
        "\" ends loops of kernels early, without an error, so tissue that is stretched over very many voxels may "
        "look wrong. Use another Device, such as PoCL (Debian and Ubuntu: apt-get install pocl-opencl-icd).");
    }
  }
  return context;
}

Context::Context(const FoundDevice& found)
  : device_(found.device)
  , info_(found.info)
  , context_(device_)
  , queue_(context_, device_)
  , staging_(context_, queue_)
  , programs_(device_, context_)
{
}

Kernel Context::kernel(const std::string& file, const std::string& defines, const char* name)
{
  return Kernel(this->programs_.program(file, defines), name);
}

void Context::writeBytes(const cl::Buffer& buffer, std::size_t offset, const char* values, std::size_t bytes)
{
  if (bytes > mostBytesCopied)
  {
    this->queue_.enqueueWriteBuffer(buffer, CL_TRUE, offset, bytes, values);
    return;
  }
  Copy copy(values, values + bytes);
  this->queue_.enqueueWriteBuffer(buffer, CL_FALSE, offset, bytes, copy.data());
  bool areTooMany = false;
  {
    const std::lock_guard<std::mutex> lock(this->copiesMutex_);
    this->bytesOfCopies_ += bytes;
    areTooMany = this->bytesOfCopies_ > mostBytesOfCopies;
    this->copies_.push_back(std::move(copy));
  }
  if (areTooMany)
  {
    this->letCopiesGo([this] { this->queue_.finish(); });
  }
}

void Context::read(const cl::Buffer& buffer, std::size_t bytes, void* values)
{
  this->letCopiesGo([&] { this->queue_.enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, values); });
}

/// Frees the copies that were made so far, once `wait` has waited for the queue.
void Context::letCopiesGo(const std::function<void()>& wait)
{
  std::vector<Copy> copies;
  {
    const std::lock_guard<std::mutex> lock(this->copiesMutex_);
    copies.swap(this->copies_);
    this->bytesOfCopies_ = 0;
  }
  try
  {
    wait();
  }
  catch (...)
  {
    // It is unknown whether the device has read them.
    const std::lock_guard<std::mutex> lock(this->copiesMutex_);
    std::move(copies.begin(), copies.end(), std::back_inserter(this->copies_));
    throw;
  }
}

/// Maps the bytes. Where that would copy them, into memory that must first be allocated and locked, they are copied to
/// memory that is kept for this.
Context::HostBytes Context::view(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes)
{
  if (!this->info_.sharesMemory)
  {
    if (Staging::Memory copy = this->staging_.take(bytes))
    {
      this->queue_.enqueueReadBuffer(buffer, CL_TRUE, offset, bytes, copy.get());
      const Staging::GiveBack giveBack = copy.get_deleter();
      return { copy.release(), giveBack };
    }
  }
  char* const mapped = static_cast<char*>(this->queue_.enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ, offset, bytes));
  return { mapped, [this, buffer](char* values) { this->unmap(buffer, values); } };
}

void Context::unmap(const cl::Buffer& buffer, void* values) noexcept
{
  try
  {
    this->queue_.enqueueUnmapMemObject(buffer, values);
  }
  catch (const cl::Error&)
  {
    // The next call that uses the buffer fails, too, and reports the error.
  }
}

void Context::enqueue(const Kernel& kernel, std::size_t groups, std::size_t items)
{
  if (groups == 0)
  {
    return;
  }
  const cl::NDRange all(groups * items);
  const cl::NDRange group(items);
  if (!kernel.program_ || kernel.program_->wasLaunched(kernel.name_, items))
  {
    this->queue_.enqueueNDRangeKernel(kernel.handle_, cl::NullRange, all, group);
    return;
  }
  const bool pocl = isPocl(this->device_);
  if (pocl)
  {
    requirePoclCache();
  }
  cl::Event event;
  try
  {
    this->queue_.enqueueNDRangeKernel(kernel.handle_, cl::NullRange, all, group, nullptr, &event);
    this->queue_.flush();
  }
  catch (const cl::Error&)
  {
    if (pocl)
    {
      requirePoclCache(); // the folder may be the cause
    }
    throw;
  }
  try
  {
    const auto latest = std::chrono::steady_clock::now() + longestAsking;
    WhileCompiling::wait(
      [&](std::chrono::microseconds time)
      {
        std::this_thread::sleep_for(std::min(time, std::chrono::microseconds(5000)));
        return event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() <= CL_COMPLETE ||
               std::chrono::steady_clock::now() > latest;
      });
    if (event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE)
    {
      event.wait();
    }
  }
  catch (...)
  {
    this->queue_.finish(); // until then the device may read memory that the caller frees
    throw;
  }
  // PoCL reports a kernel that it could not compile as launched, and then skips it.
  const cl_int status = event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>();
  if (status < CL_COMPLETE)
  {
    this->queue_.finish();
    if (pocl)
    {
      requirePoclCache();
    }
    throw DeviceError("The device " + this->info_.name + " could not compile or run the kernel " + kernel.name_ + " (" +
                      errorName(status) + ", " + std::to_string(status) +
                      "), perhaps because another program changed its compiled files at the same time. Try again.");
  }
  kernel.program_->noteLaunch(kernel.name_, items);
}

/// What lives as long as a buffer: its share of the bytes in use, and its memory if that comes from Pages.
struct Context::PooledAllocation
{
  std::shared_ptr<BytesInUse> inUse;
  std::size_t bytes;
  Pages::Memory memory;
};

/// Ends a lease together with its buffer. Some drivers, such as Wine's, do not notify of the end of a buffer. Then the
/// lease stays with the caller, and the buffer's bytes are not counted.
void Context::endWith(cl::Buffer& buffer, std::unique_ptr<PooledAllocation>& lease)
{
  try
  {
    buffer.setDestructorCallback(
      [](cl_mem, void* data)
      {
        const std::unique_ptr<PooledAllocation> ended(static_cast<PooledAllocation*>(data));
        ended->inUse->now -= ended->bytes;
      },
      lease.get());
  }
  catch (const cl::Error&)
  {
    return;
  }
  const std::size_t now = this->inUse_->now += lease->bytes;
  this->inUse_->most = std::max(this->inUse_->most.load(), now);
  lease.release();
}

/// A buffer in memory from Pages, whose first `zeros` bytes are zeros. Empty if the device is a GPU, the buffer is
/// small, Pages does not support the system, or the driver does not notify of the buffer's end. Throws if the system
/// has no memory left: PoCL would end the process.
cl::Buffer Context::inPages(std::size_t bytes, std::size_t zeros)
{
  if (!Pages::areKnown || this->info_.gpu || bytes < fewestBytesOfPages)
  {
    return {};
  }
  const bool isWhole = zeros == bytes;
  auto lease = std::make_unique<PooledAllocation>(
    PooledAllocation{ this->inUse_, bytes, Pages::take(this->pages_, bytes, isWhole) });
  char* const memory = lease->memory.get();
  if (!memory)
  {
    throw cl::Error(CL_MEM_OBJECT_ALLOCATION_FAILURE, "mmap");
  }
  if (!isWhole)
  {
    std::fill_n(memory, zeros, char(0));
  }
  cl::Buffer buffer(this->context_, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory);
  this->endWith(buffer, lease);
  return lease ? cl::Buffer() : buffer;
}

void Context::poison(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes)
{
  if (this->poisons_ && bytes > 0)
  {
    this->queue_.enqueueFillBuffer(buffer, cl_uchar(0x41), offset, bytes);
  }
}

std::size_t Context::takePeakBytes()
{
  return this->inUse_->most.exchange(this->inUse_->now);
}

cl::Buffer Context::allocate(std::size_t bytes, const char* purpose, std::size_t zeros)
{
  const auto fail = [&](const std::string& room)
  {
    throw MemoryError("The device \"" + this->info_.name + "\" has too little memory for " + purpose + ": needed are " +
                      megabytes(bytes) + ", " + room +
                      " Crop the scan or resample it to fewer voxels, pull less tissue, or choose " +
                      "another device.");
  };
  if (bytes > this->info_.maxAllocation)
  {
    fail("its largest single buffer is " + megabytes(this->info_.maxAllocation) + " (of " +
         megabytes(this->info_.globalMemory) + " in all).");
  }
  try
  {
    if (cl::Buffer buffer = this->inPages(bytes, zeros); buffer())
    {
      this->poison(buffer, zeros, bytes - zeros);
      return buffer;
    }
    cl::Buffer buffer(this->context_, CL_MEM_READ_WRITE, bytes);
    auto lease = std::make_unique<PooledAllocation>(PooledAllocation{ this->inUse_, bytes, nullptr });
    this->endWith(buffer, lease);
    // Many devices notice only at the first write that they have no room.
    this->queue_.enqueueFillBuffer(buffer, cl_uchar(0), 0, zeros);
    this->poison(buffer, zeros, bytes - zeros);
    this->queue_.finish();
    return buffer;
  }
  catch (const cl::Error& error)
  {
    fail(
      "of " + megabytes(this->info_.globalMemory) + " in all (" + error.what() + ": " + errorName(error.err()) + ").");
    throw;
  }
}

}
