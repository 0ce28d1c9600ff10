#pragma once

#include "Handles.h"

#include <optional>

namespace chainmail
{

/// Where the search for what holds a probe ended.
struct Grip
{
  std::size_t voxel; ///< an anchored element, or one in another handle
  bool rigidly;      ///< the bone that the probe grips reaches up to it
};

/// The nearest held element from which a path of links leads to the handle that has no room left along one axis: with
/// d(h, s) the length of the shortest path of links, sign * (u(s) - u(h)) = d(h, s). Where a wave was shortened there
/// is one, and no relaxation moves what lies on such a path. A handle that others hold so far apart that it cannot go
/// anywhere as a whole may have a little room: then of all the one that leaves least, roughly. None where nothing holds
/// it that way.
///
/// Looks at the elements nearer than that one that the handle drags along without room, and at no others.
std::optional<Grip> findGrip(
  Bricks& bricks, const std::vector<Handles::Pointer>& handles, const Handle& handle, int axis, double sign);

}
