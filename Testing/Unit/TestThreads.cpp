// Work that the host shares among its cores.

#include "Threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace
{

using chainmail::inParallel;

TEST(Threads, CallsForEachNumberOnce)
{
  for (const std::size_t count : { 0, 1, 2, 3, 1000 })
  {
    std::vector<std::atomic<int>> calls(count);
    inParallel(count, [&](std::size_t n) { ++calls[n]; });
    for (const std::atomic<int>& times : calls)
    {
      EXPECT_EQ(times, 1);
    }
  }
}

TEST(Threads, AnExceptionReachesTheCallerAndEndsTheWork)
{
  std::atomic<int> calls{ 0 };
  const std::size_t many = 100'000'000;
  const auto body = [&](std::size_t n)
  {
    ++calls;
    if (n == 5)
    {
      throw std::runtime_error("six");
    }
  };
  EXPECT_THROW(inParallel(many, body), std::runtime_error);
  EXPECT_GE(calls, 6);
  EXPECT_LT(calls, static_cast<int>(many));
}

}
