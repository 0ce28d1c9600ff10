// SPDX-License-Identifier: BSD-3-Clause
// Makes the filter's two outputs from the state after an update.

#ifndef Outputs_h
#define Outputs_h

#include "Fingerprint.h"
#include "ModelAtRest.h"
#include "OutputPlan.h"
#include "PartSource.h"
#include "Progress.h"
#include "PullBack.h"
#include "Sampling.h"
#include "Scene.h"
#include "Session.h"
#include "SmoothScalars.h"
#include "Steps.h"
#include "Team.h"

#include "vtkImageData.h"
#include "vtkMath.h"
#include "vtkSmartPointer.h"

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

class vtkDataArraySelection;
class vtkFieldData;

namespace vtkChainMail
{

/// Converts the state of a session to images: in an update of several processes to this process's parts of them. Throws
/// the engine's exceptions and std::bad_alloc.
class Outputs
{
public:
  Outputs(const Session& source, Progress& reports)
    : Source(source)
    , Reports(reports)
    , Material(source, reports)
    , Model(source, reports)
  {
  }

  /// Removes all field arrays with the names that Write() and Shown use. Those of the input image, perhaps from another
  /// deformation, must not be mistaken for results of this update.
  static void RemoveFigures(vtkFieldData* fields);

  /// What this process is to make: the extents of its parts of both outputs. None: the whole outputs.
  using Request = std::optional<std::array<Extent, 2>>;

  /// Makes the deformed image and the model at rest. All processes call this together, after an update. `scene`: that
  /// of the update, null outside the root. `own`: the part of the input image that this process has; may be null.
  std::array<vtkSmartPointer<vtkImageData>, 2> Write(
    const Team& team, const Scene* scene, const Properties& properties, const Request& request);

  /// Gives the model at rest of the last Write() the arrays that are chosen now. All processes call this together.
  void ChooseModelArrays(const Team& team, vtkDataArraySelection* chosen, vtkImageData* model);

  /// The geometry of the whole input image of the last Write().
  vtkImageData* GetWhole() const { return this->Plan.Whole; }

  /// To be called after a device error: nothing on the device is used any more.
  void Forget() { this->Material.Forget(); }

  /// See ModelAtRest.
  void WriteBodies(vtkImageData* image) const { this->Model.WriteBodies(image); }

private:
  /// A sampler and all that its output depends on, apart from the deformation.
  struct Sampled
  {
    explicit Sampled(const Grids& grids)
      : G(grids)
    {
    }

    Grids G;
    vtkAbstractArray* Array = nullptr; ///< of the input
    FarValues Far;                     ///< what this array lacks
    ArrayContents Numbers;             ///< for arrays of numbers
    vtkMTimeType Time = 0;             ///< for all other arrays
    bool Nearest = false;
    bool Still = false;
    bool SmoothCuts = false;
    double Background = vtkMath::Nan();
    PaddingValues NotMeasured;
    int Builds = 0;
    std::shared_ptr<ArraySampler> Sampler;

    bool operator==(const Sampled& other) const;
  };

  void ChooseSamplers(const Scene* scene, const OutputPlan& plan, const Properties& properties, const Grids& grids);
  vtkSmartPointer<vtkImageData> WriteDeformed(const Team& team, Steps& steps, const Scene* scene,
    const OutputPlan& plan, const Properties& properties, const std::optional<Extent>& extent);
  void Sample(const Team& team, Steps& steps, const Scene* scene, const OutputPlan& plan, const Properties& properties,
    const std::optional<chainmail::OutputDetail>& part, vtkImageData* output);
  std::vector<ArraySampler*> BeginSamplers(const Scene* scene, const OutputPlan& plan, const Properties& properties,
    const chainmail::OutputDetail& part, std::uint64_t& since);
  void EndSamplers(const OutputPlan& plan, const chainmail::OutputDetail& part, const chainmail::Resampled& resampled,
    vtkImageData* output);
  void WriteFieldData(const Scene& scene, double peakMegabytes, vtkFieldData* fields);
  void AddBodies(vtkFieldData* fields);
  void WarnAboutLostArrays(vtkImageData* image);

  const Session& Source;
  Progress& Reports;
  OutputPlan Plan; // of the last Write()
  PartSource Material;
  ModelAtRest Model;

  std::vector<Sampled> Samplers;             // one for each point array of the image
  std::unique_ptr<PullBackSampler> PullBack; // null where it is off, as is the next one
  std::unique_ptr<SmoothScalars> Smoothed;

  int MaterialVersion = 0; // of these samplers

  // Cell arrays that are not passed on and were already warned about.
  std::set<std::string> LostArrays;
};

}

#endif
