#pragma once

#include "Bricks.h"

namespace chainmail
{

/// Launches a pass: updates elements from the values of their neighbours, those of one colour, of all bricks of one
/// parity, or of all clusters. A pass writes fields of the state that the next pass reads.
///
/// Every pass of a propagation, of a relaxation or between grids is launched here. So what has to happen between two
/// passes has one place, for example an exchange of values between processes. Kernels that write an element from its
/// own values alone are no passes. Small grids do many passes in one launch (relaxBatch in relax.cl).
template <typename... Arguments>
void launchPass(
  const Bricks& bricks, const Kernel& kernel, std::size_t groups, std::size_t items, const Arguments&... arguments)
{
  bricks.context().launch(kernel, groups, items, arguments...);
}

/// The same for a kernel over `count` items, see Context::launchOver().
template <typename... Arguments>
void launchPassOver(const Bricks& bricks, const Kernel& kernel, std::size_t count, const Arguments&... arguments)
{
  launchPass(bricks, kernel, Context::groupsOver(count), Context::itemsOver, arguments..., static_cast<cl_uint>(count));
}

}
