#include "Process.h"

#include "Error.h"

#ifndef _WIN32
#include <atomic>
#include <unistd.h>
#endif

namespace chainmail
{

#ifdef _WIN32

void requireOwnOpenCL()
{
}

bool isForkedFromOpenCL()
{
  return false;
}

#else

namespace
{

std::atomic<pid_t> user{ 0 }; ///< the first process that has used OpenCL: this one, or the one that it was forked from

}

void requireOwnOpenCL()
{
  pid_t none = 0;
  user.compare_exchange_strong(none, getpid());
  if (isForkedFromOpenCL())
  {
    throw DeviceError("This process was forked from one that had used OpenCL, but OpenCL drivers do not work after a "
                      "fork. Start new processes instead: in Python with multiprocessing.set_start_method(\"spawn\") "
                      "or multiprocessing.get_context(\"spawn\"), "
                      "in "
                      "C++ with exec after fork. Or fork before the first use of a device.");
  }
}

bool isForkedFromOpenCL()
{
  return user != 0 && user != getpid();
}

#endif

}
