#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "RigidClusters.h"

#include <vector>

namespace chainmail
{

/// Moves blocked groups: connected elements that only block each other. Each axis has its own groups.
///
/// In a chain of links at their limits (active constraints) no single element can follow its pull, although all
/// together could. So a relaxation that moves one element or rigid cluster at a time stops above the optimum. A link
/// blocks when it is at its limit and at least one end is pulled away from the other. Elements joined by blocking links
/// form a group. It moves to the weighted mean of the target places of its outgoing links, within their boxes. So the
/// state stays feasible and the energy does not rise. Held elements and elements at rest take no part.
///
/// Few links are at their limits. So the device searches for them among all links (activeconstraints.cl). The host
/// joins and moves the groups, because it offers double precision and a fixed order. `moved` gets the bricks of moved
/// elements. Returns the largest move. `still` is the residual tolerance, as in relaxedPlace() of element.clh.
float moveBlockedGroups(
  Bricks& bricks, const RigidClusters& clusters, const Elasticity& elasticity, float still, std::vector<int>& moved);

}
