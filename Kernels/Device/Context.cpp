#include "Context.h"

#include "Error.h"
#include "KernelSources.h"

#include <algorithm>
#include <mutex>
#include <sstream>

namespace chainmail
{

namespace
{

std::string megabytes(std::size_t bytes)
{
  std::ostringstream text;
  text << (bytes + (1u << 20) - 1) / (1u << 20) << " MiB";
  return text.str();
}

/// The text of a kernel file with its headers in place of its #include lines. Compiler messages still name file and
/// line.
std::string expanded(const std::string& file)
{
  std::istringstream lines(detail::kernelSource(file));
  std::ostringstream text;
  int number = -1; // line 0 is the #line directive
  for (std::string line; std::getline(lines, line);)
  {
    ++number;
    const std::string include = "#include \"";
    if (line.compare(0, include.size(), include) == 0)
    {
      const std::string header = line.substr(include.size(), line.find('"', include.size()) - include.size());
      text << expanded(header) << "#line " << number + 1 << " \"" << file << "\"\n";
    }
    else
    {
      text << line << '\n';
    }
  }
  return text.str();
}

/// Names everything that a driver's compiled program depends on.
std::string programKey(const cl::Device& device, const std::string& options, const std::string& source)
{
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  std::string key;
  for (const std::string& part : { platform.getInfo<CL_PLATFORM_NAME>(), platform.getInfo<CL_PLATFORM_VERSION>(),
         device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DEVICE_VENDOR>(), device.getInfo<CL_DEVICE_VERSION>(),
         device.getInfo<CL_DRIVER_VERSION>(), options, source })
  {
    key += part + '\n';
  }
  return key;
}

/// The driver's compiled program for this one device; empty where the driver does not hand it out.
std::string binaryOf(const cl::Program& program)
{
  try
  {
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    return binaries.empty() ? std::string() : std::string(binaries.front().begin(), binaries.front().end());
  }
  catch (const cl::Error&)
  {
    return {};
  }
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
  static std::map<cl_device_id, std::shared_ptr<Context>> contexts;
  const cl::Device device = findDevice(deviceName);
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<Context>& context = contexts[device()];
  if (!context)
  {
    context = std::make_shared<Context>(device);
  }
  return context;
}

Context::Context(const cl::Device& device)
  : device_(device)
  , info_(describe(device))
  , context_(device)
  , queue_(context_, device)
  , cache_(ProgramCache::userFolder())
{
}

const cl::Program& Context::program(const std::string& file, const std::string& defines)
{
  // Simulations in several threads share this. While one of them builds a program, the others wait.
  const std::lock_guard<std::mutex> lock(this->programsMutex_);
  const std::string key = file + ' ' + defines;
  const auto known = this->programs_.find(key);
  if (known != this->programs_.end())
  {
    return known->second;
  }
  return this->programs_.emplace(key, this->build(file, "-cl-std=CL1.2 " + defines)).first->second;
}

cl::Program Context::build(const std::string& file, const std::string& options)
{
  const std::vector<cl::Device> devices{ this->device_ };
  const std::string source = expanded(file);
  const std::string key = programKey(this->device_, options, source);
  const std::string kept = this->cache_.find(key);
  if (!kept.empty())
  {
    try
    {
      cl::Program program(this->context_, devices, { { kept.begin(), kept.end() } });
      program.build(devices, options.c_str());
      return program;
    }
    catch (const cl::Error&) // the driver no longer accepts it
    {
    }
  }
  cl::Program program(this->context_, source);
  try
  {
    program.build(devices, options.c_str());
  }
  catch (const cl::Error& error)
  {
    throw DeviceError(std::string("OpenCL call ") + error.what() + " failed with " + errorName(error.err()) + " for " +
                      file + " on \"" + this->info_.name +
                      "\": " + program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(this->device_));
  }
  this->cache_.keep(key, [&] { return binaryOf(program); });
  return program;
}

cl::Kernel Context::kernel(const std::string& file, const std::string& defines, const char* name)
{
  return cl::Kernel(this->program(file, defines), name);
}

void Context::enqueue(const cl::Kernel& kernel, std::size_t groups, std::size_t items)
{
  if (groups > 0)
  {
    this->queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(groups * items), cl::NDRange(items));
  }
}

void Context::count(cl::Buffer& buffer, std::size_t bytes)
{
  using Share = std::pair<std::shared_ptr<BytesInUse>, std::size_t>;
  auto share = std::make_unique<Share>(this->inUse_, bytes);
  try
  {
    buffer.setDestructorCallback(
      [](cl_mem, void* data)
      {
        const std::unique_ptr<Share> gone(static_cast<Share*>(data));
        gone->first->now -= gone->second;
      },
      share.get());
  }
  catch (const cl::Error&)
  {
    return; // a driver that does not tell when a buffer is gone, such as Wine's: what it holds is not counted
  }
  share.release();
  const std::size_t now = this->inUse_->now += bytes;
  this->inUse_->most = std::max(this->inUse_->most.load(), now);
}

std::size_t Context::takePeakBytes()
{
  return this->inUse_->most.exchange(this->inUse_->now);
}

cl::Buffer Context::allocate(std::size_t bytes, const char* purpose)
{
  const auto fail = [&](const std::string& room)
  {
    throw MemoryError(
      "The device \"" + this->info_.name + "\" has too little memory: " + purpose + " needs " + megabytes(bytes) +
      ", " + room + " Crop the scan or resample it to fewer voxels, pull less tissue, or choose " + "another device.");
  };
  if (bytes > this->info_.maxAllocation)
  {
    fail("its largest single buffer is " + megabytes(this->info_.maxAllocation) + " (of " +
         megabytes(this->info_.globalMemory) + " in all).");
  }
  try
  {
    cl::Buffer buffer(this->context_, CL_MEM_READ_WRITE, bytes);
    this->count(buffer, bytes);
    this->queue_.enqueueFillBuffer(buffer, cl_uchar(0), 0, bytes);
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
