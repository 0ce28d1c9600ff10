#pragma once

#include "Error.h"
#include "Format.h"
#include "Model.h"
#include "ReducedBox.h"

#include <cstddef>
#include <functional>
#include <string>

namespace chainmail
{

/// Throws InputError where a constraint is not in [0, 1). `where` returns the words that name the value. It is a
/// function because only an error message needs them, and this is called for every voxel.
template <typename Where> float checkedConstraint(double value, Where&& where)
{
  // Rounding to float must not turn 0.99999999999 into a constraint of 1.
  if (!(value >= 0.0) || !(static_cast<float>(value) < 1.0f))
  {
    throw InputError(
      "The constraint " + where() + " is " + toString(value) +
      ". A constraint is a fraction of the spacing from 0 (rigid) to less than 1: correct the material.");
  }
  return static_cast<float>(value) + 0.0f; // -0 would mark the element as held
}

/// Marks voxels that are rigid on any axis as anchored (Model::row()).
void holdRigid(int axes, int count, float* constraints);

/// The constraints that a material gives to the voxels of a scan, before joints divide tissue and faces anchor it.
class Constraints
{
public:
  /// Throws InputError where arrays, function or regions cannot be used.
  Constraints(const Grid& grid, const ArrayView& scalars, const Material& material);

  /// 1 where the constraint is the same on every axis, else 3.
  int axes() const { return this->axes_; }

  /// Reads the constraints of voxels along x, `axes()` interleaved values each; minus infinity for air. Throws
  /// InputError where one is not in [0, 1).
  const Model::RowReader& reader() const { return this->read_; }

  /// One pass over the voxels of a box.
  TissueCounts count(const VoxelBox& box) const;

  /// The elements of a reduced model that have all their voxels in a box. `anchored`: whether rigid tissue is.
  ReducedBox reduce(const Index3& factor, bool anchored, const VoxelBox& box) const;

private:
  Grid grid_;
  int axes_ = 1;
  Model::RowReader read_;
  std::function<std::size_t(std::size_t first, int count)> countNonFinite_; ///< null for whole numbers
};

}
