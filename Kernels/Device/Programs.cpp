#include "Programs.h"

#include "Context.h"
#include "Error.h"
#include "KernelSources.h"
#include "Pocl.h"
#include "PoclCache.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

namespace chainmail
{

std::string sourceOf(const std::string& file)
{
  std::istringstream lines(detail::kernelSource(file));
  std::ostringstream text;
  int number = -1; // line 0 is the #line directive
  for (std::string line; std::getline(lines, line);)
  {
    ++number;
    const std::string include = "#include \"";
    if (line.compare(0, include.size(), include) == 0)
    {
      const std::string header = line.substr(include.size(), line.find('"', include.size()) - include.size());
      text << sourceOf(header) << "#line " << number + 1 << " \"" << file << "\"\n";
    }
    else
    {
      text << line << '\n';
    }
  }
  return text.str();
}

namespace
{

/// A key that names everything that a driver's compiled program depends on.
std::string programKey(const cl::Device& device, const std::string& options, const std::string& source)
{
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  std::string key;
  for (const std::string& part : { platform.getInfo<CL_PLATFORM_NAME>(), platform.getInfo<CL_PLATFORM_VERSION>(),
         device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DEVICE_VENDOR>(), device.getInfo<CL_DEVICE_VERSION>(),
         device.getInfo<CL_DRIVER_VERSION>(), options, source })
  {
    key += part + '\n';
  }
  return key;
}

/// The driver's compiled program for this device; empty if the driver does not return it.
std::string binaryOf(const cl::Program& program)
{
  try
  {
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    return binaries.empty() ? std::string() : std::string(binaries.front().begin(), binaries.front().end());
  }
  catch (const cl::Error&)
  {
    return {};
  }
}

/// A program from a driver's own binary, or from bitcode; nothing if the driver rejects it.
std::optional<cl::Program> accepted(
  const cl::Device& device, const cl::Context& context, const std::string& kept, const std::string& options)
{
  if (kept.empty())
  {
    return std::nullopt;
  }
  try
  {
    cl::Program program(context, { device }, { { kept.begin(), kept.end() } });
    program.build({ device }, options.c_str());
    return program;
  }
  catch (const cl::Error&)
  {
    return std::nullopt;
  }
}

cl::Program build(const cl::Device& device, const cl::Context& context, const ProgramCache& cache,
  const std::string& file, const std::string& options)
{
  const bool pocl = isPocl(device);
  if (pocl)
  {
    requirePoclCache();
  }
  const std::string source = sourceOf(file);
  const std::string key = programKey(device, options, detail::kernelSource("builtins.clh") + source);
  if (const auto program = accepted(device, context, cache.find(key), options))
  {
    return *program;
  }
  WhileCompiling::report();
  for (int wholeHeader = 0; pocl && wholeHeader < 2; ++wholeHeader)
  {
    const std::string bitcode = poclBitcode(device, source, options, wholeHeader == 1);
    if (const auto program = accepted(device, context, bitcode, options))
    {
      cache.keep(key, [&] { return bitcode; });
      return *program;
    }
  }
  cl::Program program(context, source);
  try
  {
    program.build({ device }, options.c_str());
  }
  catch (const cl::Error& error)
  {
    if (pocl)
    {
      requirePoclCache(); // the folder may be the cause
    }
    throw DeviceError(std::string("OpenCL call ") + error.what() + " failed with " + errorName(error.err()) + " for " +
                      file + " on \"" + device.getInfo<CL_DEVICE_NAME>() +
                      "\": " + program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device));
  }
  cache.keep(key, [&] { return binaryOf(program); });
  return program;
}

}

thread_local WhileCompiling* WhileCompiling::current_ = nullptr;

void WhileCompiling::report()
{
  if (current_)
  {
    current_->report_();
  }
}

void WhileCompiling::wait(const std::function<bool(std::chrono::microseconds)>& done)
{
  // Programs from the cache are ready within the first steps, without a report.
  std::chrono::microseconds step(50);
  std::chrono::microseconds waited(0);
  while (!done(step))
  {
    waited += step;
    step = std::min(2 * step, std::chrono::microseconds(50000));
    if (waited >= std::chrono::milliseconds(20))
    {
      WhileCompiling::report();
    }
  }
}

bool Program::wasLaunched(const std::string& kernel, std::size_t items)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  return this->launched_.count({ kernel, items }) > 0;
}

void Program::noteLaunch(const std::string& kernel, std::size_t items)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  this->launched_.insert({ kernel, items });
}

std::shared_ptr<Program> Programs::program(const std::string& file, const std::string& defines)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  std::shared_ptr<Program>& program = this->programs_[file + ' ' + defines];
  if (!program)
  {
    program =
      std::make_shared<Program>(build(this->device_, this->context_, this->cache_, file, "-cl-std=CL1.2 " + defines));
  }
  return program;
}

}
