#pragma once

#include "ExactGeometry.h"
#include "Types.h"

#include <vector>

namespace chainmail
{

/// A surface that has an inside: the places that it winds around, in whichever direction. Points that round to the same
/// place (ExactGeometry.h) count as one.
///
/// Its parts are its connected components, by edges. Parts that overlap are carved together. A part that lies within
/// others and faces the other way than they do is a hollow: what it encloses stays. Whether normals point outwards or
/// inwards makes no difference, as long as they agree.
///
/// Where the triangles of a part face both ways, they are turned to agree. No part can be trusted to face the way it is
/// meant to then, and every part within others is a hollow.
struct ClosedSurface
{
  std::vector<Fixed3> points;
  /// Those with three different corners, turned so that normals of parts point outwards, and those of hollows inwards.
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> part; ///< of each triangle

  /// For each part: 0 where its triangles agree. Else they cannot (a Klein bottle, say): a place is inside the part
  /// where a ray from there crosses it an odd number of times, and the number is the part's winding number there.
  std::vector<int> alternating;

  SurfaceParts found;

  /// Throws InputError where an edge belongs to an odd number of triangles, and as fixedPoints() does.
  ClosedSurface(const Surface& surface, const Grid& grid);
};

}
