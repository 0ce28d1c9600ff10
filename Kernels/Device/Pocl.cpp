#include "Pocl.h"

#include "KernelSources.h"

#include <cstdint>
#include <random>
#include <vector>

namespace chainmail
{

namespace
{

/// The content of the file of this name in a binary of PoCL. Between the name and the content of each file stands its
/// length, 4 bytes, lowest first. Empty if there is no such file.
std::string fileIn(const std::vector<unsigned char>& binary, const std::string& name)
{
  const std::string all(binary.begin(), binary.end());
  const std::size_t at = all.find(name);
  const std::size_t begin = at + name.size() + 4;
  if (at == std::string::npos || begin > all.size())
  {
    return {};
  }
  std::uint32_t length = 0;
  for (std::size_t n = 1; n <= 4; ++n)
  {
    length = length << 8 | binary[begin - n];
  }
  return length <= all.size() - begin ? all.substr(begin, length) : std::string();
}

/// A compiler option that is unique to this process. PoCL names a program's folder after its source and options. When
/// it returns a binary it reads all files there, and it ends the process if one disappears meanwhile. Unfinished files
/// of another process that compiles the same program do disappear. So each process needs a folder of its own.
std::string optionOfThisProcess()
{
  static const std::uint64_t number = std::uint64_t(std::random_device()()) << 32 | std::random_device()();
  return " -DCHAINMAIL_PROCESS=" + std::to_string(number);
}

}

bool isPocl(const cl::Device& device)
{
  const std::string name = cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>();
  return name.find("Portable Computing Language") != std::string::npos;
}

std::string poclBitcode(
  const cl::Device& device, const std::string& source, const std::string& options, bool wholeHeader)
{
  try
  {
    const cl::Context context(device);
    const char* const noHeader = " -D_OPENCL_H_"; // the include guard of Clang's header, which is then skipped
    cl::Program program(context, wholeHeader ? source : detail::kernelSource("builtins.clh") + source);
    program.compile((options + (wholeHeader ? "" : noHeader) + optionOfThisProcess()).c_str());
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    const std::string bitcode = binaries.empty() ? std::string() : fileIn(binaries.front(), "/program.bc");
    return bitcode.compare(0, 2, "BC") == 0 ? bitcode : std::string();
  }
  catch (const cl::Error&)
  {
    return {};
  }
}

}
