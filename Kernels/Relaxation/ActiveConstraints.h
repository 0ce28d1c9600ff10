#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "RigidClusters.h"

#include <vector>

namespace chainmail
{

/// Moves, axis by axis, blocked groups: elements that only block each other.
///
/// Where links are at their limits (active constraints), no single element of a chain can go where its neighbours pull
/// it, though all together could. So a relaxation that moves one element or rigid cluster at a time comes to rest above
/// the optimum. A link blocks when it is at its limit and its ends are pulled further apart, or one of them away from
/// the other. Elements joined by blocking links form a group, which moves to the weighted mean of what its outgoing
/// links ask for, within their boxes. So the state stays feasible and the energy does not rise. Held elements and
/// elements at rest take no part.
///
/// Links at their limits are few. So the device looks for them among all (activeconstraints.cl), and the host, where
/// double precision and a fixed order are to be had, joins and moves the groups. Sets `moved` to the bricks of moved
/// elements and returns the largest move. `still` is as in relaxedPlace() of element.clh.
float moveBlockedGroups(
  Bricks& bricks, const RigidClusters& clusters, const Elasticity& elasticity, float still, std::vector<int>& moved);

}
