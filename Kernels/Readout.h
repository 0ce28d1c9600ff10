#pragma once

#include "ArrivalTimes.h"
#include "Handles.h"
#include "ModelReduction.h"
#include "RigidClusters.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// What a simulation tells of its state, voxel by voxel, and what its probes pull with: see Simulation.
class Readout
{
public:
  /// `bricks` are those of the elements that deform: the voxels, or where the model is reduced those of `reduction`.
  Readout(Bricks& voxels, Bricks& bricks, const ModelReduction* reduction)
    : voxels_(voxels)
    , bricks_(bricks)
    , reduction_(reduction)
  {
  }

  /// The voxels must be where they are now (ModelReduction::expand()).
  void displacements(float* out, bool zeroed) const;
  void propagationTimes(const ArrivalTimes& arrivals, float* out) const;
  void wavefronts(const ArrivalTimes& arrivals, int* out, bool zeroed) const;
  void clusters(int* out) const;
  void elements(std::uint8_t* out) const;
  void links(std::uint8_t* out) const;

  /// Adds the forces to the results of all probes. `clusters`: of the elements that deform.
  void addForces(std::vector<ProbeResult>& results, const Handles& handles, const RigidClusters& clusters,
    const Elasticity& elasticity) const;

private:
  Bricks& voxels_;
  Bricks& bricks_;
  const ModelReduction* reduction_;
};

}
