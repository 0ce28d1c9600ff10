// SPDX-License-Identifier: BSD-3-Clause
// The filter's second output: the state of the model, voxel by voxel.

#ifndef ModelAtRest_h
#define ModelAtRest_h

#include "Fingerprint.h"
#include "OutputPlan.h"
#include "Progress.h"
#include "Session.h"
#include "Steps.h"
#include "Team.h"
#include "ZeroedBuffers.h"

#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>

class vtkDataArraySelection;
class vtkPointData;

namespace vtkChainMail
{

/// Makes this process's part of the model at rest. The root process reads the state of the simulation, for the parts of
/// all processes, one array at a time. The functions throw the engine's exceptions and std::bad_alloc.
class ModelAtRest
{
public:
  ModelAtRest(const Session& source, Progress& reports)
    : Source(source)
    , Reports(reports)
  {
  }

  /// The arrays that can be chosen, and whether an array is chosen by default.
  static const std::array<const char*, 4> Choices;
  static bool IsDefault(const std::string& array);

  /// Makes the part with this extent, which may be empty. All processes call this together, after an update.
  vtkSmartPointer<vtkImageData> Write(const Team& team, Steps& steps, const OutputPlan& plan,
    vtkDataArraySelection* chosen, bool times, const Extent& extent);

  /// Gives the part of the last Write() the arrays that are chosen now, and no others of Choices. All processes call
  /// this together.
  void Choose(const Team& team, Steps& steps, vtkDataArraySelection* chosen, vtkImageData* part);

  /// Makes the image of the whole model with the array Cluster and, if there is one, the BodyArray. Only where the
  /// simulation is.
  void WriteBodies(vtkImageData* image) const;

private:
  /// In the order in which the output has them.
  enum Arrays
  {
    DISPLACEMENT,
    ELEMENT,
    LINKS,
    CONSTRAINT,
    CLUSTER,
    TIME,
    WAVEFRONT,
    NUMBER_OF_ARRAYS
  };

  void Begin(Steps& steps, double from, double to);
  bool IsWanted(int array, vtkDataArraySelection* chosen) const;
  int VersionOf(int array) const;
  void Fetch(const Team& team, Steps& steps, const std::array<bool, NUMBER_OF_ARRAYS>& missing, vtkImageData* part,
    std::array<vtkSmartPointer<vtkDataArray>, NUMBER_OF_ARRAYS>& arrays);
  /// Of zeros.
  vtkSmartPointer<vtkDataArray> Make(int array, vtkIdType voxels) const;
  vtkSmartPointer<vtkDataArray> MakeDisplacement(vtkIdType voxels);
  void Send(const Team& team, int array, const chainmail::VoxelBox& box, int to) const;
  /// `out`: zeros.
  void Read(int array, const chainmail::VoxelBox& box, void* out) const;
  void ReadLinks(const chainmail::VoxelBox& box, unsigned char* links) const;
  void ReadConstraint(const chainmail::VoxelBox& box, float* constraint) const;
  void ReadDisplacement(const chainmail::VoxelBox& box, float* displacement) const;
  void ReadTime(const chainmail::VoxelBox& box, float* time) const;

  const Session& Source;
  Progress& Reports;
  OutputPlan Plan; // of the last Write()
  Extent Part{ { 0, -1, 0, -1, 0, -1 } };

  // Arrays that successive outputs share as long as they do not change.
  std::array<SharedArray<vtkDataArray>, NUMBER_OF_ARRAYS> Shared;

  // The memory of Displacement, which each update makes anew.
  ZeroedBuffers Displacements;
};

}

#endif
