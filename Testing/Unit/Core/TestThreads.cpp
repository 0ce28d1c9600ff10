// Work that the host shares among its cores, and simulations in several threads.

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

/// What a simulation goes through that uses most of the engine, each `number` another one, with kernels of its own.
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
  for (int turn = 1; turn <= 4; ++turn)
  {
    simulation.setRelaxation(turn == 3 ? RelaxationMethod::Paper : RelaxationMethod::Projected, turn == 4 ? 0.7 : 1.0);
    simulation.pull({ corner(scene, { 0.6 * turn, -0.7 * turn, 0.3 * turn }) });
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
