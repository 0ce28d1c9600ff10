#pragma once

#include <cstddef>

/// What the host hands to a kernel that was compiled as C++ (KernelLanguage.h), and gets back.
namespace host_opencl
{

struct Argument
{
  const void* value = nullptr; ///< of a plain argument
  void* memory = nullptr;      ///< of a buffer or of local memory
  std::size_t bytes = 0;       ///< of either
};

struct Launch
{
  const Argument* arguments = nullptr;
  std::size_t count = 0; ///< of the arguments
  std::size_t groups = 0;
  std::size_t items = 0; ///< of a group
};

/// Null, or what is wrong.
using Entry = const char* (*)(const Launch&);

}
