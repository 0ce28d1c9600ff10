#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace chainmail
{

/// Calls body(n) for every n below `count`, in any order, from as many threads as the host has cores. When a call
/// throws, no further ones begin, and the caller gets one of the exceptions.
template <typename Body> void inParallel(std::size_t count, const Body& body)
{
  std::atomic<std::size_t> next{ 0 };
  std::exception_ptr error;
  std::atomic<bool> failed{ false };
  const auto work = [&]
  {
    try
    {
      for (std::size_t n = next++; n < count && !failed; n = next++)
      {
        body(n);
      }
    }
    catch (...)
    {
      if (!failed.exchange(true))
      {
        error = std::current_exception();
      }
    }
  };
  std::vector<std::thread> threads;
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  try
  {
    while (threads.size() + 1 < std::min(cores, count))
    {
      threads.emplace_back(work);
    }
  }
  catch (const std::system_error&)
  {
    // The system provides no more threads: the existing ones do all the work.
  }
  work();
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  if (error)
  {
    std::rethrow_exception(error);
  }
}

}
