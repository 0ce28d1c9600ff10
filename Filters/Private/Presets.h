// SPDX-License-Identifier: BSD-3-Clause
// The values that the filter's presets stand for.

#ifndef Presets_h
#define Presets_h

class vtkChainMailDeformation;
class vtkPiecewiseFunction;

namespace vtkChainMail
{

/// What scalars may mean.
enum class Look
{
  CT,      ///< Hounsfield units
  MR,      ///< T1-weighted
  Unknown, ///< no unit
  Labels
};

/// The material for scalars that look so. For MR and what is unknown, `air` and `bright` are where air and the
/// brightest voxels are; the largest label is `bright`. `function` may be null.
void GetMaterial(Look look, double air, double bright, double& tissueThreshold, vtkPiecewiseFunction* function);

/// The material of a preset for scalars of the given range, as vtkChainMailDeformation::GetPresetMaterial() says.
void GetPresetMaterial(int preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function);

/// How long tissue settles in an update.
struct Settling
{
  bool CoarseToFine = false;
  int Iterations = 0;
  double Tolerance = 0.0;
};

/// The settling of the filter's RelaxationPreset, or of its three properties.
Settling GetSettling(vtkChainMailDeformation* filter);

}

#endif
