#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace chainmail
{

/// An OpenCL device as its driver describes it.
struct DeviceInfo
{
  /// The driver's name for the device, made unique. If several platforms have devices of one name, the platform is
  /// appended: "NAME (PLATFORM)". If that is not enough, the second is "NAME (2)".
  std::string name;
  std::string platform;
  std::string driver; ///< its version
  bool gpu = false;
  bool sharesMemory = true; ///< whether it uses the host's memory: a processor, or a GPU without a memory of its own
  /// Whether the engine is known to work on it: processors of PoCL, GPUs with the driver of their maker, and GPUs that
  /// passed a trial on this machine (Trial.h).
  bool proven = false;
  std::size_t globalMemory = 0;  ///< [bytes]
  std::size_t maxAllocation = 0; ///< largest single buffer [bytes]
  unsigned computeUnits = 0;
  unsigned floatsAtOnce = 0; ///< native vector width of the device [floats]

  /// Whether a work-item's loops end after 65,535 iterations altogether, without an error. This is so on llvmpipe,
  /// which is Mesa's driver for processors.
  bool endsLoops() const { return this->name.compare(0, 8, "llvmpipe") == 0; }
  /// Whether kernels run in their form for GPUs: many short work-items without vectors, not a single one with vectors
  /// for a whole brick.
  bool takesManyItems() const { return this->gpu || this->endsLoops(); }
};

/// Whether a device ranks before another: proven GPUs, proven processors, the other GPUs, the other processors, and
/// within each of these by compute units.
bool isBetter(const DeviceInfo& a, const DeviceInfo& b);

/// All usable devices of this machine, best first. Empty when OpenCL has no platform or no device. Throws DeviceError
/// in a process that was forked from one that has used OpenCL.
std::vector<DeviceInfo> listDevices();

/// The device for `name`, in upper or lower case: the best one for "", else the one of this name, else the first whose
/// name contains it. If there is none, throws DeviceError, which lists the existing devices. For "" gives notice
/// (Notices.h) of a GPU that is not used because it is not proven.
DeviceInfo chooseDevice(const std::string& name);

/// Makes the names of the devices of a list unique. The list may have any order.
void makeNamesUnique(std::vector<DeviceInfo>& devices);

}
