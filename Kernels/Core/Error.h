#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace chainmail
{

/// Base of everything the engine throws. The message is one sentence or more for the person at the screen and says what
/// is wrong and what to do about it.
class Error : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// The caller's data cannot be used as it is (no tissue, a probe in air, a constraint outside [0, 1), ...).
class InputError : public Error
{
public:
  using Error::Error;
};

/// A probe cannot be used as it is: there is no tissue at its place, or its position, displacement or radius is
/// invalid.
class ProbeError : public InputError
{
public:
  /// The message is `name`, which tells the caller which probe it is, followed by `problem`.
  ProbeError(std::size_t number, const std::string& name, const std::string& problem)
    : InputError(name + " " + problem)
    , probe(number)
    , problem(problem)
  {
  }

  std::size_t probe;   ///< the probe's place in the list
  std::string problem; ///< the message without `name`, for callers that name the probe differently
};

/// OpenCL is missing, it has no such device, or one of its calls failed. The message names the call and its error code
/// and, for a kernel that did not build, holds the compiler's log.
class DeviceError : public Error
{
public:
  using Error::Error;
};

/// The device has too little memory for the scene. The message says how much is needed and how much there is.
class MemoryError : public DeviceError
{
public:
  using DeviceError::DeviceError;
};

/// A progress callback asked to stop. The simulation can still be used; Simulation documents its state.
class Aborted : public Error
{
public:
  Aborted()
    : Error("Stopped on request.")
  {
  }
};

}
