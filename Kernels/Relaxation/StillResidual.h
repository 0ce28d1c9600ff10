#pragma once

namespace chainmail
{

/// Residuals up to this are left alone at a tolerance, so that a deformation ends somewhere, far from the handle.
inline float stillResidual(double tolerance)
{
  return static_cast<float>(tolerance / 64.0);
}

}
