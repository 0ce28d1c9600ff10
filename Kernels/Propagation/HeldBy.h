#pragma once

#include "Handles.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace chainmail
{

/// The held element that ended the search for what holds a probe.
struct Grip
{
  std::size_t voxel;             ///< an anchored element, or one in another handle
  bool rigidly;                  ///< the path to it is rigid: it holds the bone in the probe's grip
  std::vector<std::size_t> path; ///< the elements of the path, from the handle to `voxel`
};

/// Finds what keeps a handle h from going further along one axis: the nearest held element s to which a path of links
/// leaves no room. With d(h, s) the length of the shortest path of links, that means sign * (u(s) - u(h)) = d(h, s).
/// Where a wave was shortened there is such an element, and no relaxation moves what lies on the path. A handle that
/// others hold so far apart that it cannot move as a whole may have a little room; the result is then, roughly, the
/// held element that leaves least. None where no element holds it in this way.
///
/// Searches only the elements that the handle drags along without room and that are nearer than the result.
std::optional<Grip> findGrip(
  Bricks& bricks, const std::vector<Handles::Pointer>& handles, const Handle& handle, int axis, double sign);

}
