#pragma once

#include <functional>
#include <map>
#include <string>

/// Child processes for tests that need another environment (no OpenCL platform, little device memory). Drivers read
/// their environment once, so a test that changes it needs a new process.

struct ChildResult
{
  int status = -1; ///< exit status; -1 after a signal
  std::string output;
};

/// Runs the part called `name` in a child process with additional variables in its environment.
ChildResult runChild(const std::map<std::string, std::string>& environment, const std::string& name);

/// Registers a part; to be defined at namespace scope. `run` prints the results for the test and returns the exit
/// status.
struct ChildPart
{
  ChildPart(const std::string& name, std::function<int()> run);
};
