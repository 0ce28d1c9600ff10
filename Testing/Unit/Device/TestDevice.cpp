#include "ChildProcess.h"
#include "Device.h"
#include "Scene.h"

#include <algorithm>
#include <cctype>
#include <iostream>

namespace
{

using namespace chainmail;

TEST(Device, AllDevicesAreDescribedBestFirst)
{
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_FALSE(devices.empty()) << "these tests need an OpenCL device";
  bool processor = false;
  for (const DeviceInfo& device : devices)
  {
    EXPECT_FALSE(device.name.empty());
    EXPECT_FALSE(device.platform.empty());
    EXPECT_GT(device.computeUnits, 0u);
    EXPECT_GT(device.maxAllocation, 0u);
    EXPECT_LE(device.maxAllocation, device.globalMemory);
    EXPECT_FALSE(device.gpu && processor) << "a GPU stands behind a processor: " << device.name;
    processor = processor || !device.gpu;
  }
  EXPECT_EQ(chooseDevice("").name, devices.front().name);
}

TEST(Device, IsChosenByAPartOfItsNameInAnyCase)
{
  for (const DeviceInfo& device : listDevices())
  {
    // The first whose name contains it: another device may stand before and have the same name.
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

// An empty folder of drivers is what a fresh machine has.
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
