#pragma once

namespace chainmail
{

/// A process forked from one with OpenCL has the memory of the drivers but none of their threads. So each call of
/// OpenCL may block for ever there, even one that releases something.

/// To be called before each use of OpenCL. Throws DeviceError in a process that was forked from one that has used it.
void requireOwnOpenCL();

/// Whether this process was forked from one that has used OpenCL.
bool isForkedFromOpenCL();

}
