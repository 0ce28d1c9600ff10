#pragma once

#include "Device.h"

#include <functional>

namespace chainmail
{

/// Whether the engine works on a device, where that is not known beforehand. A compiler of OpenCL may end the process
/// that uses it or never come to an end. So a device is tried once in a process that nobody waits for
/// (ChainMailCompileAhead), and the outcome is kept in the user's cache, for this version of kernels and driver.

/// Whether a trial of this device came to a good end.
bool hasPassedTrial(const DeviceInfo& device);

/// Calls `use`, which is to run kernels and to throw, or to end the process, where they do not work. Nothing happens
/// where that was done before, or where there is no cache to note it in.
void tryDevice(const DeviceInfo& device, const std::function<void()>& use);

}
