#pragma once

#include "Bricks.h"
#include "ExactGeometry.h"

namespace chainmail
{

/// A surface that has an inside: where a ray from a place crosses it an odd number of times, whichever way its
/// triangles turn. Points that round to the same place (ExactGeometry.h) are one.
struct ClosedSurface
{
  std::vector<Fixed3> points;
  std::vector<std::array<int, 3>> triangles;

  /// Throws InputError where an edge has an odd number of triangles, and as fixedPoints() does.
  ClosedSurface(const Surface& surface, const Grid& grid);
};

/// Removes the elements whose current place lies inside. Exact: surfaces that share a face share out the elements
/// between them. Returns the removed elements (Grid::at), ascending.
std::vector<std::size_t> carveElements(Bricks& bricks, const ClosedSurface& surface);

}
