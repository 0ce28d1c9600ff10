// The tests' main: as GoogleTest's own, and `--child=NAME` runs a part of a test, see ChildProcess.h.

#include "ChildProcess.h"

#include <gtest/gtest.h>

#include <climits>
#include <cstdio>
#include <iostream>
#include <map>
#include <sys/wait.h>
#include <unistd.h>

namespace
{

std::map<std::string, std::function<int()>>& childParts()
{
  static std::map<std::string, std::function<int()>> parts;
  return parts;
}

}

ChildPart::ChildPart(const std::string& name, std::function<int()> run)
{
  childParts()[name] = std::move(run);
}

ChildResult runChild(const std::string& environment, const std::string& name)
{
  char self[PATH_MAX] = {};
  if (readlink("/proc/self/exe", self, sizeof self - 1) <= 0)
  {
    return {};
  }
  const std::string command = "env " + environment + " '" + self + "' --child=" + name + " 2>&1";
  ChildResult result;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe)
  {
    return {};
  }
  char buffer[4096];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe))
  {
    result.output.append(buffer, n);
  }
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

int main(int argc, char** argv)
{
  const std::string option = argc == 2 ? argv[1] : "";
  const std::string prefix = "--child=";
  if (option.compare(0, prefix.size(), prefix) == 0)
  {
    const auto part = childParts().find(option.substr(prefix.size()));
    if (part == childParts().end())
    {
      std::cerr << "no part of a test is called so: " << option << '\n';
      return 120;
    }
    try
    {
      return part->second();
    }
    catch (const std::exception& error)
    {
      std::cout << "uncaught: " << error.what() << '\n';
      return 121;
    }
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
