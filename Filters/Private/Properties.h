// SPDX-License-Identifier: BSD-3-Clause
// The filter's properties, as an update reads them.

#ifndef Properties_h
#define Properties_h

#include "Choices.h"

#include <array>
#include <string>
#include <vector>

class vtkDataArraySelection;
class vtkPiecewiseFunction;

namespace vtkChainMail
{

/// The values of the properties of a vtkChainMailDeformation, which documents them and has their defaults. The filter
/// fills this in one place (GetProperties()). Nothing is checked yet: an enumeration may have a number without a
/// meaning.
struct Properties
{
  MaterialPresets MaterialPreset{};
  vtkPiecewiseFunction* MaterialFunction = nullptr; ///< may be null
  double TissueThreshold = 0.0;
  std::string ConstraintArray; ///< empty: none
  std::string BodyArray;       ///< empty: none
  int JointSize = 0;
  double JointConstraint = 0.0;
  int JointMargin = 0;
  bool AnchorRigid = false;
  std::array<int, 6> AnchoredFaces{};

  Modes Mode{};
  chainmail::PropagationMethod PropagationMethod{};
  int PropagationIterations = 0;
  chainmail::ConflictPolicy ConflictPolicy{};
  bool PropagationTimes = false;
  chainmail::RelaxationMethod RelaxationMethod{};
  RelaxationPresets RelaxationPreset{};
  bool CoarseToFine = false;
  double ElasticRecovery = 0.0;
  bool Rotations = false;
  double PoissonRatio = 0.0;
  int RelaxationIterations = 0;
  double RelaxationTolerance = 0.0;
  double RelaxationError = 0.0;
  int ModelReduction = 0;

  vtkDataArraySelection* ModelArrays = nullptr;
  InterpolationTypes Interpolation{};
  std::vector<std::string> LabelArrays;
  double BackgroundValue = 0.0;
  int OutputPadding = 0;
  int OutputMagnification = 0;
  bool UseOutputBounds = false;
  std::array<double, 6> OutputBounds{};
  bool SmoothCuts = false;
  bool PullBack = false;
  double ScalarSmoothing = 0.0;

  std::string Device;
  chainmail::Index3 BrickSize{};
};

}

#endif
