#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace chainmail
{

/// An OpenCL device as its driver describes it.
struct DeviceInfo
{
  /// The name that the driver gives, and no two devices have. Devices of one name on several platforms have that of the
  /// platform behind it, "NAME (PLATFORM)"; if that does not suffice, the second is "NAME (2)".
  std::string name;
  std::string platform;
  std::string driver; ///< its version
  bool gpu = false;
  /// Whether the engine is known to work there: processors of PoCL, GPUs by the driver of their maker, and GPUs that
  /// were tried on this machine (Trial.h).
  bool proven = false;
  std::size_t globalMemory = 0;  ///< [bytes]
  std::size_t maxAllocation = 0; ///< largest single buffer [bytes]
  unsigned computeUnits = 0;
  unsigned floatsAtOnce = 0; ///< in the vectors that the device has instructions for

  /// Whether kernels take the shape for GPUs: many work-items without vectors, none of which works for long, in place
  /// of one with vectors for all of a brick. So they do on GPUs, and on llvmpipe, the processor as Mesa's drivers have
  /// it: there the loops of a work-item end after 65,535 turns, without a word.
  bool takesManyItems() const { return this->gpu || this->name.compare(0, 8, "llvmpipe") == 0; }
};

/// Whether a device goes before another: proven GPUs, proven processors, the other GPUs, the other processors, and each
/// of them by compute units.
bool isBetter(const DeviceInfo& a, const DeviceInfo& b);

/// All usable devices of this machine, best first. Empty when OpenCL has no platform or no device. Throws DeviceError
/// in a process that was forked from one that has used OpenCL.
std::vector<DeviceInfo> listDevices();

/// The device that `name` asks for, whether in upper or lower case: the best one for "", else the one of this name,
/// else the first whose name contains it. Throws DeviceError, which names the devices that there are, where none does.
/// For "" gives notice (Notices.h) of a GPU that is not taken since it is not proven.
DeviceInfo chooseDevice(const std::string& name);

/// Gives the devices of a list, in any order, names of which no two are the same.
void makeNamesUnique(std::vector<DeviceInfo>& devices);

}
