// SPDX-License-Identifier: BSD-3-Clause
// What every process has to know of an update to make its part of the outputs.

#ifndef OutputPlan_h
#define OutputPlan_h

#include "ArraySampler.h"
#include "Frame.h"
#include "ImageParts.h"
#include "Scene.h"
#include "Session.h"

#include "vtkImageData.h"
#include "vtkMultiProcessStream.h"
#include "vtkSmartPointer.h"

#include <string>
#include <vector>

namespace vtkChainMail
{

struct OutputPlan
{
  OutputPlan() = default;
  /// After an update of the session with this scene.
  OutputPlan(const Scene& scene, const Session& session);

  void Write(vtkMultiProcessStream& stream) const;
  static OutputPlan Read(vtkMultiProcessStream& stream);

  chainmail::Index3 GetSize() const;
  /// The lowest and the highest voxel of the deformed image, in indices of the grid.
  chainmail::OutputDetail GetRange() const;
  /// The part of the output, as fine as the whole, that contains these voxels of the deformed image and `halo` more
  /// voxels of the grid on every side. `extent` must not be empty.
  chainmail::OutputDetail GetPart(const Extent& extent, int halo) const;
  /// The extent of a part of the deformed image.
  Extent ExtentOf(const chainmail::OutputDetail& part) const;
  /// The box of voxels of the model at rest that has this extent.
  chainmail::VoxelBox BoxOf(const Extent& extent) const;

  vtkSmartPointer<vtkImageData> Whole; ///< the geometry of the whole input image, without arrays
  chainmail::Index3 Padding{};
  chainmail::OutputDetail Detail;

  int Scalars = 0; ///< number of the scalars among the image's point arrays
  double Background = 0.0;
  PaddingValues NotMeasured;
  double Threshold = 0.0;
  double Ceiling = 0.0; ///< scalars of at least this are not tissue
  bool AreLabels = false;
  std::vector<std::string> LabelArrays;
  std::string Arrays; ///< ListTypes() of the image

  int Builds = 0; // see Session
  int TissueChanges = 0;
  int LinkChanges = 0;
  bool IsCut = false;
  int Axes = 1;
};

}

#endif
