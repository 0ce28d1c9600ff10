#pragma once

namespace chainmail
{

/// The residual up to which an element stays at a given tolerance, so that a deformation ends somewhere far from the
/// handle.
inline float stillResidual(double tolerance)
{
  return static_cast<float>(tolerance / 64.0);
}

}
