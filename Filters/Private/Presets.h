// SPDX-License-Identifier: BSD-3-Clause
// The values that the filter's presets stand for.

#ifndef Presets_h
#define Presets_h

#include "Properties.h"

class vtkPiecewiseFunction;

namespace vtkChainMail
{

/// What the scalars of an image mean.
enum class Look
{
  CT,      ///< Hounsfield units
  MR,      ///< T1-weighted
  Unknown, ///< no unit
  Labels
};

/// The material for scalars of this meaning. For MR and Unknown, `air` and `bright` are the scalars of air and of the
/// brightest voxels. For Labels `bright` is the largest label. `function` may be null.
void GetMaterial(Look look, double air, double bright, double& tissueThreshold, vtkPiecewiseFunction* function);

/// The material of a preset for scalars of the given range, as vtkChainMailDeformation::GetPresetMaterial() says.
void GetPresetMaterial(
  MaterialPresets preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

/// Sets coarseToFine, relaxationIterations, relaxationTolerance and relaxationError as the RelaxationPreset says: to
/// its own values or, for Custom, to those of the properties.
void ApplyRelaxationPreset(const Properties& properties, chainmail::Method& method);

}

#endif
