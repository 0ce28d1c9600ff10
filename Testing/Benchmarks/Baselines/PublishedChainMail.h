#pragma once

#include "SerialChainMail.h"

#include <memory>
#include <string>

namespace baseline
{

/// The published parallel methods over a block of tissue without air, in OpenCL, one work-item an element and two
/// copies of the state:
///
/// - SP-ChainMail (The Journal of Supercomputing 2015, doi:10.1007/s11227-015-1445-5): no propagation times, one launch
/// for
///   each active block (PerBlock), or no blocks (Whole).
/// - Rodriguez, Leon and Arroyo: propagation times and wavefronts, one launch over a list of the active blocks
/// (Listed), or
///   no blocks (Whole).
///
/// Both relax all elements at once to the weighted mean of their neighbours, limits ignored. A block is active while
/// something in it or beside it moves.
class PublishedChainMail
{
public:
  enum class Launch
  {
    Whole,
    PerBlock,
    Listed
  };
  struct Method
  {
    Launch launch = Launch::Whole;
    bool timestamps = true;
    std::array<int, 3> block{ 16, 4, 4 }; ///< powers of two; of the work-groups where the launch is Whole
  };

  PublishedChainMail(const std::string& device, const std::array<int, 3>& size, const std::vector<float>& constraint,
    const Method& method);
  ~PublishedChainMail();

  /// Everything back to its rest place; nothing is held.
  void reset();

  /// Keeps an element where it is.
  void hold(std::size_t element);

  /// Moves an element, which is held from then on, and starts a wave there.
  void pull(std::size_t element, const std::array<double, 3>& displacement);

  /// Until nothing moves any more. Returns the number of iterations.
  int propagate();

  /// At most so many iterations; stops when no element moves by more than `tolerance`. Returns how many it took.
  int relax(int iterations, double tolerance);

  State state() const;
  std::size_t deviceBytes() const;

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}
