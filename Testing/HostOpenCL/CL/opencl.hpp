#pragma once

// Stands in for Khronos' header of this name where the engine is built with CHAINMAIL_HOST_KERNELS: the part of it that
// the engine uses, with one device, on which kernels are C++ of the host's own compiler in the host's own memory. So
// sanitizers, valgrind and gcov see into them. Calls and errors are as in OpenCL; nothing runs in parallel.

#include "../Launch.h"

#include <CL/cl.h>

#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace cl
{

class Error : public std::exception
{
public:
  Error(cl_int code, const char* call)
    : code_(code)
    , call_(call)
  {
  }
  cl_int err() const { return this->code_; }
  const char* what() const noexcept override { return this->call_; }

private:
  cl_int code_;
  const char* call_;
};

class Device
{
public:
  cl_device_id operator()() const;

  template <cl_device_info Name> auto getInfo() const
  {
    if constexpr (Name == CL_DEVICE_NAME || Name == CL_DEVICE_VENDOR || Name == CL_DEVICE_VERSION ||
                  Name == CL_DRIVER_VERSION)
    {
      return std::string("Host C++");
    }
    else if constexpr (Name == CL_DEVICE_TYPE)
    {
      return cl_device_type(CL_DEVICE_TYPE_GPU); // kernels without vectors
    }
    else if constexpr (Name == CL_DEVICE_GLOBAL_MEM_SIZE)
    {
      return Device::memory();
    }
    else if constexpr (Name == CL_DEVICE_MAX_MEM_ALLOC_SIZE)
    {
      return Device::memory() / 4;
    }
    else if constexpr (Name == CL_DEVICE_PLATFORM)
    {
      return cl_platform_id(nullptr);
    }
    else
    {
      static_assert(Name == CL_DEVICE_MAX_COMPUTE_UNITS || Name == CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT ||
                      Name == CL_DEVICE_AVAILABLE || Name == CL_DEVICE_COMPILER_AVAILABLE,
        "not emulated");
      return cl_uint(1);
    }
  }

private:
  static cl_ulong memory();
};

class Platform
{
public:
  Platform() = default;
  explicit Platform(cl_platform_id) {}

  static cl_int get(std::vector<Platform>* platforms);
  cl_int getDevices(cl_device_type, std::vector<Device>* devices) const
  {
    devices->assign(1, Device());
    return CL_SUCCESS;
  }
  template <cl_platform_info Name> std::string getInfo() const
  {
    static_assert(Name == CL_PLATFORM_NAME || Name == CL_PLATFORM_VERSION, "not emulated");
    return "Host C++";
  }
};

class Context
{
public:
  explicit Context(const Device&) {}
};

class Buffer
{
public:
  struct Memory;

  Buffer() = default;
  Buffer(const Context&, cl_mem_flags flags, std::size_t bytes, void* host = nullptr);

  cl_mem operator()() const { return reinterpret_cast<cl_mem>(this->memory_.get()); }
  const std::shared_ptr<Memory>& memory() const { return this->memory_; }
  cl_int setDestructorCallback(void (*notify)(cl_mem, void*), void* data);

private:
  std::shared_ptr<Memory> memory_;
};

struct LocalSpaceArg
{
  std::size_t bytes;
};
inline LocalSpaceArg Local(std::size_t bytes)
{
  return { bytes };
}

class Program
{
public:
  struct Built;
  using Binaries = std::vector<std::vector<unsigned char>>;

  Program() = default;
  Program(const Context&, const std::string& source);
  Program(const Context&, const std::vector<Device>&, const Binaries&)
  {
    throw Error(CL_INVALID_BINARY, "clCreateProgramWithBinary"); // as it gives none away
  }

  void build(const std::vector<Device>&, const char* options);
  void compile(const char*) { throw Error(CL_INVALID_OPERATION, "clCompileProgram"); }
  template <cl_program_build_info Name> std::string getBuildInfo(const Device&) const
  {
    static_assert(Name == CL_PROGRAM_BUILD_LOG, "not emulated");
    return this->buildLog();
  }
  template <cl_program_info Name> Binaries getInfo() const
  {
    static_assert(Name == CL_PROGRAM_BINARIES, "not emulated");
    return {};
  }
  const std::shared_ptr<Built>& built() const { return this->built_; }

private:
  std::string buildLog() const;

  std::shared_ptr<Built> built_;
};

class Kernel
{
public:
  struct State;

  Kernel() = default;
  Kernel(const Program& program, const char* name);

  void setArg(cl_uint index, const Buffer& buffer);
  void setArg(cl_uint index, const LocalSpaceArg& local);
  template <typename T, typename = std::enable_if_t<std::is_trivially_copyable<T>::value>>
  void setArg(cl_uint index, const T& value)
  {
    this->setPlain(index, &value, sizeof(value));
  }
  const std::shared_ptr<State>& state() const { return this->state_; }

private:
  void setPlain(cl_uint index, const void* value, std::size_t bytes);

  std::shared_ptr<State> state_;
};

class NDRange
{
public:
  NDRange() = default;
  explicit NDRange(std::size_t size)
    : size_(size)
  {
  }
  std::size_t size() const { return this->size_; }

private:
  std::size_t size_ = 0;
};
inline const NDRange NullRange;

/// Of a command, which is complete when the call returns.
class Event
{
public:
  template <cl_event_info Name> cl_int getInfo() const
  {
    static_assert(Name == CL_EVENT_COMMAND_EXECUTION_STATUS, "not emulated");
    return CL_COMPLETE;
  }
  void wait() const {}
  void setCallback(cl_int status, void (*notify)(cl_event, cl_int, void*), void* data)
  {
    notify(nullptr, status, data);
  }
};

class CommandQueue
{
public:
  CommandQueue(const Context&, const Device&) {}

  void enqueueNDRangeKernel(const Kernel& kernel, const NDRange& offset, const NDRange& all, const NDRange& group,
    const std::vector<Event>* before = nullptr, Event* event = nullptr);
  void enqueueReadBuffer(const Buffer& buffer, cl_bool blocking, std::size_t offset, std::size_t bytes, void* to);
  void enqueueWriteBuffer(const Buffer& buffer, cl_bool blocking, std::size_t offset, std::size_t bytes,
    const void* from, const std::vector<Event>* before = nullptr, Event* event = nullptr);
  void* enqueueMapBuffer(
    const Buffer& buffer, cl_bool blocking, cl_map_flags flags, std::size_t offset, std::size_t bytes);
  void enqueueUnmapMemObject(const Buffer& buffer, void* mapped);
  void enqueueCopyBuffer(
    const Buffer& from, const Buffer& to, std::size_t fromOffset, std::size_t toOffset, std::size_t bytes);
  template <typename T> void enqueueFillBuffer(const Buffer& buffer, T pattern, std::size_t offset, std::size_t bytes)
  {
    this->fill(buffer, &pattern, sizeof(pattern), offset, bytes);
  }
  void finish() {}
  void flush() {}

private:
  void fill(const Buffer& buffer, const void* pattern, std::size_t size, std::size_t offset, std::size_t bytes);
};

}
