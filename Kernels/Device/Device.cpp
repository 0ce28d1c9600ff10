#include "Device.h"

#include "Context.h"
#include "Error.h"
#include "Notices.h"
#include "PoclCache.h"
#include "Process.h"
#include "Trial.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <tuple>

namespace chainmail
{

namespace
{

std::string lower(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Strings from drivers may have blanks around them and a zero at the end.
std::string trimmed(std::string text)
{
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  const auto first = text.find_first_not_of(" \t");
  const auto last = text.find_last_not_of(" \t");
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

/// Whether a platform is known to work: PoCL (on which all tests run), a driver of a maker of GPUs, or the kernels
/// compiled as C++.
bool isKnown(const std::string& platform)
{
  const char* const known[] = { "Portable Computing Language", "NVIDIA", "AMD Accelerated", "Intel(R) OpenCL Graphics",
    "Intel(R) OpenCL HD Graphics", "Apple", "ARM Platform", "QUALCOMM", "Host C++" };
  return std::any_of(std::begin(known), std::end(known),
    [&](const char* name) { return platform.compare(0, std::char_traits<char>::length(name), name) == 0; });
}

DeviceInfo describe(const cl::Device& device)
{
  DeviceInfo info;
  info.name = trimmed(device.getInfo<CL_DEVICE_NAME>());
  info.platform = trimmed(cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>());
  info.driver = trimmed(device.getInfo<CL_DRIVER_VERSION>());
  info.gpu = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
  info.sharesMemory = !info.gpu || device.getInfo<CL_DEVICE_HOST_UNIFIED_MEMORY>() != CL_FALSE;
  info.globalMemory = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
  info.maxAllocation = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
  info.computeUnits = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  info.floatsAtOnce = device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>();
  return info;
}

/// The devices as the drivers list them. A platform that fails, for example a driver without its card, loses only its
/// own devices.
std::vector<cl::Device> askPlatforms()
{
  std::vector<cl::Platform> platforms;
  try
  {
    cl::Platform::get(&platforms);
  }
  catch (const cl::Error&)
  {
    return {};
  }
  std::vector<cl::Device> devices;
  for (const cl::Platform& platform : platforms)
  {
    try
    {
      std::vector<cl::Device> ofPlatform;
      platform.getDevices(CL_DEVICE_TYPE_ALL, &ofPlatform);
      for (const cl::Device& device : ofPlatform)
      {
        if (device.getInfo<CL_DEVICE_AVAILABLE>() && device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>())
        {
          devices.push_back(device);
        }
      }
    }
    catch (const cl::Error&)
    {
    }
  }
  return devices;
}

/// All devices, best first.
std::vector<FoundDevice> findDevices()
{
  // At the first call a driver searches for its devices. Some drivers fail if a second call comes at the same time.
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  requireOwnOpenCL();
  const PoclCacheNamed named;
  const std::vector<cl::Device> handles = askPlatforms();
  std::vector<DeviceInfo> infos;
  std::transform(handles.begin(), handles.end(), std::back_inserter(infos), describe);
  makeNamesUnique(infos);
  std::vector<FoundDevice> devices;
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    infos[n].proven = isKnown(infos[n].platform) || (infos[n].gpu && hasPassedTrial(infos[n]));
    devices.push_back({ handles[n], infos[n] });
  }
  std::stable_sort(devices.begin(), devices.end(),
    [](const FoundDevice& a, const FoundDevice& b) { return isBetter(a.info, b.info); });
  return devices;
}

/// Gives notice of each GPU if the best device is not a GPU.
void noticePassedOver(const std::vector<FoundDevice>& devices)
{
  const DeviceInfo& best = devices.front().info;
  for (const FoundDevice& device : devices)
  {
    if (device.info.gpu && !best.gpu)
    {
      giveNotice("\"" + best.name + "\" is used instead of the GPU \"" + device.info.name +
                 "\", because the GPU's driver (" + device.info.platform +
                 ") is not by its maker and has not been tested with the kernels. To use the GPU, set Device to its "
                 "name. ChainMailCompileAhead, which ParaView starts with the plugin, tests the GPU; if the test "
                 "passes, later starts use it.");
    }
  }
}

}

bool isBetter(const DeviceInfo& a, const DeviceInfo& b)
{
  return std::tie(a.proven, a.gpu, a.computeUnits) > std::tie(b.proven, b.gpu, b.computeUnits);
}

void makeNamesUnique(std::vector<DeviceInfo>& devices)
{
  std::map<std::string, std::set<std::string>> platforms;
  for (const DeviceInfo& device : devices)
  {
    platforms[device.name].insert(device.platform);
  }
  for (DeviceInfo& device : devices)
  {
    const auto of = platforms.find(device.name);
    device.name += of->second.size() > 1 ? " (" + device.platform + ")" : "";
  }
  for (auto device = devices.begin(); device != devices.end(); ++device)
  {
    const std::string name = device->name;
    for (int number = 2;
         std::any_of(devices.begin(), device, [&](const DeviceInfo& one) { return one.name == device->name; });
         ++number)
    {
      device->name = name + " (" + std::to_string(number) + ")";
    }
  }
}

FoundDevice findDevice(const std::string& name)
{
  const std::vector<FoundDevice> devices = findDevices();
  if (devices.empty())
  {
    const std::string problem = problemOfPoclCache();
    throw DeviceError("No OpenCL device was found. Install the driver of your graphics card, or PoCL to run on the "
                      "processor (Debian and Ubuntu: apt-get install pocl-opencl-icd), and try again." +
                      (problem.empty() ? problem : ' ' + problem));
  }
  if (name.empty())
  {
    noticePassedOver(devices);
    return devices.front();
  }
  const std::string wanted = lower(trimmed(name));
  std::string known;
  for (const FoundDevice& device : devices)
  {
    if (lower(device.info.name) == wanted)
    {
      return device;
    }
    known += (known.empty() ? "\"" : ", \"") + device.info.name + "\"";
  }
  for (const FoundDevice& device : devices)
  {
    if (lower(device.info.name).find(wanted) != std::string::npos)
    {
      return device;
    }
  }
  throw DeviceError("No OpenCL device has a name that contains \"" + name + "\". This machine has: " + known +
                    ". Choose one of these, or leave Device empty for the best one.");
}

std::vector<DeviceInfo> listDevices()
{
  return translated(
    []
    {
      std::vector<DeviceInfo> list;
      for (const FoundDevice& device : findDevices())
      {
        list.push_back(device.info);
      }
      return list;
    });
}

DeviceInfo chooseDevice(const std::string& name)
{
  return translated([&] { return findDevice(name).info; });
}

}
