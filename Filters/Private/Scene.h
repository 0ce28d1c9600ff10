// SPDX-License-Identifier: BSD-3-Clause
// What an update has to do: its inputs and the filter's properties, checked and converted for the engine.

#ifndef Scene_h
#define Scene_h

#include "Fingerprint.h"
#include "Frame.h"
#include "Inputs.h"
#include "LabelVoxels.h"
#include "OutputGrid.h"
#include "Presets.h"
#include "Properties.h"
#include "Surfaces.h"

#include "Simulation.h"

#include "vtkSmartPointer.h"

#include <string>
#include <tuple>
#include <vector>

class vtkAbstractArray;

namespace vtkChainMail
{

/// Everything that the engine's model and simulation are made from. If it is equal to that of the last update, nothing
/// is built again.
struct TissueSource
{
  ArrayContents Scalars;
  ArrayContents Constraints;
  ArrayContents Bodies;
  int JointSize = 0;
  double JointConstraint = 0.0; // 0 where there are no joints
  int JointMargin = 4;
  std::vector<double> Regions; // 5 for each: place, radius, constraint
  chainmail::Index3 Size{};
  Vector3 Spacing{};
  double Threshold = 0.0;
  double HighPadding = 0.0;     // scalars of at least this are padding, not tissue
  std::vector<double> Function; // all that GetValue() of the material function depends on
  chainmail::Anchors Anchors;
  chainmail::Settings Settings;

  chainmail::Grid GetGrid() const
  {
    chainmail::Grid grid;
    grid.size = this->Size;
    grid.spacing = this->Spacing;
    return grid;
  }

  bool operator==(const TissueSource& other) const
  {
    const auto all = [](const TissueSource& t)
    {
      return std::tie(t.Scalars, t.Constraints, t.Bodies, t.JointSize, t.JointConstraint, t.JointMargin, t.Regions,
        t.Size, t.Spacing, t.Threshold, t.HighPadding, t.Function, t.Anchors.rigid, t.Anchors.faces, t.Settings.device,
        t.Settings.brickSize, t.Settings.modelReduction, t.Settings.rotations, t.Settings.poissonRatio);
    };
    return all(*this) == all(other);
  }
};

/// The source of a probe, for messages.
struct ProbeOrigin
{
  std::size_t InputDataset; // number among the scene's leaves
  vtkIdType Point;
  Vector3 Position; // in world axes
};

/// The array that was chosen as the filter's scalars, or the active one.
struct ChosenArray
{
  vtkAbstractArray* Array;
  int Association;  ///< vtkDataObject::FieldAssociations
  const char* Name; ///< the name by which it was chosen; null where none was given
};

struct Scene
{
  /// `tissueBefore`: the tissue of the last update; its arrays with the same times are not read again, nor the labels
  /// cached in `labels`. Throws InputError, whose message says what is wrong with which input or property.
  Scene(const vtkChainMail::Properties& properties, const Inputs& inputs, const ChosenArray& scalars,
    const TissueSource& tissueBefore, LabelVoxels& labels);

  /// The name of a probe for messages: "Probes input 0, point 3 at (1, 2, 3)".
  std::string NameOf(std::size_t probe) const;

  const vtkChainMail::Properties& Properties;
  const Inputs& Given;
  vtkImageData* Image; // with the arrays; where the image is spread, those of the root's part
  vtkImageData* Whole; // its geometry, without arrays where the image is spread
  Frame Space;
  OutputGrid Output;
  vtkDataArray* Scalars = nullptr; // the image's own array
  TissueSource Tissue;
  std::vector<chainmail::Probe> Probes;
  std::vector<ProbeOrigin> ProbeOrigins;
  std::vector<std::string> RegionNames; // for messages, in the order of Tissue.Regions
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;

  bool Interactive = false;
  chainmail::Method How;

  // Texts about what the scalars were taken for, and what is doubtful about it.
  std::string Guess;
  std::string Doubt;

  // For the outputs.
  double BackgroundValue;               // of the scalars
  double LowPadding = 0.0;              // scalars of at most this are padding, not tissue
  bool AreLabels = false;               // whether the scalars are labels
  std::vector<std::string> LabelArrays; // also the BodyArray

private:
  void CheckPointArrays() const;
  ArrayContents ContentsOf(vtkDataArray* array, const ArrayContents& before) const;
  void ReadTissue(const ChosenArray& chosen, const TissueSource& before);
  void ReadBodies(const TissueSource& before);
  void ReadMaterial();
  void ReadProbes();
  void ReadPoses(LabelVoxels& labels);
  void ReadRegions();
};

}

#endif
