// Takes the place of three OpenCL functions in a program that oclgrind runs. oclgrind 21.10 does not notice that a
// buffer is initialised which was filled, or written or copied to in part; only whole buffers that are written count.
// So here every one of these calls writes a whole buffer. All of the engine's buffers are filled first, so nothing is
// hidden.
//
// And of a fourth: oclgrind's device says that it is of every type. With SMALL_SCENES_PROCESSOR in the environment it
// is a processor, for which kernels have vectors and a single work-item works a brick through.

#include <CL/cl.h>

#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <vector>

namespace
{

template <typename F> F* real(const char* name)
{
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}

size_t sizeOf(cl_mem buffer)
{
  size_t size = 0;
  clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof(size), &size, nullptr);
  return size;
}

cl_int replacePart(cl_command_queue queue, cl_mem buffer, size_t offset, const std::vector<char>& part)
{
  std::vector<char> whole(sizeOf(buffer));
  cl_int status = clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, whole.size(), whole.data(), 0, nullptr, nullptr);
  if (status != CL_SUCCESS || offset > whole.size() || part.size() > whole.size() - offset)
  {
    return status != CL_SUCCESS ? status : CL_INVALID_VALUE;
  }
  std::memcpy(whole.data() + offset, part.data(), part.size());
  static const auto write = real<decltype(clEnqueueWriteBuffer)>("clEnqueueWriteBuffer");
  return write(queue, buffer, CL_TRUE, 0, whole.size(), whole.data(), 0, nullptr, nullptr);
}

}

// The engine's queues are in order and it waits for no events.
extern "C" cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool, size_t offset, size_t size,
  const void* from, cl_uint, const cl_event*, cl_event*)
{
  const char* bytes = static_cast<const char*>(from);
  return replacePart(queue, buffer, offset, std::vector<char>(bytes, bytes + size));
}

extern "C" cl_int clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void* pattern, size_t patternSize,
  size_t offset, size_t size, cl_uint, const cl_event*, cl_event*)
{
  std::vector<char> part(size);
  for (size_t n = 0; n < size; n += patternSize)
  {
    std::memcpy(part.data() + n, pattern, patternSize);
  }
  return replacePart(queue, buffer, offset, part);
}

extern "C" cl_int clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, size_t fromOffset,
  size_t toOffset, size_t size, cl_uint, const cl_event*, cl_event*)
{
  std::vector<char> part(size);
  const cl_int status = clEnqueueReadBuffer(queue, from, CL_TRUE, fromOffset, size, part.data(), 0, nullptr, nullptr);
  return status == CL_SUCCESS ? replacePart(queue, to, toOffset, part) : status;
}

extern "C" cl_int clGetDeviceInfo(cl_device_id device, cl_device_info name, size_t size, void* value, size_t* sizeOut)
{
  static const auto ask = real<decltype(clGetDeviceInfo)>("clGetDeviceInfo");
  const cl_int status = ask(device, name, size, value, sizeOut);
  if (status == CL_SUCCESS && value && name == CL_DEVICE_TYPE && std::getenv("SMALL_SCENES_PROCESSOR"))
  {
    *static_cast<cl_device_type*>(value) = CL_DEVICE_TYPE_CPU;
  }
  return status;
}
