#include "Programs.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace baseline
{

cl::Program buildProgram(chainmail::Context& context, const std::string& file, const std::string& defines)
{
  const std::string path = std::string(CHAINMAIL_BASELINES) + "/" + file;
  std::ifstream stream(path);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream || text.str().empty())
  {
    throw std::runtime_error("could not read " + path);
  }
  const cl::Context cl = context.queue().getInfo<CL_QUEUE_CONTEXT>();
  cl::Program program(cl, text.str());
  try
  {
    program.build({ context.device() }, ("-cl-std=CL1.2" + defines).c_str());
  }
  catch (const cl::Error&)
  {
    throw std::runtime_error(file + ": " + program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(context.device()));
  }
  return program;
}

}
