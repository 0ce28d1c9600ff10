#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "RigidClusters.h"

#include <vector>

namespace chainmail
{

/// Moves, axis by axis, blocked groups: elements that only block each other.
///
/// Where links are at their limits (active constraints), no element of a chain can go where its neighbours pull it,
/// though all together could: relaxation of one element (or rigid cluster) at a time then rests above the optimum. A
/// link blocks when it is at its limit and its ends are pulled further apart or one of them away from the other.
/// Elements joined by blocking links form a group, which moves to the weighted mean of what its outgoing links ask for,
/// within their boxes. So the state stays feasible and the energy does not rise. Held elements and those at rest take
/// no part.
///
/// Links at their limits are few, so that the device looks for them among all (activeconstraints.cl), and the host,
/// which needs double precision and an order, joins and moves their groups. Sets `moved` to the bricks of moved
/// elements and returns the largest move.
float moveBlockedGroups(
  Bricks& bricks, const RigidClusters& clusters, const Elasticity& elasticity, float still, std::vector<int>& moved);

}
