// The runtime of OpenCL on the host; CL/opencl.hpp says what it implements.

#include <CL/opencl.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <fstream>
#include <iostream>
#include <regex>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

// HostOpenCL.cmake defines where compiled programs are kept, the compiler, its flags, and the path of KernelLanguage.h.
#if !defined(HOST_OPENCL_FOLDER) || !defined(HOST_OPENCL_COMPILER) || !defined(HOST_OPENCL_FLAGS) ||                   \
  !defined(HOST_OPENCL_LANGUAGE)
#error "HOST_OPENCL_FOLDER, HOST_OPENCL_COMPILER, HOST_OPENCL_FLAGS or HOST_OPENCL_LANGUAGE is not defined"
#endif

namespace cl
{

namespace
{

/// Size of all buffers.
std::size_t allocatedBytes = 0;

std::string contentOf(const std::string& path)
{
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// FNV-1a, http://www.isthe.com/chongo/tech/comp/fnv/
std::string hashOf(const std::string& text)
{
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const unsigned char c : text)
  {
    hash = (hash ^ c) * 0x100000001b3u;
  }
  std::ostringstream hex;
  hex << std::hex << hash;
  return hex.str();
}

/// Translates a program to C++. OpenCL's vector literals, (float4)(x, y, z, w), become constructor calls. Every kernel
/// gets an entry point (HOST_OPENCL_ENTRY in KernelLanguage.h). Entry points follow the program, within a copy of its
/// preprocessor conditions, because a kernel that a condition excludes must have none.
std::string translate(const std::string& source)
{
  static const std::regex vectorLiteral("\\((u?int|float)([234])\\)[ ]*\\(");
  static const std::regex condition("^\\s*#\\s*(if|ifdef|ifndef|elif|else|endif)\\b");
  static const std::regex kernel("^kernel\\s+void\\s+(\\w+)\\s*\\(");
  const std::string text = std::regex_replace(source, vectorLiteral, "$1$2(");
  std::string entryPoints;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
  {
    std::smatch match;
    if (std::regex_search(line, condition))
    {
      entryPoints += line + '\n';
    }
    else if (std::regex_search(line, match, kernel))
    {
      entryPoints += "HOST_OPENCL_ENTRY(" + match[1].str() + ")\n";
    }
  }
  return text + "\n#line 1 \"entry-points\"\n" + entryPoints;
}

/// Locks a file from construction to destruction, against other processes that compile the same program.
class FileLock
{
public:
  explicit FileLock(const std::string& path)
    : file_(open(path.c_str(), O_CREAT | O_RDWR, 0666))
  {
    flock(this->file_, LOCK_EX);
  }
  ~FileLock() { close(this->file_); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

private:
  int file_;
};

}

// --- Platform and device

// Fails like the ICD loader where OCL_ICD_VENDORS names a folder of drivers that does not exist.
cl_int Platform::get(std::vector<Platform>* platforms)
{
  const char* folder = std::getenv("OCL_ICD_VENDORS");
  if (folder && access(folder, F_OK) != 0)
  {
    throw Error(-1001, "clGetPlatformIDs"); // CL_PLATFORM_NOT_FOUND_KHR
  }
  platforms->assign(1, Platform());
  return CL_SUCCESS;
}

cl_device_id Device::operator()() const
{
  static char device;
  return reinterpret_cast<cl_device_id>(&device);
}

cl_ulong Device::globalMemory()
{
  const char* megabytes = std::getenv("HOST_OPENCL_MEMORY");
  return megabytes ? std::strtoull(megabytes, nullptr, 10) << 20
                   : static_cast<cl_ulong>(sysconf(_SC_PHYS_PAGES)) * static_cast<cl_ulong>(sysconf(_SC_PAGESIZE));
}

// --- Buffers

struct Buffer::Memory
{
  explicit Memory(std::size_t size)
    : data(static_cast<char*>(std::malloc(size))) // not initialised, like memory of a device
    , bytes(size)
  {
    allocatedBytes += size;
  }
  ~Memory()
  {
    if (this->destructorCallback)
    {
      this->destructorCallback(nullptr, this->userData);
    }
    std::free(this->data);
    allocatedBytes -= this->bytes;
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  char* data;
  std::size_t bytes;
  void (*destructorCallback)(cl_mem, void*) = nullptr;
  void* userData = nullptr;
};

Buffer::Buffer(const Context&, cl_mem_flags flags, std::size_t bytes, void* hostPointer)
{
  if (bytes == 0 || bytes > Device().getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>())
  {
    throw Error(CL_INVALID_BUFFER_SIZE, "clCreateBuffer");
  }
  if (allocatedBytes + bytes > Device().getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>())
  {
    throw Error(CL_MEM_OBJECT_ALLOCATION_FAILURE, "clCreateBuffer");
  }
  this->memory_ = std::make_shared<Memory>(bytes);
  if (flags & CL_MEM_USE_HOST_PTR) // a device with memory of its own makes a copy, too
  {
    std::memcpy(this->memory_->data, hostPointer, bytes);
  }
}

cl_int Buffer::setDestructorCallback(void (*notify)(cl_mem, void*), void* userData)
{
  this->memory_->destructorCallback = notify;
  this->memory_->userData = userData;
  return CL_SUCCESS;
}

namespace
{

/// The address of a region of a buffer. Throws where the region is empty or exceeds the buffer; `call` is for the
/// error.
char* regionOf(const Buffer& buffer, std::size_t offset, std::size_t bytes, const char* call)
{
  if (!buffer.memory())
  {
    throw Error(CL_INVALID_MEM_OBJECT, call);
  }
  if (bytes == 0 || offset > buffer.memory()->bytes || bytes > buffer.memory()->bytes - offset)
  {
    throw Error(CL_INVALID_VALUE, call);
  }
  return buffer.memory()->data + offset;
}

}

void CommandQueue::enqueueReadBuffer(const Buffer& buffer, cl_bool, std::size_t offset, std::size_t bytes, void* to)
{
  std::memcpy(to, regionOf(buffer, offset, bytes, "clEnqueueReadBuffer"), bytes);
}

void CommandQueue::enqueueWriteBuffer(const Buffer& buffer, cl_bool, std::size_t offset, std::size_t bytes,
  const void* from, const std::vector<Event>*, Event*)
{
  std::memcpy(regionOf(buffer, offset, bytes, "clEnqueueWriteBuffer"), from, bytes);
}

void* CommandQueue::enqueueMapBuffer(const Buffer& buffer, cl_bool, cl_map_flags, std::size_t offset, std::size_t bytes)
{
  return regionOf(buffer, offset, bytes, "clEnqueueMapBuffer");
}

void CommandQueue::enqueueUnmapMemObject(const Buffer&, void*)
{
}

void CommandQueue::enqueueCopyBuffer(
  const Buffer& from, const Buffer& to, std::size_t fromOffset, std::size_t toOffset, std::size_t bytes)
{
  const char* source = regionOf(from, fromOffset, bytes, "clEnqueueCopyBuffer");
  char* target = regionOf(to, toOffset, bytes, "clEnqueueCopyBuffer");
  if (source < target + bytes && target < source + bytes)
  {
    throw Error(CL_MEM_COPY_OVERLAP, "clEnqueueCopyBuffer");
  }
  std::memcpy(target, source, bytes);
}

void CommandQueue::fill(
  const Buffer& buffer, const void* pattern, std::size_t patternSize, std::size_t offset, std::size_t bytes)
{
  char* to = regionOf(buffer, offset, bytes, "clEnqueueFillBuffer");
  if (offset % patternSize != 0 || bytes % patternSize != 0)
  {
    throw Error(CL_INVALID_VALUE, "clEnqueueFillBuffer");
  }
  for (std::size_t n = 0; n < bytes; n += patternSize)
  {
    std::memcpy(to + n, pattern, patternSize);
  }
}

// --- Programs and kernels

struct Program::State
{
  std::string source;
  std::string log;
  void* library = nullptr; ///< never closed: leak checkers and gcov need it when the process ends
};

Program::Program(const Context&, const std::string& source)
  : state_(std::make_shared<State>())
{
  this->state_->source = source;
}

namespace
{

/// The macros among the build options of OpenCL. All other options are for compilers of OpenCL C.
std::string macrosOf(const char* options)
{
  std::string macros;
  std::istringstream words(options);
  for (std::string word; words >> word;)
  {
    macros += word.compare(0, 2, "-D") == 0 ? word + ' ' : "";
  }
  return macros;
}

/// The command that compiles a program, without its macros and paths.
std::string compilerCommand()
{
  const char* further = std::getenv("HOST_OPENCL_FLAGS");
  return std::string(HOST_OPENCL_COMPILER " " HOST_OPENCL_FLAGS " ") + (further ? further : "-O1") +
         " -std=c++17 -shared -fPIC -fvisibility=hidden -ffp-contract=off -fno-exceptions"
         " -Wno-unknown-pragmas -include " HOST_OPENCL_LANGUAGE " ";
}

}

// Compiles the program to a shared library, or loads the library of an earlier build. A library is found by the hash of
// everything it depends on. gcov writes its data beside it.
void Program::build(const std::vector<Device>&, const char* options)
{
  const std::string macros = macrosOf(options);
  const std::string compiler = compilerCommand();
  const std::string text = translate(this->state_->source);
  const std::string path =
    std::string(HOST_OPENCL_FOLDER) + "/" + hashOf(compiler + macros + contentOf(HOST_OPENCL_LANGUAGE) + text);
  const FileLock lock(path + ".lock");
  if (access((path + ".so").c_str(), F_OK) != 0)
  {
    std::ofstream(path + ".cpp") << "// " << macros << '\n' << text;
    const std::string command = compiler + macros + path + ".cpp -o " + path + ".new >" + path + ".log 2>&1 && mv " +
                                path + ".new " + path + ".so";
    if (std::system(command.c_str()) != 0)
    {
      this->state_->log = contentOf(path + ".log");
      throw Error(CL_BUILD_PROGRAM_FAILURE, "clBuildProgram");
    }
  }
  this->state_->library = dlopen((path + ".so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!this->state_->library)
  {
    this->state_->log = dlerror();
    throw Error(CL_BUILD_PROGRAM_FAILURE, "clBuildProgram");
  }
}

std::string Program::buildLog() const
{
  return this->state_->log;
}

struct Kernel::State
{
  /// Either a value, a buffer or the size of local memory. All are empty until clSetKernelArg.
  struct Argument
  {
    std::vector<char> value;
    std::shared_ptr<Buffer::Memory> buffer;
    std::size_t localBytes = 0;
  };

  std::string name;
  host_opencl::EntryPoint entryPoint = nullptr;
  std::vector<Argument> arguments;

  /// An argument to be set, without what it was before.
  Argument& reset(cl_uint index)
  {
    this->arguments.resize(std::max<std::size_t>(this->arguments.size(), index + 1));
    return this->arguments[index] = Argument();
  }
};

Kernel::Kernel(const Program& program, const char* name)
  : state_(std::make_shared<State>())
{
  this->state_->name = name;
  this->state_->entryPoint = reinterpret_cast<host_opencl::EntryPoint>(
    dlsym(program.state()->library, ("host_opencl_" + std::string(name)).c_str()));
  if (!this->state_->entryPoint)
  {
    throw Error(CL_INVALID_KERNEL_NAME, "clCreateKernel");
  }
  if (const char* trace = std::getenv("HOST_OPENCL_TRACE"))
  {
    std::ofstream(trace, std::ios::app) << name << '\n';
  }
}

void Kernel::setArg(cl_uint index, const Buffer& buffer)
{
  if (!buffer.memory())
  {
    throw Error(CL_INVALID_MEM_OBJECT, "clSetKernelArg");
  }
  this->state_->reset(index).buffer = buffer.memory();
}

void Kernel::setArg(cl_uint index, const LocalSpaceArg& local)
{
  this->state_->reset(index).localBytes = local.bytes;
}

void Kernel::setValue(cl_uint index, const void* value, std::size_t bytes)
{
  const char* from = static_cast<const char*>(value);
  this->state_->reset(index).value.assign(from, from + bytes);
}

void CommandQueue::enqueueNDRangeKernel(
  const Kernel& kernel, const NDRange&, const NDRange& global, const NDRange& local, const std::vector<Event>*, Event*)
{
  if (local.size() == 0 || global.size() % local.size() != 0)
  {
    throw Error(CL_INVALID_WORK_GROUP_SIZE, "clEnqueueNDRangeKernel");
  }
  std::vector<host_opencl::Argument> arguments;
  std::vector<std::shared_ptr<void>> localMemory;
  for (const Kernel::State::Argument& set : kernel.state()->arguments)
  {
    host_opencl::Argument argument;
    if (set.buffer)
    {
      argument.memory = set.buffer->data;
      argument.bytes = set.buffer->bytes;
    }
    else if (set.localBytes > 0)
    {
      localMemory.emplace_back(std::malloc(set.localBytes), std::free); // not initialised, like a device's
      argument.memory = localMemory.back().get();
      argument.bytes = set.localBytes;
    }
    else if (!set.value.empty())
    {
      argument.value = set.value.data();
      argument.bytes = set.value.size();
    }
    arguments.push_back(argument);
  }
  host_opencl::Launch launch;
  launch.arguments = arguments.data();
  launch.argumentCount = arguments.size();
  launch.groupCount = global.size() / local.size();
  launch.groupSize = local.size();
  if (const char* problem = kernel.state()->entryPoint(launch))
  {
    std::cerr << kernel.state()->name << ": " << problem << '\n';
    throw Error(CL_INVALID_KERNEL_ARGS, "clEnqueueNDRangeKernel");
  }
}

}
