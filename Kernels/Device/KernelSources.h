#pragma once

#include <string>

namespace chainmail::detail
{

/// The text of an OpenCL file of the engine (`relax.cl`, `element.clh`, ...) as it was when the engine was built, led
/// by a #line directive. Null where there is no such file. Includes in the text are left to the caller.
const char* kernelSource(const std::string& fileName);

}
