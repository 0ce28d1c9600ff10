// SPDX-License-Identifier: BSD-3-Clause
// To be preloaded (LD_PRELOAD): in place of glibc's allocation, which answers one large request with "no memory" when
// it is told to. Only requests of the filters, VTK and the C++ library count: PoCL and MPI end the process where they
// get none.

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <initializer_list>

#include <dlfcn.h>

extern "C"
{
  void* __libc_malloc(std::size_t);
  void* __libc_calloc(std::size_t, std::size_t);
  void* __libc_realloc(void*, std::size_t);
}

namespace
{

std::atomic<std::size_t> large{ ~std::size_t(0) };
std::atomic<int> toGo{ 0 };
std::atomic<int> failed{ 0 };

bool counts(void* caller)
{
  Dl_info info;
  if (dladdr(caller, &info) == 0)
  {
    return false;
  }
  for (const char* name : { "libstdc++", "libvtk", "libChainMail", "ChainMail.so", "/vtkmodules/" })
  {
    if (std::strstr(info.dli_fname, name))
    {
      return true;
    }
  }
  return false;
}

bool fails(std::size_t bytes, void* caller)
{
  const bool one = bytes >= large.load(std::memory_order_relaxed) && counts(caller) && toGo.fetch_sub(1) == 1;
  if (one)
  {
    errno = ENOMEM;
    failed = 1;
  }
  return one;
}

}

extern "C"
{
  /// From now on the n-th request of at least `bytes` fails; n = 0: none.
  void failAllocation(std::size_t bytes, int n)
  {
    failed = 0;
    toGo = n;
    large = n > 0 ? bytes : ~std::size_t(0);
  }
  /// Whether it has come to that.
  int hasFailed()
  {
    return failed;
  }

  void* malloc(std::size_t bytes)
  {
    return fails(bytes, __builtin_return_address(0)) ? nullptr : __libc_malloc(bytes);
  }
  void* calloc(std::size_t count, std::size_t bytes)
  {
    return fails(count * bytes, __builtin_return_address(0)) ? nullptr : __libc_calloc(count, bytes);
  }
  void* realloc(void* memory, std::size_t bytes)
  {
    return fails(bytes, __builtin_return_address(0)) ? nullptr : __libc_realloc(memory, bytes);
  }
}
