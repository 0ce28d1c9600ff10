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

// Where compiled kernels are kept, and how they are compiled; from CMakeLists.txt.
#ifndef HOST_OPENCL_FOLDER
#error "HOST_OPENCL_FOLDER, HOST_OPENCL_COMPILER and HOST_OPENCL_FLAGS are not defined"
#endif

namespace cl
{

namespace
{

std::size_t allocated = 0;

/// A part of a buffer, which has to lie in it.
char* part(const Buffer& buffer, std::size_t offset, std::size_t bytes, const char* call);

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

/// The C++ text of an OpenCL text: vectors are made by constructors, and every kernel gets an entry. The entries stand
/// at the end, within copies of the conditions of the preprocessor: a kernel that these leave out gets no entry.
std::string translated(const std::string& source)
{
  static const std::regex literal("\\((u?int|float)([234])\\)[ ]*\\(");
  static const std::regex condition("^\\s*#\\s*(if|ifdef|ifndef|elif|else|endif)\\b");
  static const std::regex kernel("^kernel\\s+void\\s+(\\w+)\\s*\\(");
  const std::string text = std::regex_replace(source, literal, "$1$2(");
  std::string entries;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
  {
    std::smatch found;
    if (std::regex_search(line, condition))
    {
      entries += line + '\n';
    }
    else if (std::regex_search(line, found, kernel))
    {
      entries += "HOST_OPENCL_ENTRY(" + found[1].str() + ")\n";
    }
  }
  return text + "\n#line 1 \"entries\"\n" + entries;
}

/// Holds a file's lock as long as it lives.
class Lock
{
public:
  explicit Lock(const std::string& path)
    : file_(open(path.c_str(), O_CREAT | O_RDWR, 0666))
  {
    flock(this->file_, LOCK_EX);
  }
  ~Lock() { close(this->file_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

private:
  int file_;
};

}

// --- Platform and device

// As the loader does: nothing where the folder of drivers is not there.
cl_int Platform::get(std::vector<Platform>* platforms)
{
  const char* drivers = std::getenv("OCL_ICD_VENDORS");
  if (drivers && access(drivers, F_OK) != 0)
  {
    throw Error(-1001, "clGetPlatformIDs");
  }
  platforms->assign(1, Platform());
  return CL_SUCCESS;
}

cl_device_id Device::operator()() const
{
  static char device;
  return reinterpret_cast<cl_device_id>(&device);
}

// HOST_OPENCL_MEMORY is a limit in MiB.
cl_ulong Device::memory()
{
  const char* limit = std::getenv("HOST_OPENCL_MEMORY");
  return limit ? std::strtoull(limit, nullptr, 10) << 20
               : static_cast<cl_ulong>(sysconf(_SC_PHYS_PAGES)) * static_cast<cl_ulong>(sysconf(_SC_PAGESIZE));
}

// --- Buffers

struct Buffer::Memory
{
  explicit Memory(std::size_t size)
    : data(static_cast<char*>(std::malloc(size))) // not initialised, as on a device
    , bytes(size)
  {
    allocated += size;
  }
  ~Memory()
  {
    if (this->notify)
    {
      this->notify(nullptr, this->notified);
    }
    std::free(this->data);
    allocated -= this->bytes;
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  char* data;
  std::size_t bytes;
  void (*notify)(cl_mem, void*) = nullptr;
  void* notified = nullptr;
};

Buffer::Buffer(const Context&, cl_mem_flags flags, std::size_t bytes, void* host)
{
  if (bytes == 0 || bytes > Device().getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>())
  {
    throw Error(CL_INVALID_BUFFER_SIZE, "clCreateBuffer");
  }
  if (allocated + bytes > Device().getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>())
  {
    throw Error(CL_MEM_OBJECT_ALLOCATION_FAILURE, "clCreateBuffer");
  }
  this->memory_ = std::make_shared<Memory>(bytes);
  if (flags & CL_MEM_USE_HOST_PTR) // as a device with memory of its own does it
  {
    std::memcpy(this->memory_->data, host, bytes);
  }
}

cl_int Buffer::setDestructorCallback(void (*notify)(cl_mem, void*), void* data)
{
  this->memory_->notify = notify;
  this->memory_->notified = data;
  return CL_SUCCESS;
}

namespace
{

char* part(const Buffer& buffer, std::size_t offset, std::size_t bytes, const char* call)
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
  std::memcpy(to, part(buffer, offset, bytes, "clEnqueueReadBuffer"), bytes);
}

void CommandQueue::enqueueWriteBuffer(const Buffer& buffer, cl_bool, std::size_t offset, std::size_t bytes,
  const void* from, const std::vector<Event>*, Event*)
{
  std::memcpy(part(buffer, offset, bytes, "clEnqueueWriteBuffer"), from, bytes);
}

void* CommandQueue::enqueueMapBuffer(const Buffer& buffer, cl_bool, cl_map_flags, std::size_t offset, std::size_t bytes)
{
  return part(buffer, offset, bytes, "clEnqueueMapBuffer");
}

void CommandQueue::enqueueUnmapMemObject(const Buffer&, void*)
{
}

void CommandQueue::enqueueCopyBuffer(
  const Buffer& from, const Buffer& to, std::size_t fromOffset, std::size_t toOffset, std::size_t bytes)
{
  const char* source = part(from, fromOffset, bytes, "clEnqueueCopyBuffer");
  char* target = part(to, toOffset, bytes, "clEnqueueCopyBuffer");
  if (source < target + bytes && target < source + bytes)
  {
    throw Error(CL_MEM_COPY_OVERLAP, "clEnqueueCopyBuffer");
  }
  std::memcpy(target, source, bytes);
}

void CommandQueue::fill(
  const Buffer& buffer, const void* pattern, std::size_t size, std::size_t offset, std::size_t bytes)
{
  char* to = part(buffer, offset, bytes, "clEnqueueFillBuffer");
  if (offset % size != 0 || bytes % size != 0)
  {
    throw Error(CL_INVALID_VALUE, "clEnqueueFillBuffer");
  }
  for (std::size_t n = 0; n < bytes; n += size)
  {
    std::memcpy(to + n, pattern, size);
  }
}

// --- Programs and kernels

struct Program::Built
{
  std::string source;
  std::string log;
  void* library = nullptr; ///< open until the process ends, as a leak checker or gcov needs it
};

Program::Program(const Context&, const std::string& source)
  : built_(std::make_shared<Built>())
{
  this->built_->source = source;
}

// A library for every text and set of options, kept between runs. gcov's data lie beside it.
void Program::build(const std::vector<Device>&, const char* options)
{
  std::string flags;
  std::istringstream words(options);
  for (std::string word; words >> word;)
  {
    flags += word.compare(0, 2, "-D") == 0 ? word + ' ' : "";
  }
  const char* more = std::getenv("HOST_OPENCL_FLAGS");
  const std::string compiler = std::string(HOST_OPENCL_COMPILER " " HOST_OPENCL_FLAGS " ") + (more ? more : "-O1") +
                               " -std=c++17 -shared -fPIC -fvisibility=hidden -ffp-contract=off -fno-exceptions"
                               " -Wno-unknown-pragmas -include " HOST_OPENCL_LANGUAGE " ";
  const std::string text = translated(this->built_->source);
  const std::string path =
    std::string(HOST_OPENCL_FOLDER) + "/" + hashOf(compiler + flags + contentOf(HOST_OPENCL_LANGUAGE) + text);
  const Lock lock(path + ".lock");
  if (access((path + ".so").c_str(), F_OK) != 0)
  {
    std::ofstream(path + ".cpp") << "// " << flags << '\n' << text;
    const std::string command = compiler + flags + path + ".cpp -o " + path + ".new >" + path + ".log 2>&1 && mv " +
                                path + ".new " + path + ".so";
    if (std::system(command.c_str()) != 0)
    {
      this->built_->log = contentOf(path + ".log");
      throw Error(CL_BUILD_PROGRAM_FAILURE, "clBuildProgram");
    }
  }
  this->built_->library = dlopen((path + ".so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!this->built_->library)
  {
    this->built_->log = dlerror();
    throw Error(CL_BUILD_PROGRAM_FAILURE, "clBuildProgram");
  }
}

std::string Program::buildLog() const
{
  return this->built_->log;
}

struct Kernel::State
{
  struct Stored
  {
    std::vector<char> plain;
    std::shared_ptr<Buffer::Memory> buffer;
    std::size_t local = 0;
  };

  std::string name;
  host_opencl::Entry entry = nullptr;
  std::vector<Stored> arguments;

  Stored& at(cl_uint index)
  {
    this->arguments.resize(std::max<std::size_t>(this->arguments.size(), index + 1));
    return this->arguments[index] = Stored();
  }
};

Kernel::Kernel(const Program& program, const char* name)
  : state_(std::make_shared<State>())
{
  this->state_->name = name;
  this->state_->entry =
    reinterpret_cast<host_opencl::Entry>(dlsym(program.built()->library, ("host_opencl_" + std::string(name)).c_str()));
  if (!this->state_->entry)
  {
    throw Error(CL_INVALID_KERNEL_NAME, "clCreateKernel");
  }
  if (const char* trace = std::getenv("HOST_OPENCL_TRACE")) // a file that lists the kernels which are used
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
  this->state_->at(index).buffer = buffer.memory();
}

void Kernel::setArg(cl_uint index, const LocalSpaceArg& local)
{
  this->state_->at(index).local = local.bytes;
}

void Kernel::setPlain(cl_uint index, const void* value, std::size_t bytes)
{
  const char* from = static_cast<const char*>(value);
  this->state_->at(index).plain.assign(from, from + bytes);
}

void CommandQueue::enqueueNDRangeKernel(
  const Kernel& kernel, const NDRange&, const NDRange& all, const NDRange& group, const std::vector<Event>*, Event*)
{
  if (group.size() == 0 || all.size() % group.size() != 0)
  {
    throw Error(CL_INVALID_WORK_GROUP_SIZE, "clEnqueueNDRangeKernel");
  }
  std::vector<host_opencl::Argument> arguments;
  std::vector<std::shared_ptr<void>> locals;
  for (const Kernel::State::Stored& stored : kernel.state()->arguments)
  {
    host_opencl::Argument argument;
    if (stored.buffer)
    {
      argument.memory = stored.buffer->data;
      argument.bytes = stored.buffer->bytes;
    }
    else if (stored.local > 0)
    {
      locals.emplace_back(std::malloc(stored.local), std::free);
      argument.memory = locals.back().get();
      argument.bytes = stored.local;
    }
    else if (!stored.plain.empty())
    {
      argument.value = stored.plain.data();
      argument.bytes = stored.plain.size();
    }
    arguments.push_back(argument);
  }
  host_opencl::Launch launch;
  launch.arguments = arguments.data();
  launch.count = arguments.size();
  launch.groups = all.size() / group.size();
  launch.items = group.size();
  if (const char* problem = kernel.state()->entry(launch))
  {
    std::cerr << kernel.state()->name << ": " << problem << '\n';
    throw Error(CL_INVALID_KERNEL_ARGS, "clEnqueueNDRangeKernel");
  }
}

}
