// SPDX-License-Identifier: BSD-3-Clause
// What one process makes its part of the deformed image from.

#ifndef PartSource_h
#define PartSource_h

#include "OutputPlan.h"
#include "Progress.h"
#include "Scene.h"
#include "Session.h"
#include "Steps.h"
#include "Team.h"

#include "Resampler.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vtkChainMail
{

/// The voxels of the input that a part of the deformed image shows, and the tissue that moves into it. The root process
/// has the simulation and the whole image; each other process gets from it what its own part needs.
class PartSource
{
public:
  PartSource(const Session& session, Progress& reports)
    : Source(session)
    , Reports(reports)
  {
  }

  /// Called by all processes together, after an update. `scene`: null outside the root. `part`: of this process; none
  /// where it has nothing to make.
  void Update(const Team& team, Steps& steps, const Scene* scene, const OutputPlan& plan, const Properties& properties,
    const std::optional<chainmail::OutputDetail>& part);

  /// The voxels at the place of the part, and the box that they are; all arrays that sampling reads.
  vtkImageData* GetImage() const { return this->Image; }
  const chainmail::VoxelBox& GetBox() const { return this->Box; }
  /// The same for voxels that move into the part from elsewhere; null where GetImage() has all.
  vtkImageData* GetFarImage() const { return this->FarImage; }
  const chainmail::VoxelBox& GetFarBox() const { return this->FarBox; }
  /// For each point array of the whole image its smallest values (SmallestOf()); null in an update of one process.
  vtkDataArray* GetSmallest(int array) const
  {
    return this->Smallest.empty() ? nullptr : this->Smallest[static_cast<std::size_t>(array)].Get();
  }
  /// The scalars of both, in a form that the engine can read.
  vtkDataArray* GetScalars() const { return this->Scalars; }
  vtkDataArray* GetFarScalars() const { return this->FarScalars; }
  /// Changes where earlier resamplings cannot be continued (Resampled::number).
  int GetVersion() const { return this->Version; }

  /// To be called after a device error.
  void Forget();

  /// See chainmail::Simulation::resample(). Called by all processes together; nothing where this one has no part, or
  /// after a step has failed.
  chainmail::Resampled Resample(
    const Team& team, Steps& steps, const chainmail::BoxVisitor& visit, std::uint64_t since);

private:
  void Renew();
  void ShareTissue(const Team& team, Steps& steps, const Scene* scene);
  void ResamplePortions(
    const Team& team, Steps& steps, const chainmail::BoxVisitor& visit, chainmail::Resampled& resampled);
  void ShareVoxels(const Team& team, Steps& steps, const Scene* scene);
  void SendVoxels(const Exchange& exchange, Steps& steps, const Scene& scene, const std::vector<int>& wanted) const;
  void ShareSmallest(const Team& team, Steps& steps, const Scene* scene);
  void Choose(const Team& team, const Scene* scene, vtkTypeUInt64 time, Extent& wanted);
  bool Has(vtkImageData* image, const chainmail::VoxelBox& box) const;
  vtkSmartPointer<vtkDataArray> ScalarsOf(vtkImageData* image) const;

  const Session& Source;
  Progress& Reports;

  // Of the present update.
  OutputPlan Plan;
  std::optional<chainmail::OutputDetail> Part;
  chainmail::Sources Sources;
  chainmail::CutSurfaces Cuts = chainmail::CutSurfaces::Stepped;

  vtkSmartPointer<vtkImageData> Image;
  chainmail::VoxelBox Box;
  std::uint64_t ImageTime = 0; // of the whole image, from which these voxels are
  vtkSmartPointer<vtkDataArray> Scalars;
  vtkSmartPointer<vtkImageData> FarImage;
  chainmail::VoxelBox FarBox;
  vtkSmartPointer<vtkDataArray> FarScalars;
  std::vector<vtkSmartPointer<vtkDataArray>> Smallest;
  std::uint64_t SmallestTime = 0;

  std::unique_ptr<chainmail::Resampler> Elsewhere; // outside the root, and there for portions
  bool IsInPortions = false;                       // whether tissue comes in portions, while voxels are sampled
  std::vector<chainmail::TissueReceiver> Portions; // of all processes in turn; on the root
  int NumberOfPortions = 0;                        // of this process
  int PortionsShown = 0;
  std::string Device;
  int Version = 0;
};

}

#endif
