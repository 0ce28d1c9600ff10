#include "Device.h"

#include "Context.h"
#include "Error.h"

#include <algorithm>
#include <cctype>
#include <mutex>

namespace chainmail
{

namespace
{

std::string lower(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Driver strings may have blanks around them and a zero at the end.
std::string trimmed(std::string text)
{
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  const auto first = text.find_first_not_of(" \t");
  const auto last = text.find_last_not_of(" \t");
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

/// All devices, best first. A platform that fails, say a driver without its card, hides only its own devices.
std::vector<cl::Device> findDevices()
{
  // The first call makes a driver look for its devices; some drivers do not bear a second call at the same time.
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
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
  const auto rank = [](const cl::Device& device)
  {
    const bool gpu = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
    return std::make_pair(gpu, device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>());
  };
  std::stable_sort(
    devices.begin(), devices.end(), [&](const cl::Device& a, const cl::Device& b) { return rank(a) > rank(b); });
  return devices;
}

}

DeviceInfo describe(const cl::Device& device)
{
  DeviceInfo info;
  info.name = trimmed(device.getInfo<CL_DEVICE_NAME>());
  info.platform = trimmed(cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>());
  info.gpu = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
  info.globalMemory = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
  info.maxAllocation = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
  info.computeUnits = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  info.floatsAtOnce = device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>();
  return info;
}

cl::Device findDevice(const std::string& name)
{
  const std::vector<cl::Device> devices = findDevices();
  if (devices.empty())
  {
    throw DeviceError("No OpenCL device was found. Install the driver of your graphics card, or PoCL to run on the "
                      "processor (Debian and Ubuntu: apt-get install pocl-opencl-icd), and try again.");
  }
  std::string known;
  for (const cl::Device& device : devices)
  {
    const DeviceInfo info = describe(device);
    if (lower(info.name).find(lower(name)) != std::string::npos)
    {
      return device;
    }
    known += (known.empty() ? "\"" : ", \"") + info.name + "\"";
  }
  throw DeviceError("No OpenCL device has a name that contains \"" + name + "\". This machine has: " + known +
                    ". Leave the name empty for the best one.");
}

std::vector<DeviceInfo> listDevices()
{
  std::vector<DeviceInfo> list;
  for (const cl::Device& device : findDevices())
  {
    list.push_back(describe(device));
  }
  return list;
}

DeviceInfo chooseDevice(const std::string& name)
{
  return translated([&] { return describe(findDevice(name)); });
}

}
