#pragma once

#include <memory>
#include <string>

namespace bench
{

/// Bytes that memory moves in a second, read and written ones counted [GB/s].
struct Bandwidth
{
  double deviceTriad = 0.0; ///< a = b + s c in OpenCL, 12 bytes an element
  double deviceCopy = 0.0;  ///< a = b in OpenCL, 8 bytes an element
  double hostTriad = 0.0;   ///< the same in C++, on all cores
  double hostCopy = 0.0;
};

/// The limits of the machine that a benchmark runs on.
class Machine
{
public:
  Machine(const std::string& deviceName, bool small);
  ~Machine();

  const std::string& device() const;   ///< name of the OpenCL device
  const std::string& platform() const; ///< and of its driver
  unsigned computeUnits() const;
  bool gpu() const;

  /// The best of a few passes over arrays that no cache holds (small: of any size, to see that it runs).
  Bandwidth measure();

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The processor by name, and how many cores there are.
std::string processor();

/// Processes that wanted to run, averaged over the last minute; negative where the system does not tell.
double load();

}
