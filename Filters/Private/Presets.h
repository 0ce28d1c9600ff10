// SPDX-License-Identifier: BSD-3-Clause
// The values that the filter's presets stand for.

#ifndef Presets_h
#define Presets_h

class vtkChainMailDeformation;
class vtkPiecewiseFunction;

namespace vtkChainMail
{

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
