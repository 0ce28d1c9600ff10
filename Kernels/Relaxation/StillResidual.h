#pragma once

namespace chainmail
{

/// The residual tolerance: an element with a residual up to this does not move, so a deformation ends at some distance
/// from the handle.
inline float stillResidual(double tolerance)
{
  return static_cast<float>(tolerance / 64.0);
}

}
