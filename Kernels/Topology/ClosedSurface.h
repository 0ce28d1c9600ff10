#pragma once

#include "ExactGeometry.h"
#include "Types.h"

#include <vector>

namespace chainmail
{

/// A surface with an inside: the positions whose winding number is not 0, positive or negative. Points that round to
/// the same position (ExactGeometry.h) count as one.
///
/// Its parts are its connected components, by edges. Overlapping parts are carved together. A part that lies within
/// others and has the opposite orientation is a hollow: what it encloses stays. It makes no difference whether all
/// normals point outwards or all inwards.
///
/// If the triangles of a part are not oriented consistently, they are reoriented. Then no part's orientation is
/// trusted, and every part within others is a hollow.
struct ClosedSurface
{
  std::vector<Fixed3> points;
  /// The triangles with three different corners, oriented so that normals of parts point outwards and those of hollows
  /// inwards.
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> part; ///< of each triangle

  /// For each part 0 if its triangles can be oriented consistently. Otherwise (for example in a Klein bottle) the
  /// even-odd rule decides: a position is inside the part where a ray from there crosses it an odd number of times. The
  /// number is then the part's winding number inside, 1 or -1.
  std::vector<int> alternating;

  SurfaceParts found;

  /// Throws InputError where an edge belongs to an odd number of triangles, and as fixedPoints() does.
  ClosedSurface(const Surface& surface, const Grid& grid);
};

}
