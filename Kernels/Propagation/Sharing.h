#pragma once

#include "Elements.h"
#include "FixedPoint.h"

#include <vector>

namespace chainmail
{

/// A fair compromise between incompatible handles, in closed form (share.cl), a method of this project. Requests t(k)
/// are first clamped to what held tissue allows. Each element k then gets the mean of
///
///   L(k) = max_j(t(j) - d(j, k)) and U(k) = min_j(t(j) + d(j, k)),
///
/// with d(j, k) the length of the shortest path of links between two elements. L and U are the least and the greatest
/// feasible extension of the requests (McShane and Whitney, 1934), so their mean is feasible, too. Where requests are
/// compatible, L = U = t. It takes the time of two or three waves, however many handles there are.
class Sharing
{
public:
  explicit Sharing(Bricks& bricks);
  ~Sharing() { this->release(); }

  /// Returns the displacements that these elements, in these bricks, get. `wanted`: those that they request. Both are
  /// fractions of the spacing, 3 interleaved values each. These elements must not be marked as held; held tissue stays
  /// where it is. The state must be feasible and does not change.
  std::vector<float> run(const Elements& elements, const std::vector<int>& bricks, const std::vector<float>& wanted,
    const Checkpoint& checkpoint);

private:
  void spread(const std::vector<int>& bricks, float margin, Field& lower, Field& upper, const Checkpoint& checkpoint);
  std::vector<int> holdBounds();
  void release();

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field lower_{ 3, sizeof(float), "bounds of displacements" };
  Field upper_{ 3, sizeof(float), "bounds of displacements" };
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "bricks with held tissue" };
};

}
