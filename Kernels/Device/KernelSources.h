#pragma once

#include <string>
#include <vector>

namespace chainmail::detail
{

/// The text of an OpenCL file of the engine (`relax.cl`, `element.clh`, ...) as it was when the engine was built, with
/// a #line directive in front. Null where there is no such file. The caller has to expand the includes in it.
const char* kernelSource(const std::string& fileName);

/// The names of all these files.
std::vector<std::string> kernelFiles();

/// A hash of the texts of all these files.
const char* kernelsHash();

}
