// GoogleTest's main function. The option `--child=NAME` runs a part of a test, see ChildProcess.h.

#include "ChildProcess.h"
#include "Environment.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <list>
#ifndef _WIN32
#include <sys/wait.h>
#endif

namespace
{

std::string program; // path of this program

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

ChildResult runChild(const std::map<std::string, std::string>& environment, const std::string& name)
{
  std::list<Variable> variables;
  for (const auto& [variable, value] : environment)
  {
    variables.emplace_back(variable, value.c_str());
  }
  const std::string command = '"' + program + "\" --child=" + name + " 2>&1";
  ChildResult result;
#ifdef _WIN32
  FILE* pipe = _popen(('"' + command + '"').c_str(), "rb"); // the shell there takes the outer quotes away
#else
  FILE* pipe = popen(command.c_str(), "r");
#endif
  if (!pipe)
  {
    return {};
  }
  char buffer[4096];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe))
  {
    result.output.append(buffer, n);
  }
#ifdef _WIN32
  result.status = _pclose(pipe);
#else
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
#endif
  return result;
}

int main(int argc, char** argv)
{
  program = std::filesystem::absolute(argv[0]).string();
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
  // New buffers are poisoned (Testing/README.md), in child processes, too.
  const Variable poison("CHAINMAIL_POISON_BUFFERS", "1");
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
