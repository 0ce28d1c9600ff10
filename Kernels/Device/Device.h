#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace chainmail
{

/// An OpenCL device as its driver describes it.
struct DeviceInfo
{
  std::string name;
  std::string platform;
  bool gpu = false;
  std::size_t globalMemory = 0;  ///< [bytes]
  std::size_t maxAllocation = 0; ///< largest single buffer [bytes]
  unsigned computeUnits = 0;
  unsigned floatsAtOnce = 0; ///< in the vectors that the device has instructions for
};

/// All usable devices of this machine, best first: GPUs by compute units, then the others. Empty when OpenCL has no
/// platform or no device.
std::vector<DeviceInfo> listDevices();

/// The device that `name` asks for: the best one for "", else the first whose name contains `name`, whether in upper or
/// lower case. Throws DeviceError, which names the devices that there are, where none does.
DeviceInfo chooseDevice(const std::string& name);

}
