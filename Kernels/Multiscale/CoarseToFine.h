#pragma once

#include "Feasibility.h"
#include "Handles.h"
#include "Relaxation.h"

#include <memory>
#include <vector>

namespace chainmail
{

/// Lowers the energy of a state faster than sweeps on it alone. It relaxes the state on grids of an eighth, a
/// sixty-fourth, ... of its elements, as multigrid methods do, and each is the start of the next finer one
/// (coarsen.cl). A sweep carries a displacement by one element, which on a coarser grid is many voxels.
///
/// An element of a coarser grid stands for 2 x 2 x 2. Its constraint is about their mean; it is rigid where at least
/// half of them are, and held where one of them is. A handle that goes further than a coarser grid can stretch gives
/// way there. Displacements are interpolated, smoothed as if links had no limits, and projected to feasible
/// (Feasibility). Pieces of tissue that no link joins to tissue that moves stay where they are, however close they lie.
///
/// The result is rough, above all where links were beyond their limits, and may have a higher energy than before
/// although it is close to the optimum. So it is judged after the first sweeps on the finest grid have smoothed it.
class CoarseToFine
{
public:
  CoarseToFine(Bricks& bricks, Handles& handles);
  ~CoarseToFine();

  /// Runs one cycle through all grids. The state must be feasible, and stays so. Returns whether there was anything to
  /// do; if so, judge() has to follow, after at most sweepsToJudge sweeps.
  bool run(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  static constexpr int sweepsToJudge = 4;

  /// Where the energy is higher than before run(), goes back to the lowest energy on the straight way between the two
  /// states, on which all states are feasible; where elements turn, to the state before. Returns the share of the way
  /// that is kept.
  double judge(const Elasticity& elasticity);

  /// To be called after a cut or a carve: the coarser grids are built anew.
  void forget();

private:
  class Level;

  void build();
  double energy(const Elasticity& elasticity) const;
  void cycle(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  void goBack(float share);
  void putOthersBack(const Checkpoint& checkpoint);
  std::vector<std::uint32_t> markSoft(const std::vector<int>& slots, std::vector<cl_int>& found) const;
  std::vector<char> mayMove(const std::vector<int>& slots, const std::vector<cl_int>& found) const;

  Bricks& bricks_;
  Handles& handles_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  EnvelopePropagation propagation_;
  Feasibility feasibility_;
  Relaxation relaxation_;
  FixedPoint pieces_;
  Field before_{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  Field spinsBefore_{ 3, sizeof(cl_float), "the rotations before a relaxation" };
  bool turnedBefore_ = false; ///< whether there were any
  double energyBefore_ = 0.0;
  bool feasible_ = true; ///< whether the finest grid could be made feasible
  Field marks_{ 1, sizeof(cl_int), "what hangs together" };
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "what hangs together" };
};

}
