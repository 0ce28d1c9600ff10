#pragma once

#include "Feasibility.h"
#include "Handles.h"
#include "Relaxation.h"

#include <memory>
#include <vector>

namespace chainmail
{

/// Lowers the energy of a state faster than sweeps on the finest grid alone, as multigrid methods do. It relaxes the
/// state on grids with 1/8, 1/64, ... of the elements, and each result is the start on the next finer grid
/// (coarsen.cl). A sweep propagates a displacement by one element, which on a coarser grid is many voxels.
///
/// An element of a coarser grid stands for 2 x 2 x 2 finer ones. Its constraint is about their mean. It is rigid if at
/// least half of them are rigid, and held if one of them is held. A handle that is displaced further than a coarser
/// grid can stretch is set back there to a feasible place. Displacements are interpolated, smoothed without the limits
/// of links, and projected to a feasible state (Feasibility). Connected components of tissue that no link joins to
/// moving tissue do not move, however close to it they are.
///
/// The result is rough, above all where links were beyond their limits. Its energy may be higher than before although
/// it is close to the optimum. So judge() compares energies only after the first sweeps on the finest grid have
/// smoothed it.
class CoarseToFine
{
public:
  CoarseToFine(Bricks& bricks, Handles& handles);
  ~CoarseToFine();

  /// Runs one cycle through all grids. The state must be feasible, and stays so. Returns whether there was anything to
  /// do. If so, judge() has to follow, after at most sweepsToJudge sweeps.
  bool run(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  static constexpr int sweepsToJudge = 4;

  /// If the energy is higher than before run(), goes back along the straight line to the state before run(). It stops
  /// at the lowest energy on this line; all states on it are feasible. Where elements rotate, it goes back to the state
  /// before run() itself, also if the current state is infeasible.
  /// Returns the share of the step that is kept, in [0, 1].
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
  Elements markSoft(const std::vector<int>& slots, std::vector<cl_int>& found) const;
  std::vector<char> mayMove(const std::vector<int>& slots, const std::vector<cl_int>& found) const;

  Bricks& bricks_;
  Handles& handles_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  EnvelopePropagation propagation_;
  Feasibility feasibility_;
  Relaxation relaxation_;
  FixedPoint pieces_;
  Field before_{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  Field rotationsBefore_{ 3, sizeof(cl_float), "the rotations before a relaxation" };
  bool rotatedBefore_ = false; ///< whether there were any rotations
  double energyBefore_ = 0.0;
  bool feasible_ = true; ///< whether the finest grid could be made feasible
  Field marks_{ 1, sizeof(cl_int), "the connected components" };
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "the connected components" };
};

}
