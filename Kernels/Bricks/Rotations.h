#pragma once

#include "BrickStorage.h"

#include <tuple>

namespace chainmail
{

/// Whether elements rotate and, if so, how strongly they resist changes of volume.
struct RotationSettings
{
  bool on = false;
  double poissonRatio = 0.0; ///< [0, 0.5)
};

/// The rotations of elements and bones (`spin`, see spin.clh) and, where Poisson's ratio is not 0, the pressure of
/// elements and what a relaxation carries from sweep to sweep (volumetricstrain.clh). They exist only where elements
/// rotate.
struct Rotations
{
  Field spin{ 3, sizeof(float), "the rotations of the tissue reached" };
  Field pressure{ 7, sizeof(float), "the pressure of the tissue reached" }; ///< with carry and auxiliary (state.clh)
  bool any = false;      ///< whether an element may have rotated since all were at rest
  cl_float4 proportions; ///< the spacing of each axis, divided by the geometric mean of all three; then 2 kappa

  bool hasPressure() const { return this->proportions.s[3] > 0.0f; }

  /// The rest offset of a link on an axis, as a fraction of the spacing: u(j) - u(i) of the unstrained link from
  /// element i to its neighbour j in this direction. It is the mean over the rotations of both ends (spinI and spinJ, 3
  /// values each).
  float restOffset(const float* spinI, const float* spinJ, int direction, int axis) const;
  /// The factor 1 / h^2 in the weight of links along an axis, h their length in mean spacings.
  double weight(int along) const
  {
    return 1.0 / (static_cast<double>(this->proportions.s[along]) * this->proportions.s[along]);
  }

  /// ROTATION_ARGUMENTS of state.clh. Without pressure kernels do not read the buffer that stands for it.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_float4>(
      this->spin.buffer, this->hasPressure() ? this->pressure.buffer : this->spin.buffer, this->proportions);
  }
};

}
