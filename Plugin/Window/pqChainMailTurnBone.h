// SPDX-License-Identifier: BSD-3-Clause
#ifndef pqChainMailTurnBone_h
#define pqChainMailTurnBone_h

/// What the button Turn Bone does: makes a pose of the bone that the active view has in its middle, and selects it, as
/// one step of Undo. Where the selected source belongs to no deformation, it makes one of the scan and of the labels
/// that fit it, which let bones move by themselves. Where Rotations are off, it switches them on.
void pqChainMailTurnBone();

#endif
