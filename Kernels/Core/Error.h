#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace chainmail
{

/// Base of everything the engine throws. The message is one sentence or more for the person at the screen: what is
/// wrong and what to do about it.
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

/// A probe cannot be used as it is.
class ProbeError : public InputError
{
public:
  /// `problem` follows `name`, which tells the engine's caller which one it is.
  ProbeError(std::size_t number, const std::string& name, const std::string& problem)
    : InputError(name + " " + problem)
    , probe(number)
    , problem(problem)
  {
  }

  std::size_t probe;   ///< its place in the list
  std::string problem; ///< the message without its name, for callers with another name for it
};

/// OpenCL is missing, has no such device, or a call of it failed. The message holds the call, its error code by name
/// and, for a kernel that did not build, the compiler's log.
class DeviceError : public Error
{
public:
  using Error::Error;
};

/// The device cannot hold what the scene touches. The message says how much is needed and how much there is.
class MemoryError : public DeviceError
{
public:
  using DeviceError::DeviceError;
};

/// A progress callback asked to stop. The simulation can be used further; Simulation tells in which state it is.
class Aborted : public Error
{
public:
  Aborted()
    : Error("Stopped on request.")
  {
  }
};

}
