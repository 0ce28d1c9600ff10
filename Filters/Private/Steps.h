// SPDX-License-Identifier: BSD-3-Clause
// The steps of one process between exchanges with other processes.

#ifndef Steps_h
#define Steps_h

#include <exception>
#include <stdexcept>

namespace vtkChainMail
{

/// Thrown in a process that cannot go on because another one has failed, which has the message for the user.
struct FailedElsewhere : std::runtime_error
{
  FailedElsewhere()
    : std::runtime_error("Another process could not complete the update.")
  {
  }
};

/// After a step has thrown, further steps are left out. Exchanges go on, so no process waits for another one for ever.
class Steps
{
public:
  template <typename F> void Run(F&& step)
  {
    if (!this->Problem)
    {
      this->Exchange(step);
    }
  }

  /// Runs an exchange in which other processes take part: even after a step has failed.
  template <typename F> void Exchange(F&& step)
  {
    try
    {
      step();
    }
    catch (...)
    {
      this->Problem = this->Problem ? this->Problem : std::current_exception();
    }
  }

  bool HaveFailed() const { return this->Problem != nullptr; }

  /// To be called after the last exchange: throws what a step has thrown.
  void End() const
  {
    if (this->Problem)
    {
      std::rethrow_exception(this->Problem);
    }
  }

private:
  std::exception_ptr Problem;
};

}

#endif
