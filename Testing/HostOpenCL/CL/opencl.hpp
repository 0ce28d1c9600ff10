#pragma once

// OpenCL on the host: kernels are compiled as C++ by the compiler of the engine and run in the memory of the process.
// So tools for C++ (sanitizers, valgrind, gcov, debuggers) work on kernels, too.
//
// With CHAINMAIL_HOST_KERNELS this header replaces Khronos' header of the same name. It has the classes and calls that
// the engine uses, with the errors of the standard. HostOpenCL.cpp is the runtime, KernelLanguage.h is OpenCL C for a
// C++ compiler, Launch.h is the interface between the two.
//
// Used by: valgrind.SmallScenes and coverage.Kernels (Testing/Checks), and by hand as in Testing/README.md.
//
// Environment variables:
//   HOST_OPENCL_FLAGS    further options of the compiler of kernels; -O1 by default
//   HOST_OPENCL_MEMORY   size of the global memory [MiB]; that of the machine by default
//   HOST_OPENCL_TRACE    a file, to which the name of every kernel that is created is appended
//
// Implemented of OpenCL 1.2:
//   - One platform with one device. Its type is GPU, because the engine's kernels for GPUs have no vectors of elements
//     (WIDTH is 1). Kernels for CPUs alone are not tested.
//   - Command queues execute each command before the call returns. Events are complete from the start.
//   - Buffers, with the checks of size and region. Their memory is not initialised.
//   - Programs from source. Of the build options only macros (-D) count.
//   - One-dimensional NDRanges without an offset.
//
// Limitations:
//   - Nothing runs in parallel: there are no races, and atomic functions are ordinary accesses.
//   - A work-group of a kernel that has barriers or local memory is a single work-item (KernelLanguage.h). So data that
//     work-items of a group exchange are not tested.
//   - Local memory is allocated once a launch. What a work-group leaves there, the next one may read without an error.
//   - Address spaces are not checked: the qualifiers mean nothing here.
//   - Of vector types there are int, uint and float with 2, 3 or 4 components. Of component orders (.yzxw) there are
//     those that kernels use.
//   - Wait lists and NDRange offsets are ignored. The calls are not thread-safe.
//   - There are no images, sub-buffers, program binaries, linked programs, profiling, or kernel queries.

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
      return cl_device_type(CL_DEVICE_TYPE_GPU); // for these the engine makes kernels without vectors
    }
    else if constexpr (Name == CL_DEVICE_GLOBAL_MEM_SIZE)
    {
      return Device::globalMemory();
    }
    else if constexpr (Name == CL_DEVICE_MAX_MEM_ALLOC_SIZE)
    {
      return Device::globalMemory() / 4;
    }
    else if constexpr (Name == CL_DEVICE_PLATFORM)
    {
      return cl_platform_id(nullptr);
    }
    else
    {
      static_assert(Name == CL_DEVICE_MAX_COMPUTE_UNITS || Name == CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT ||
                      Name == CL_DEVICE_AVAILABLE || Name == CL_DEVICE_COMPILER_AVAILABLE ||
                      Name == CL_DEVICE_HOST_UNIFIED_MEMORY,
        "HostOpenCL has no such query: add it here");
      return cl_uint(1);
    }
  }

private:
  static cl_ulong globalMemory();
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
    static_assert(Name == CL_PLATFORM_NAME || Name == CL_PLATFORM_VERSION, "HostOpenCL has no such query: add it here");
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
  Buffer(const Context&, cl_mem_flags flags, std::size_t bytes, void* hostPointer = nullptr);

  cl_mem operator()() const { return reinterpret_cast<cl_mem>(this->memory_.get()); }
  const std::shared_ptr<Memory>& memory() const { return this->memory_; }
  cl_int setDestructorCallback(void (*notify)(cl_mem, void*), void* userData);

private:
  std::shared_ptr<Memory> memory_;
};

/// An argument in the address space local, given by its size.
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
  struct State;
  using Binaries = std::vector<std::vector<unsigned char>>;

  Program() = default;
  Program(const Context&, const std::string& source);
  Program(const Context&, const std::vector<Device>&, const Binaries&)
  {
    throw Error(CL_INVALID_BINARY, "clCreateProgramWithBinary"); // getInfo() returns none
  }

  void build(const std::vector<Device>&, const char* options);
  void compile(const char*) { throw Error(CL_INVALID_OPERATION, "clCompileProgram"); }
  template <cl_program_build_info Name> std::string getBuildInfo(const Device&) const
  {
    static_assert(Name == CL_PROGRAM_BUILD_LOG, "HostOpenCL has no such query: add it here");
    return this->buildLog();
  }
  template <cl_program_info Name> Binaries getInfo() const
  {
    static_assert(Name == CL_PROGRAM_BINARIES, "HostOpenCL has no such query: add it here");
    return {};
  }
  const std::shared_ptr<State>& state() const { return this->state_; }

private:
  std::string buildLog() const;

  std::shared_ptr<State> state_;
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
    this->setValue(index, &value, sizeof(value));
  }
  const std::shared_ptr<State>& state() const { return this->state_; }

private:
  void setValue(cl_uint index, const void* value, std::size_t bytes);

  std::shared_ptr<State> state_;
};

/// A size in one dimension.
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

/// An event of a command, which is complete when the call that enqueues it returns.
class Event
{
public:
  template <cl_event_info Name> cl_int getInfo() const
  {
    static_assert(Name == CL_EVENT_COMMAND_EXECUTION_STATUS, "HostOpenCL has no such query: add it here");
    return CL_COMPLETE;
  }
  void wait() const {}
  void setCallback(cl_int status, void (*notify)(cl_event, cl_int, void*), void* userData)
  {
    notify(nullptr, status, userData);
  }
};

/// Executes each command before the call that enqueues it returns.
class CommandQueue
{
public:
  CommandQueue(const Context&, const Device&) {}

  void enqueueNDRangeKernel(const Kernel& kernel, const NDRange& offset, const NDRange& global, const NDRange& local,
    const std::vector<Event>* waitList = nullptr, Event* event = nullptr);
  void enqueueReadBuffer(const Buffer& buffer, cl_bool blocking, std::size_t offset, std::size_t bytes, void* to);
  void enqueueWriteBuffer(const Buffer& buffer, cl_bool blocking, std::size_t offset, std::size_t bytes,
    const void* from, const std::vector<Event>* waitList = nullptr, Event* event = nullptr);
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
  void fill(const Buffer& buffer, const void* pattern, std::size_t patternSize, std::size_t offset, std::size_t bytes);
};

}
