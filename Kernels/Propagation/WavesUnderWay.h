#pragma once

#include "Context.h"

#include <tuple>

namespace chainmail
{

/// Waves of Timestamp that have not come to their ends. Meanwhile an element may relax, on an axis, where it did not
/// move in this iteration and belongs to the same wavefront as all elements that it is linked to.
struct WavesUnderWay
{
  const cl::Buffer* front = nullptr; ///< int [axis][address], `axes()` runs: number of the wavefront
  const cl::Buffer* stamp = nullptr; ///< int [axis][address]: the iteration in which a wave last moved the element
  int iteration = 0;                 ///< the current iteration

  /// WAVES_ARGUMENTS of wavefronts.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_int>(*this->front, *this->stamp, this->iteration);
  }
};

}
