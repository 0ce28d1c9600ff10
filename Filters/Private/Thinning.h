// SPDX-License-Identifier: BSD-3-Clause
// Chooses some of many places, about a given distance apart.

#ifndef Thinning_h
#define Thinning_h

#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_set>

namespace vtkChainMail
{

/// Accepts the first place in each cube of a lattice. The lattice has a corner at the origin, so it does not depend on
/// the extent of a mesh.
class Thinning
{
public:
  /// `spacing` 0 accepts all places.
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
