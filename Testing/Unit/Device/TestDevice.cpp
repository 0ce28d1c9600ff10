#include "ChildProcess.h"
#include "Device.h"
#include "Scene.h"

#include <algorithm>
#include <cctype>
#include <iostream>
#include <set>
#include <sstream>

namespace
{

using namespace chainmail;

TEST(Device, AllDevicesAreDescribedBestFirst)
{
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_FALSE(devices.empty()) << "these tests need an OpenCL device";
  for (const DeviceInfo& device : devices)
  {
    EXPECT_FALSE(device.name.empty());
    EXPECT_FALSE(device.platform.empty());
    EXPECT_GT(device.computeUnits, 0u);
    EXPECT_GT(device.maxAllocation, 0u);
    EXPECT_LE(device.maxAllocation, device.globalMemory);
  }
  for (std::size_t n = 1; n < devices.size(); ++n)
  {
    EXPECT_FALSE(isBetter(devices[n], devices[n - 1])) << devices[n].name << " stands behind " << devices[n - 1].name;
  }
  EXPECT_EQ(chooseDevice("").name, devices.front().name);
}

// An unknown driver may end the process, so a processor is preferred to its GPU.
TEST(Device, ProvenOnesAreBest)
{
  const auto device = [](bool proven, bool gpu, unsigned units)
  {
    DeviceInfo info;
    info.proven = proven;
    info.gpu = gpu;
    info.computeUnits = units;
    return info;
  };
  const std::vector<DeviceInfo> order{ device(true, true, 8), device(true, true, 2), device(true, false, 16),
    device(true, false, 4), device(false, true, 99), device(false, false, 128) };
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    for (std::size_t m = 0; m < order.size(); ++m)
    {
      EXPECT_EQ(isBetter(order[n], order[m]), n < m) << n << ' ' << m;
    }
  }
}

// llvmpipe ends the loops of a work-item early, which would break batches of sweeps. The check `rusticl` shows that its
// results are right.
TEST(Device, GpusAndLlvmpipeTakeManyWorkItems)
{
  DeviceInfo info;
  info.name = "pthread-haswell-AMD EPYC";
  EXPECT_FALSE(info.takesManyItems());
  info.name = "llvmpipe (LLVM 15.0.6, 256 bits)";
  EXPECT_TRUE(info.takesManyItems());
  info.name = "NVIDIA H200";
  EXPECT_FALSE(info.takesManyItems()) << "the name says nothing of other devices";
  info.gpu = true;
  EXPECT_TRUE(info.takesManyItems());
}

TEST(Device, NoTwoHaveOneName)
{
  const auto names = [](std::vector<std::pair<std::string, std::string>> all)
  {
    std::vector<DeviceInfo> devices;
    for (const auto& [name, platform] : all)
    {
      devices.emplace_back();
      devices.back().name = name;
      devices.back().platform = platform;
    }
    makeNamesUnique(devices);
    std::vector<std::string> unique;
    for (const DeviceInfo& one : devices)
    {
      unique.push_back(one.name);
    }
    return unique;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names({ { "A", "X" }, { "B", "Y" } }), (Names{ "A", "B" }));
  EXPECT_EQ(names({ { "A", "X" }, { "B", "X" }, { "A", "X" }, { "A", "X" } }), (Names{ "A", "B", "A (2)", "A (3)" }));
  EXPECT_EQ(names({ { "A", "X" }, { "A", "Y" }, { "B", "Y" } }), (Names{ "A (X)", "A (Y)", "B" }));
  EXPECT_EQ(names({ { "A", "X" }, { "A", "Y" }, { "A", "Y" } }), (Names{ "A (X)", "A (Y)", "A (Y) (2)" }));
  EXPECT_EQ(names({ { "A (2)", "X" }, { "A", "X" }, { "A", "X" } }), (Names{ "A (2)", "A", "A (3)" }));
}

const ChildPart twinsPart("twins",
  []
  {
    const std::vector<DeviceInfo> devices = listDevices();
    for (const DeviceInfo& device : devices)
    {
      Settings settings;
      settings.device = device.name;
      const Scene scene({ 4, 4, 4 });
      std::cout << "twin " << device.name << " is " << Simulation(scene.model(), settings).deviceName() << '\n';
    }
    return static_cast<int>(devices.size());
  });

// Two devices of the same name.
TEST(Device, TwoOfOneNameAreToldApart)
{
  const ChildResult child = runChild({ { "POCL_DEVICES", "basic basic" }, { "RUSTICL_ENABLE", "" } }, "twins");
  if (child.status == 1 || !contains(child.output, "basic"))
  {
    GTEST_SKIP() << "PoCL is not there, or not alone";
  }
  EXPECT_EQ(child.status, 2) << child.output;
  std::istringstream lines(child.output);
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);)
  {
    const std::size_t is = line.find(" is ");
    if (line.compare(0, 5, "twin ") == 0)
    {
      EXPECT_EQ(line.substr(5, is - 5), line.substr(is + 4));
      names.insert(line.substr(is + 4));
    }
  }
  EXPECT_EQ(names.size(), 2u) << child.output;
}

TEST(Device, IsChosenByAPartOfItsNameInAnyCase)
{
  for (const DeviceInfo& device : listDevices())
  {
    // The first device whose name contains the text: another device with the same name may be earlier in the list.
    EXPECT_EQ(chooseDevice(device.name).name, device.name);
    std::string loud = device.name.substr(device.name.size() / 3);
    std::transform(loud.begin(), loud.end(), loud.begin(), [](unsigned char c) { return std::toupper(c); });
    const std::string chosen = chooseDevice(loud).name;
    EXPECT_TRUE(contains(chosen, device.name.substr(device.name.size() / 3))) << chosen;
  }
}

TEST(Device, NoMatchNamesWhatThereIs)
{
  const std::string message = messageOf<DeviceError>([] { chooseDevice("no such machine"); });
  EXPECT_TRUE(contains(message, "no such machine")) << message;
  for (const DeviceInfo& device : listDevices())
  {
    EXPECT_TRUE(contains(message, device.name)) << message;
  }
}

TEST(Device, SimulationSaysWhereItRuns)
{
  Scene scene({ 4, 4, 4 });
  EXPECT_EQ(simulate(scene).deviceName(), chooseDevice(testDevice()).name);

  Settings settings;
  settings.device = "no such machine";
  const std::string message = messageOf<DeviceError>([&] { Simulation(scene.model(), settings); });
  EXPECT_TRUE(contains(message, "no such machine")) << message;
}

int withoutPlatform()
{
  std::cout << "devices: " << listDevices().size() << '\n';
  Scene scene({ 4, 4, 4 });
  for (const char* name : { "", "pocl" })
  {
    try
    {
      Settings settings;
      settings.device = name;
      Simulation simulation(scene.model(), settings);
      std::cout << "a simulation ran\n";
    }
    catch (const DeviceError& error)
    {
      std::cout << "message: " << error.what() << '\n';
    }
  }
  return 0;
}
const ChildPart noPlatformPart("noPlatform", withoutPlatform);

// A new machine has an empty folder of drivers.
TEST(Device, NoPlatformIsAClearMessage)
{
  const ChildResult child = runChild({ { "OCL_ICD_VENDORS", "/nonexistent" } }, "noPlatform");
  EXPECT_EQ(child.status, 0) << child.output;
  EXPECT_TRUE(contains(child.output, "devices: 0")) << child.output;
  EXPECT_FALSE(contains(child.output, "a simulation ran")) << child.output;
  EXPECT_TRUE(contains(child.output, "message: No OpenCL device was found")) << child.output;
  EXPECT_TRUE(contains(child.output, "nstall")) << "what to do is not said: " << child.output;
}

}
