#pragma once

#include <cstddef>

/// The interface between the host and a kernel that was compiled as C++: HostOpenCL.cpp calls, KernelLanguage.h
/// answers.
namespace host_opencl
{

/// An argument of a kernel: a value, or memory of the address space global or local.
struct Argument
{
  const void* value = nullptr; ///< the bytes of a scalar or of a vector
  void* memory = nullptr;      ///< a buffer, or local memory
  std::size_t bytes = 0;       ///< size of the value or of the memory
};

/// A one-dimensional NDRange with the arguments of its kernel.
struct Launch
{
  const Argument* arguments = nullptr;
  std::size_t argumentCount = 0;
  std::size_t groupCount = 0; ///< work-groups
  std::size_t groupSize = 0;  ///< work-items of a work-group
};

/// Runs a kernel over an NDRange. Returns null, or a message that says what is wrong.
using EntryPoint = const char* (*)(const Launch&);

}
