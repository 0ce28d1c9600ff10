#pragma once

#include "Context.h"

#include <tuple>

namespace chainmail
{

/// Waves of Timestamp that have not ended. Meanwhile an element may relax, on an axis, if no wave moved it in this
/// iteration and if it belongs to the same wave as all elements linked to it.
struct WavesUnderWay
{
  const cl::Buffer* front = nullptr; ///< int [axis][address], `axes()` components: wave id
  const cl::Buffer* stamp = nullptr; ///< int [axis][address]: the iteration in which a wave last moved the element
  int iteration = 0;                 ///< the current iteration

  /// WAVES_ARGUMENTS of wavefronts.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_int>(*this->front, *this->stamp, this->iteration);
  }
};

}
