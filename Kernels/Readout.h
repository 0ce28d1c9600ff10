#pragma once

#include "ArrivalTimes.h"
#include "Handles.h"
#include "ModelReduction.h"
#include "RigidClusters.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Reads the state of a simulation, for boxes of voxels, and the forces of its probes. See Simulation for the formats.
class Readout
{
public:
  /// `bricks` are those of the elements that deform: `voxels` or, where the model is reduced, those of `reduction`.
  Readout(Bricks& voxels, Bricks& bricks, ModelReduction* reduction)
    : voxels_(voxels)
    , bricks_(bricks)
    , reduction_(reduction)
  {
  }

  void displacements(const VoxelBox& box, float* out, bool zeroed) const;
  void propagationTimes(const ArrivalTimes& arrivals, const VoxelBox& box, float* out) const;
  void wavefronts(const ArrivalTimes& arrivals, const VoxelBox& box, int* out, bool zeroed) const;
  void clusters(const VoxelBox& box, int* out) const;
  void elements(const VoxelBox& box, std::uint8_t* out) const;
  void links(const VoxelBox& box, std::uint8_t* out, bool ofPictures) const;

  /// The tissue voxels that an element stands for, ascending.
  std::vector<std::size_t> voxelsOf(std::size_t element) const;

  /// `clusters` are those of the elements that deform.
  std::vector<RigidBody> bodies(const Handles& handles, const RigidClusters& clusters) const;

  /// Adds the forces to the results of all probes. `clusters` are those of the elements that deform.
  void addForces(std::vector<ProbeResult>& results, Handles& handles, const RigidClusters& clusters,
    const Elasticity& elasticity) const;

private:
  void readDisplacements(const VoxelBox& box, float* out) const;

  Bricks& voxels_;
  Bricks& bricks_;
  ModelReduction* reduction_;
};

}
