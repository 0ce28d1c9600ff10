// SPDX-License-Identifier: BSD-3-Clause
// Makes the filter's two outputs from what an update found.

#ifndef Outputs_h
#define Outputs_h

#include "Fingerprint.h"
#include "Progress.h"
#include "Scene.h"
#include "Session.h"

#include "vtkFloatArray.h"
#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include <array>
#include <set>
#include <string>

class vtkPointData;

namespace vtkChainMail
{

/// Turns the state of a session into images. Throws the engine's exceptions and std::bad_alloc.
class Outputs
{
public:
  Outputs(const Session& source, Progress& reports)
    : Source(source)
    , Reports(reports)
  {
  }

  /// Makes the deformed image and the model at rest, after an update of the session with this scene.
  std::array<vtkSmartPointer<vtkImageData>, 2> Write(const Scene& scene);

private:
  void WriteDeformed(const Scene& scene, vtkImageData* output);
  void WriteModel(const Scene& scene, vtkImageData* output);
  void WriteFieldData(const Scene& scene, double peakMegabytes, vtkImageData* output);
  void FetchTissue(const Scene& scene);
  vtkSmartPointer<vtkFloatArray> FetchDisplacement(const Scene& scene);
  void FetchTimes(const Scene& scene, vtkPointData* output);
  void WarnAboutLostArrays(vtkImageData* image);

  const Session& Source;
  Progress& Reports;

  // Arrays that the outputs share as long as updates find nothing new, and the session's counts of changes when they
  // were fetched.
  SharedArray<vtkFloatArray> Constraint;
  SharedArray<vtkUnsignedCharArray> Element;
  SharedArray<vtkIntArray> Cluster;
  int TissueChanges = 0;
  int LinkChanges = 0;

  // Cell arrays that are not passed on, and that were warned about.
  std::set<std::string> LostArrays;
};

}

#endif
