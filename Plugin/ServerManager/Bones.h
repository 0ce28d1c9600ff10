// SPDX-License-Identifier: BSD-3-Clause
// The bones of a deformation, as a client finds them: those that a view shows, and those that poses hold.

#ifndef Bones_h
#define Bones_h

#include "ViewRay.h"

#include "vtkType.h"

namespace vtkChainMail
{

struct Bone
{
  vtkIdType Body = -1;            ///< its label; -1 where the deformation has no labels
  std::array<double, 6> Bounds{}; ///< at rest, in world axes
  Place Middle{};                 ///< of the bounds; without a label the place in the bone that is nearest to it
};

/// Finds the first bone that one of these rays meets, each as two places. False where there is none, or where the last
/// update of the deformation failed.
bool FindBone(vtkSMProxy* deformation, const std::vector<double>& rays, Bone& bone);

/// Finds the bone with a label; with -1 the one at a place.
bool FindBone(vtkSMProxy* deformation, vtkIdType body, const Place& place, Bone& bone);

}

#endif
