#pragma once

#include <functional>
#include <map>
#include <string>

/// A test that needs another environment (no OpenCL platform, little device memory) runs a part of itself in a child
/// process, because drivers read their environment once.

struct ChildResult
{
  int status = -1; ///< exit status; -1 where it did not exit by itself
  std::string output;
};

/// Runs the part called `name` in a child whose environment has these variables more.
ChildResult runChild(const std::map<std::string, std::string>& environment, const std::string& name);

/// Makes a part known: define one at namespace scope. `run` prints what the test looks at and returns the exit status.
struct ChildPart
{
  ChildPart(const std::string& name, std::function<int()> run);
};
