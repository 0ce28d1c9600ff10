#pragma once

#include "Bricks.h"
#include "ExactGeometry.h"

namespace chainmail
{

/// A surface that has an inside: the places from which a ray crosses it an odd number of times, however its triangles
/// are oriented. Points that round to the same place (ExactGeometry.h) count as one.
struct ClosedSurface
{
  std::vector<Fixed3> points;
  std::vector<std::array<int, 3>> triangles;

  /// Throws InputError where an edge belongs to an odd number of triangles, and as fixedPoints() does.
  ClosedSurface(const Surface& surface, const Grid& grid);
};

/// Removes the elements whose current place lies inside the surface. The decision is exact: where two surfaces share a
/// face, every element there lies in just one of them. Returns the removed elements (Grid::at), ascending.
std::vector<std::size_t> carveElements(Bricks& bricks, const ClosedSurface& surface);

}
