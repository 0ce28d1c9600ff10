// SPDX-License-Identifier: BSD-3-Clause
// Chooses some of many places, so that they are about as far apart as wanted.

#ifndef Thinning_h
#define Thinning_h

#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_set>

namespace vtkChainMail
{

/// Lets one place through in each cube of a lattice: the first. The lattice begins at 0, so the choice does not depend
/// on where a mesh begins.
class Thinning
{
public:
  /// `spacing` 0 lets all through.
  explicit Thinning(double spacing)
    : Spacing(spacing)
  {
  }

  bool Takes(const double place[3])
  {
    if (this->Spacing <= 0.0)
    {
      return true;
    }
    std::array<double, 3> cube;
    for (int a = 0; a < 3; ++a)
    {
      cube[a] = std::floor(place[a] / this->Spacing);
    }
    return this->Taken.insert(cube).second;
  }

private:
  struct Hash
  {
    std::size_t operator()(const std::array<double, 3>& cube) const
    {
      const std::hash<double> hash;
      return (hash(cube[0]) * 31 + hash(cube[1])) * 31 + hash(cube[2]);
    }
  };

  double Spacing;
  std::unordered_set<std::array<double, 3>, Hash> Taken;
};

}

#endif
