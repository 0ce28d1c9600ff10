// Work that the host distributes over its cores, and simulations in several threads.

#include "Threads.h"

#include "Inclusion.h"

#include <atomic>
#include <stdexcept>
#include <thread>
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

/// A run of a simulation that uses most of the engine. Runs of different `number` have different kernels.
std::vector<float> life(int number)
{
  using namespace chainmail;
  const Scene scene = inclusionScene(17 + 2 * number, number % 2 == 0 ? 1 : 3, 70 + number);
  Simulation simulation = simulate(scene, number % 2 == 0 ? Index3{ 8, 4, 4 } : Index3{ 16, 8, 4 });
  simulation.setPropagation(
    number % 2 == 0 ? PropagationMethod::Envelope : PropagationMethod::Timestamp, ConflictPolicy::Limit);
  simulation.setPropagationTimes(true);
  simulation.setCoarseToFine(number % 2 == 0);
  std::vector<float> all;
  const auto keep = [&]
  {
    const std::vector<float> now = displacements(simulation);
    all.insert(all.end(), now.begin(), now.end());
  };
  for (int step = 1; step <= 4; ++step)
  {
    simulation.setRelaxation(step == 3 ? RelaxationMethod::Paper : RelaxationMethod::Projected, step == 4 ? 0.7 : 1.0);
    simulation.pull({ corner(scene, { 0.6 * step, -0.7 * step, 0.3 * step }) });
    keep();
    simulation.relax(6, 0.0);
    keep();
    const Statistics statistics = simulation.measure();
    all.push_back(static_cast<float>(statistics.energy));
    all.push_back(static_cast<float>(statistics.displaced));
  }
  return all;
}

TEST(Threads, SimulationsOnOneDeviceDoNotDisturbEachOther)
{
  constexpr std::size_t count = 2;
  std::vector<std::vector<float>> together(count);
  std::vector<std::thread> threads;
  for (std::size_t n = 0; n < count; ++n)
  {
    threads.emplace_back([&together, n] { together[n] = life(static_cast<int>(n)); });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  for (std::size_t n = 0; n < count; ++n)
  {
    EXPECT_TRUE(sameBits(life(static_cast<int>(n)), together[n])) << "simulation " << n;
  }
}

}
