#pragma once

#include "Device.h"

#include <functional>

namespace chainmail
{

/// Finds out whether the engine works on a device that is not proven. A compiler of OpenCL may end the process that
/// uses it or never return. So a device is tried once in a process that nobody waits for (ChainMailCompileAhead). The
/// result is kept in the user's cache, for this version of kernels and driver.

/// Whether a trial of this device succeeded.
bool hasPassedTrial(const DeviceInfo& device);

/// Calls `use`, which should run kernels, and throw or end the process if they do not work. Nothing happens if the
/// device was tried before, or if there is no cache to record the trial.
void tryDevice(const DeviceInfo& device, const std::function<void()>& use);

}
