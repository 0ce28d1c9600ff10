#pragma once

#include "Block.h"

namespace oracle
{

/// u(X) = gradient X + shift, in voxels (spacing 1). The voxel y shows the material X with X + u(X) = y, a 3 x 3 system
/// solved by Cramer's rule.
struct LinearField
{
  std::array<Vector3, 3> gradient{}; ///< rows: gradient[a][b] = d u_a / d X_b
  Vector3 shift{};

  Vector3 at(const Vector3& x) const
  {
    Vector3 u = this->shift;
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        u[a] += this->gradient[a][b] * x[b];
      }
    }
    return u;
  }

  Vector3 preimage(const Vector3& y) const
  {
    std::array<Vector3, 3> m = this->gradient;
    Vector3 right{};
    for (int a = 0; a < 3; ++a)
    {
      m[a][a] += 1.0;
      right[a] = y[a] - this->shift[a];
    }
    const double whole = determinant(m);
    Vector3 x{};
    for (int b = 0; b < 3; ++b)
    {
      std::array<Vector3, 3> replaced = m;
      for (int a = 0; a < 3; ++a)
      {
        replaced[a][b] = right[a];
      }
      x[b] = determinant(replaced) / whole;
    }
    return x;
  }

private:
  static double determinant(const std::array<Vector3, 3>& m)
  {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  }
};

}
