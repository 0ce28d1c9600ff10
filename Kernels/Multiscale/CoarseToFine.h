#pragma once

#include "Feasibility.h"
#include "Handles.h"
#include "Relaxation.h"

#include <memory>
#include <vector>

namespace chainmail
{

/// Lowers the energy of a state fast and from afar: relaxes it on grids of an eighth, a sixty-fourth, ... of its
/// elements, each of which is the start of the next finer one (coarsen.cl). What a sweep carries by one voxel a coarse
/// one carries by many.
///
/// An element of a coarser grid stands for 2 x 2 x 2. It gives about as much as they do, is rigid where at least
/// half of them are, and held where one of them is; a handle that goes further than a coarser grid stretches gives way
/// there. Displacements are interpolated, smoothed as if links had no limits, and made feasible (Feasibility). Pieces
/// of tissue that do not hang on anything that moves stay where they are, however close.
///
/// What that leaves is rough, above all where links were beyond their limits, and can have more energy than before,
/// however close to the optimum it is. So it is judged when the first sweeps on the finest grid have smoothed it.
class CoarseToFine
{
public:
  CoarseToFine(Bricks& bricks, Handles& handles);
  ~CoarseToFine();

  /// One cycle through all grids. The state must be feasible, and stays so. Returns whether there was anything to do;
  /// then judge() has to follow, after as many as sweepsToJudge sweeps.
  bool run(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  static constexpr int sweepsToJudge = 4;

  /// Where the energy is higher than before run(), goes back to the lowest on the straight way from there to here, on
  /// which all is feasible. Returns the share of the way that is kept.
  double judge(const Elasticity& elasticity);

  /// After a cut or a carve.
  void forget();

private:
  class Level;

  void build();
  double energy(const Elasticity& elasticity) const;
  void cycle(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  void goBack(float share);
  void putOthersBack(const Checkpoint& checkpoint);

  Bricks& bricks_;
  Handles& handles_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  EnvelopePropagation propagation_;
  Feasibility feasibility_;
  Relaxation relaxation_;
  FixedPoint pieces_;
  Field before_{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  double energyBefore_ = 0.0;
  Field marks_{ 1, sizeof(cl_int), "what hangs together" };
  Scratch list_{ "the list of bricks" };
};

}
