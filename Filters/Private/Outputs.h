// SPDX-License-Identifier: BSD-3-Clause
// Makes the filter's two outputs from the state after an update.

#ifndef Outputs_h
#define Outputs_h

#include "Fingerprint.h"
#include "Progress.h"
#include "PullBack.h"
#include "Sampling.h"
#include "Scene.h"
#include "Session.h"
#include "SmoothScalars.h"

#include "vtkFloatArray.h"
#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkMath.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

class vtkDataArraySelection;
class vtkFieldData;
class vtkPointData;

namespace vtkChainMail
{

/// Converts the state of a session to images. Throws the engine's exceptions and std::bad_alloc.
class Outputs
{
public:
  Outputs(const Session& source, Progress& reports)
    : Source(source)
    , Reports(reports)
  {
  }

  /// The arrays of the model at rest that can be chosen, and whether an array is chosen by default.
  static const std::array<const char*, 4> ModelArrays;
  static bool IsDefault(const std::string& modelArray);

  /// Removes all field arrays with the names that Write() and Shown use. Those of the input image, perhaps from another
  /// deformation, must not be mistaken for results of this update.
  static void RemoveFigures(vtkFieldData* fields);

  /// Makes the deformed image and the model at rest, after an update of the session with this scene.
  std::array<vtkSmartPointer<vtkImageData>, 2> Write(const Scene& scene);

  /// Gives the model at rest of the last Write() the arrays that are chosen now, and no others of ModelArrays.
  void ChooseModelArrays(vtkDataArraySelection* chosen, vtkImageData* model);

  /// Adds the array Cluster of the last update and, if there is one, the BodyArray.
  void WriteBodies(vtkPointData* output);

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

  void ChooseSamplers(const Scene& scene);
  void WriteDeformed(const Scene& scene, vtkImageData* output);
  void WriteModel(const Scene& scene, vtkImageData* output);
  void WriteFieldData(const Scene& scene, double peakMegabytes, vtkImageData* output);
  void AddBodies(vtkFieldData* fields);
  vtkSmartPointer<vtkUnsignedCharArray> FetchElement(vtkIdType voxels);
  vtkSmartPointer<vtkFloatArray> FetchConstraint(vtkIdType voxels);
  vtkSmartPointer<vtkUnsignedCharArray> FetchLinks(vtkIdType voxels);
  vtkSmartPointer<vtkIntArray> FetchCluster(vtkIdType voxels);
  vtkSmartPointer<vtkFloatArray> FetchDisplacement(vtkIdType voxels);
  void FetchTimes(const Scene& scene, vtkPointData* output);
  void WarnAboutLostArrays(vtkImageData* image);

  const Session& Source;
  Progress& Reports;

  std::vector<Sampled> Samplers;             // one for each point array of the image
  std::unique_ptr<PullBackSampler> PullBack; // null where it is off, as is the next one
  std::unique_ptr<SmoothScalars> Smoothed;

  // Arrays that successive outputs share as long as they do not change.
  SharedArray<vtkFloatArray> Constraint;
  SharedArray<vtkUnsignedCharArray> Element;
  SharedArray<vtkUnsignedCharArray> Links;
  SharedArray<vtkIntArray> Cluster;

  std::optional<Frame> Space; // of the image of the last update

  // Cell arrays that are not passed on and were already warned about.
  std::set<std::string> LostArrays;
};

}

#endif
