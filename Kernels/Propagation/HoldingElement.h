#pragma once

#include "Handles.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace chainmail
{

/// The held element that limits a probe, as found by findHoldingElement().
struct HoldingElement
{
  std::size_t voxel;             ///< an anchored element, or one in another handle
  bool rigidly;                  ///< the path to it is rigid: it holds the bone in the probe's grip
  std::vector<std::size_t> path; ///< the elements of the path, from the handle to `voxel`
};

/// Finds what keeps a handle h from going further along one axis, in the direction of `sign`: the nearest held element
/// s to which a path of links leaves no room:
///
///   sign * (u(h) - u(s)) = d(h, s), with d(h, s) the length of the shortest path of links.
///
/// Where a wave was shortened there is such an element, and no relaxation moves the elements of the path. A handle
/// whose elements are held so far apart by others that it cannot move as a whole may have a little room. The result is
/// then, roughly, the held element that leaves least. None where no element holds the handle in this way.
///
/// Searches only elements that the handle drags along without room and that are nearer than the result.
std::optional<HoldingElement> findHoldingElement(
  Bricks& bricks, const std::vector<Handles::Pointer>& handles, const Handle& handle, int axis, double sign);

}
