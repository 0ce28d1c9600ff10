// SPDX-License-Identifier: BSD-3-Clause
#include "Presets.h"

#include "vtkPiecewiseFunction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vtkChainMail
{

void GetMaterial(Look look, double air, double bright, double& tissueThreshold, vtkPiecewiseFunction* function)
{
  using Nodes = std::vector<std::array<double, 2>>; // scalar, constraint

  Nodes nodes;
  if (look == Look::CT)
  {
    // Hounsfield units: skin and fat about -100, muscle and organs about 50, spongy bone from 200. Blood with contrast
    // agent reaches 500, so only compact bone is certain to be rigid.
    tissueThreshold = -300.0;
    nodes = Nodes{ { -300.0, 0.3 }, { -100.0, 0.35 }, { 0.0, 0.25 }, { 50.0, 0.2 }, { 150.0, 0.15 }, { 300.0, 0.08 },
      { 600.0, 0.0 } };
  }
  else if (look == Look::Labels)
  {
    // It is unknown which label is bone, so all are as soft as muscle.
    tissueThreshold = 0.5;
    nodes = Nodes{ { 1.0, 0.2 }, { std::max(bright, 2.0), 0.2 } };
  }
  else
  {
    const bool valid = air <= bright && std::isfinite(bright - air); // false where no scalar is finite
    const double low = valid ? air : 0.0;
    const double width = valid ? bright - air : 0.0;
    // Scalars of these nodes are fractions of the range. In T1-weighted MR tendon is dark, muscle grey and fat bright.
    // In other images brighter voxels are assumed to be stiffer.
    nodes = look == Look::MR ? Nodes{ { 0.1, 0.15 }, { 0.3, 0.2 }, { 0.6, 0.3 }, { 1.0, 0.35 } }
                             : Nodes{ { 0.1, 0.3 }, { 0.4, 0.2 }, { 1.0, 0.05 } };
    for (auto& node : nodes)
    {
      node[0] = low + node[0] * width;
    }
    tissueThreshold = low + 0.1 * width;
  }
  if (function)
  {
    function->RemoveAllPoints();
    function->ClampingOn();
    for (const auto& node : nodes)
    {
      function->AddPoint(node[0], node[1]);
    }
  }
}

void GetPresetMaterial(
  MaterialPresets preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function)
{
  const bool isCT = preset == MaterialPresets::CT || (preset == MaterialPresets::Function && range[0] < -200.0);
  const Look look = isCT ? Look::CT : preset == MaterialPresets::MR ? Look::MR : Look::Unknown;
  GetMaterial(look, range[0], range[1], tissueThreshold, function);
}

void ApplyRelaxationPreset(const Properties& properties, chainmail::Method& method)
{
  const auto set = [&method](bool coarseToFine, int iterations, double tolerance, double error = 0.0)
  {
    method.coarseToFine = coarseToFine;
    method.relaxationIterations = iterations;
    method.relaxationTolerance = tolerance;
    method.relaxationError = error;
  };
  // With rotations, and with the published method, relaxation converges more slowly, and nobody has measured how far
  // the optimum is from what the last iterations changed. Otherwise a pull takes as many iterations as it needs: most
  // random ones 20 of Balanced's. Where a probe does not come far, a thousandth of a voxel is much.
  const bool isSlow = properties.Rotations || properties.RelaxationMethod != chainmail::RelaxationMethod::Projected;
  switch (properties.RelaxationPreset)
  {
  case RelaxationPresets::Fast:
    return set(false, 10, 1e-3);
  case RelaxationPresets::Balanced:
    return isSlow ? set(true, 20, 1e-3) : set(true, 68, 1e-4, 1e-2);
  case RelaxationPresets::Accurate:
    return isSlow ? set(true, 1000, 1e-5) : set(true, 220, 1e-5, 7e-4);
  default:
    return set(properties.CoarseToFine, properties.RelaxationIterations, properties.RelaxationTolerance,
      properties.RelaxationError);
  }
}

}
