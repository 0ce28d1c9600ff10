#pragma once

namespace chainmail
{

/// A process that is forked from one with OpenCL has the memory of the drivers but none of their threads, so each call
/// of OpenCL may wait for ever, even one that releases something.

/// To be called before each use of OpenCL. Throws DeviceError in a process that was forked from one that has used it.
void requireOwnOpenCL();

/// Whether this is such a process.
bool isForkedFromOpenCL();

}
