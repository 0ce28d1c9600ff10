// Scenes that need more memory than the device has. PoCL and the kernels as C++ take a limit from their environment, so
// the scenes run in child processes. With kernels as C++, which are slow, limit and scenes are 64 times smaller.

#include "ChildProcess.h"
#include "Device.h"
#include "Scene.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <thread>

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace
{

using namespace chainmail;

/// A block of rigid tissue: a probe anywhere moves all of it. It reads one byte a voxel.
class RigidBlock
{
public:
  explicit RigidBlock(const Index3& size)
  {
    this->grid_.size = size;
    this->tissue_.assign(this->grid_.voxels(), 1);
  }

  std::shared_ptr<const Model> model() const
  {
    ArrayView view;
    view.data = this->tissue_.data();
    view.type = ArrayView::Type::UInt8;
    Material material;
    material.constraint = [](double) { return 0.0; };
    Anchors anchors;
    anchors.faces.fill(false);
    return std::make_shared<Model>(this->grid_, view, material, anchors);
  }
  Probe middle() const
  {
    Probe probe;
    for (int a = 0; a < 3; ++a)
    {
      probe.position[a] = this->grid_.size[a] / 2;
    }
    probe.displacement = { 1.0, 0.0, 0.0 };
    return probe;
  }

private:
  Grid grid_;
  std::vector<std::uint8_t> tissue_;
};

/// The device that has the limit. Processors are last in the list.
DeviceInfo device()
{
  return listDevices().back();
}

bool isSmall()
{
  return device().platform == "Host C++";
}

Index3 scaled(const Index3& size)
{
  const int divisor = isSmall() ? 4 : 1;
  return { size[0] / divisor, size[1] / divisor, size[2] / divisor };
}

/// Bricks of a size for which a pool reaches the limit of a single buffer before it fills the device.
Simulation simulate(const RigidBlock& block, const Index3& bricks = scaled({ 32, 32, 32 }))
{
  Settings settings;
  settings.device = device().name;
  settings.brickSize = bricks;
  return Simulation(block.model(), settings);
}

void describeDevice()
{
  std::cout << "device: " << (device().globalMemory >> 20) << " MiB, " << (device().maxAllocation >> 20)
            << " MiB in one piece\n";
}

/// Whether a pull fits into the memory; prints the message if it does not.
bool pull(Simulation& simulation, const RigidBlock& block)
{
  try
  {
    simulation.pull({ block.middle() });
    return true;
  }
  catch (const MemoryError& error)
  {
    std::cout << "message: " << error.what() << '\n';
    return false;
  }
}

/// Prints the result of a pull that must fit.
void pullAfter(const char* name, const Index3& size)
{
  const RigidBlock block(size);
  Simulation simulation = simulate(block);
  const std::vector<ProbeResult> probes = simulation.pull({ block.middle() });
  const Statistics statistics = simulation.measure();
  std::cout << name << ": " << statistics.displaced << " displaced, reached " << probes[0].reached[0] << ", "
            << (statistics.deviceBytes >> 20) << " MiB held\n";
}

const Index3 quarter{ 256, 256, 160 }; // a little more than a quarter of the device's memory

int tooLargeInOnePiece()
{
  describeDevice();
  {
    // PoCL's limit of a single buffer is a quarter of the memory, since PoCL 7 all of it.
    const int times = std::max(1, static_cast<int>(device().maxAllocation >> 28));
    const RigidBlock block(scaled({ 512, 512, 160 * times }));
    Simulation simulation = simulate(block);
    pull(simulation, block);
    pullAfter("next", { 12, 10, 8 });
  }
  pullAfter("after", scaled(quarter));
  return 0;
}
const ChildPart onePart("tooLargeInOnePiece", tooLargeInOnePiece);

int tooManyTogether()
{
  describeDevice();
  const RigidBlock block(scaled(quarter));
  {
    std::vector<Simulation> simulations;
    do
    {
      simulations.push_back(simulate(block));
    } while (simulations.size() < 6 && pull(simulations.back(), block));
    std::cout << "simulations: " << simulations.size() << '\n';
    pullAfter("next", { 12, 10, 8 });
  }
  pullAfter("after", scaled(quarter));
  return 0;
}
const ChildPart manyPart("tooManyTogether", tooManyTogether);

/// Memory of this process [bytes]; 0 where the system does not report it.
long resident()
{
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
  {
    long kilobytes = 0;
    if (word == "VmRSS:" && status >> kilobytes)
    {
      return 1024 * kilobytes;
    }
  }
  return 0;
}

int severalInSuccession()
{
  const RigidBlock block(scaled({ 128, 128, 96 }));
  const RigidBlock little({ 12, 10, 8 });
  std::vector<Simulation>
    kept; // their memory may lie above that of the simulations that end, where it keeps the heap from shrinking
  long before = 0;
  long held = 0;
  for (int n = 0; n < 5; ++n)
  {
    Simulation simulation = simulate(block);
    pull(simulation, block);
    kept.push_back(simulate(little, { 8, 4, 4 }));
    pull(kept.back(), little);
    held = static_cast<long>(simulation.measure().deviceBytes);
    before = n == 0 ? resident() : before;
  }
  // A driver may free the last buffers a little later, on a busy machine much later.
  long more = resident() - before;
  for (int n = 0; n < 6000 && more >= -held / 3; ++n)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    more = resident() - before;
  }
  std::cout << "held: " << (held >> 20) << '\n';
  std::cout << "more: " << (more >> 20) << '\n';
  return 0;
}
const ChildPart severalPart("severalInSuccession", severalInSuccession);

#ifdef __linux__
int systemHasNoMoreMemory()
{
  const RigidBlock block({ 160, 160, 160 });
  pullAfter("before", { 12, 10, 8 }); // compiles all kernels
  std::ifstream pages("/proc/self/statm");
  rlim_t used = 0;
  pages >> used;
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = used * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t(60) << 20);
  setrlimit(RLIMIT_AS, &limit);
  {
    Simulation simulation = simulate(block);
    pull(simulation, block);
  }
  pullAfter("after", { 12, 10, 8 });
  return 0;
}
const ChildPart systemPart("systemHasNoMoreMemory", systemHasNoMoreMemory);
#endif

/// The number in `text` after `before`, -1 if there is none.
long numberBehind(const std::string& text, const std::string& before)
{
  const std::size_t at = text.find(before);
  return at == std::string::npos ? -1 : std::strtol(text.c_str() + at + before.size(), nullptr, 10);
}

ChildResult runWithLittleMemory(const std::string& name)
{
  return runChild({ isSmall() ? std::pair("HOST_OPENCL_MEMORY", "16") : std::pair("POCL_MEMORY_LIMIT", "1") }, name);
}

void expectClearMessage(const ChildResult& child)
{
  EXPECT_EQ(child.status, 0) << child.output;
  const std::string all = isSmall() ? "16 MiB" : "1024 MiB";
  ASSERT_TRUE(contains(child.output, "device: " + all)) << child.output;
  EXPECT_TRUE(contains(child.output, "message: The device \"")) << child.output;
  EXPECT_TRUE(contains(child.output, "has too little memory for ")) << child.output;
  EXPECT_TRUE(contains(child.output, "of " + all + " in all")) << "what there is is not said: " << child.output;
  EXPECT_TRUE(contains(child.output, "Crop the scan")) << "what to do is not said: " << child.output;
  // A failed simulation keeps its memory until its destruction. A small one fits while it exists, one of any size
  // afterwards.
  EXPECT_TRUE(contains(child.output, "next: 960 displaced, reached 1,")) << child.output;
  EXPECT_TRUE(
    contains(child.output, "after: " + std::string(isSmall() ? "163840" : "10485760") + " displaced, reached 1,"))
    << child.output;
}

TEST(Memory, ABufferLargerThanTheDeviceTakesSaysHowMuchIsNeeded)
{
  const ChildResult child = runWithLittleMemory("tooLargeInOnePiece");
  expectClearMessage(child);
  const long piece = numberBehind(child.output, "MiB, ");
  EXPECT_TRUE(isSmall() ? piece == 4 : piece == 256 || piece == 1024) << child.output;
  EXPECT_EQ(numberBehind(child.output, "largest single buffer is "), piece) << child.output;
  EXPECT_GT(numberBehind(child.output, ": needed are "), piece) << child.output;
  EXPECT_EQ(numberBehind(child.output, "an image of "), isSmall() ? 0 : (piece == 256 ? 22 : 26))
    << "what would fit: " << child.output;
}

TEST(Memory, BuffersThatTogetherDoNotFitSayHowMuchIsNeeded)
{
  if (!isSmall())
  {
    GTEST_SKIP() << "PoCL lends more memory in all than it says it has";
  }
  const ChildResult child = runWithLittleMemory("tooManyTogether");
  expectClearMessage(child);
  EXPECT_TRUE(contains(child.output, "CL_MEM_OBJECT_ALLOCATION_FAILURE")) << child.output;
  const long needed = numberBehind(child.output, ": needed are ");
  EXPECT_TRUE(needed > 0 && needed <= 4) << "each buffer should fit by itself: " << child.output;
  const long simulations = numberBehind(child.output, "simulations: ");
  EXPECT_TRUE(simulations == 3 || simulations == 4) << child.output;
}

// Sanitizers reserve more addresses than any limit allows.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Memory, ASystemWithoutMoreMemorySaysHowMuchIsNeeded)
{
  if (!isSmall() && !device().gpu)
  {
    const ChildResult child = runChild({}, "systemHasNoMoreMemory");
    EXPECT_EQ(child.status, 0) << child.output;
    EXPECT_TRUE(contains(child.output, "message: The device \"")) << child.output;
    EXPECT_TRUE(contains(child.output, "mmap: CL_MEM_OBJECT_ALLOCATION_FAILURE")) << child.output;
    EXPECT_TRUE(contains(child.output, "Crop the scan")) << "what to do is not said: " << child.output;
    EXPECT_TRUE(contains(child.output, "after: 960 displaced, reached 1,")) << child.output;
  }
}
#endif

TEST(Memory, WhatADeformationTookGoesBackToTheSystem)
{
  if (isSmall() || device().gpu || resident() == 0)
  {
    GTEST_SKIP() << "for processors, on systems that tell how much memory a process has";
  }
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer keeps what is freed, and takes memory of its own";
#endif
  const ChildResult child = runChild({}, "severalInSuccession");
  EXPECT_EQ(child.status, 0) << child.output;
  const long held = numberBehind(child.output, "held: ");
  EXPECT_GT(held, 20) << child.output;
  // A simulation frees all its memory at its end. The small ones since then took some MB.
  EXPECT_LT(numberBehind(child.output, "more: "), -held / 3) << child.output;
}

}
