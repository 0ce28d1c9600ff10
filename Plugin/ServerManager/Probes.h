// SPDX-License-Identifier: BSD-3-Clause
// The probes of a deformation, as a client knows them: their numbers, how far they came, and how a new one pulls.

#ifndef Probes_h
#define Probes_h

#include "ViewRay.h"

class vtkSMPropertyHelper;

namespace vtkChainMail
{

/// How many points the n-th source of an input has; -1 where that is not known.
long long PointsOf(vtkSMPropertyHelper& input, unsigned int n);

/// The number of the first probe that a source makes, among all probes of a deformation; -1 where that is not known.
long long FirstProbeOf(vtkSMProxy* deformation, vtkSMProxy* source);

/// How far the first probe of a source came in the last update of a deformation. False where that is not known.
bool ReachedBy(vtkSMProxy* deformation, vtkSMProxy* source, Place& reached);

/// Puts a new probe of a deformation where tissue follows its pull, at one of the spots of a view, and makes the pull
/// no longer than the tissue follows. To find out, it updates the deformation, without relaxation.
void FitPull(vtkSMSourceProxy* probe, vtkSMSourceProxy* deformation, const ViewRay& sight);

}

#endif
