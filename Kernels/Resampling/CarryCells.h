#pragma once

#include "Model.h"

#include <array>
#include <cstdint>

namespace chainmail
{

/// A deformation as arrays over the voxels at rest; the caller owns the arrays. Positions and displacements are in
/// voxels along the grid's axes, from the centre of the first voxel.
struct RestModel
{
  static constexpr std::uint8_t carved = 64; ///< in `links`: tissue was carved away

  Grid grid;
  const float* displacement = nullptr;   ///< 3 values a voxel
  std::array<double, 9> toVoxels{};      ///< the matrix, row by row, that converts these values to voxels
  const std::uint8_t* element = nullptr; ///< not 0 where there is tissue
  const std::uint8_t* links = nullptr; ///< as in Simulation::links(), or `carved`; null where nothing is cut or carved

  bool isFlat(int axis) const { return this->grid.size[axis] == 1; }
  bool isElement(const Index3& at) const
  {
    return this->grid.contains(at[0], at[1], at[2]) && this->element[this->grid.at(at[0], at[1], at[2])] != 0;
  }
  bool isCarved(const Index3& at) const
  {
    return this->links && (this->links[this->grid.at(at[0], at[1], at[2])] & carved) != 0;
  }
  /// The displacement of an element; 0 on all axes where it is below 1e-6 voxel on each.
  Vector3 displacementAt(const Index3& at) const;
};

/// The map x + U(x) over the cells of eight neighbouring voxels, with a virtual cell for each component. The rules are
/// those of resample.clh, in double precision: a cell at a cut has one map for each side. Along a flat axis both
/// corners of a cell are the same voxel.
class CarryCells
{
public:
  explicit CarryCells(const RestModel& model)
    : model_(model)
  {
  }

  static constexpr std::uint8_t none = 8;

  struct Cell
  {
    Index3 base{};
    unsigned elements = 0;                 ///< bit n: corner n is an element; bits of n: x, y, z
    unsigned carved = 0;                   ///< likewise
    std::array<std::uint8_t, 8> component; ///< the lowest corner of the component that a corner belongs to; air and
                                           ///< carved corners join that of the nearest element; `none` without elements
    bool hasOwn(unsigned component) const
    {
      return (this->elements >> component & 1) && this->component[component] == component;
    }
  };

  using Corners = std::array<Vector3, 8>; ///< displacements

  /// The cell with its lowest corner at `base`: at most size - 2 on each axis, and 0 on a flat one.
  Cell cellAt(const Index3& base) const;

  /// The displacements at the corners of the virtual cell of a component.
  Corners cornersOf(const Cell& cell, unsigned component) const;

  /// The mean displacement over the elements around a voxel that are connected to `seeds` by links between these
  /// elements. In `seeds` the voxel at offset (x - 1, y - 1, z - 1) has bit x + 3 y + 9 z.
  Vector3 meanAround(const Index3& voxel, unsigned seeds) const;

  /// The elements among the 27 voxels around one, with the bits of `seeds`.
  unsigned elementsAround(const Index3& voxel) const;

  Index3 cornerAt(const Index3& base, int n) const
  {
    return { base[0] + (this->model_.isFlat(0) ? 0 : n & 1), base[1] + (this->model_.isFlat(1) ? 0 : n >> 1 & 1),
      base[2] + (this->model_.isFlat(2) ? 0 : n >> 2) };
  }

  /// U at local coordinates in [0, 1] and, if `derivatives` is not null, its derivatives: [3 b + a] of U_b along axis
  /// a.
  static Vector3 interpolate(
    const Corners& corners, const Vector3& local, std::array<double, 9>* derivatives = nullptr);

  /// Solves x + U(x) = target by Newton's method for local coordinates, on the axes that are not flat. Returns whether
  /// there is a solution near the cell.
  bool invert(const Corners& corners, const Vector3& target, Vector3& local) const;

  /// Solves a linear system with this matrix (row by row) and replaces its right side by the solution. Returns false,
  /// and changes nothing, where the matrix is singular.
  static bool solve(const std::array<double, 9>& matrix, Vector3& side);

private:
  bool isLinked(const Index3& from, int axis) const;

  RestModel model_;
};

}
