#pragma once

#include "Feasibility.h"
#include "Handles.h"
#include "Relaxation.h"
#include "StepStart.h"
#include "TissueComponents.h"

#include <memory>
#include <vector>

namespace chainmail
{

/// Lowers the energy of a state faster than sweeps on the finest grid alone, as multigrid methods do. It relaxes the
/// state on grids with 1/8, 1/64, ... of the elements, and each result is the start on the next finer grid
/// (coarsen.cl). A sweep propagates a displacement by one element, which on a coarser grid is many voxels.
///
/// An element of a coarser grid stands for 2 x 2 x 2 finer ones. Its constraint follows from the rows of links in it
/// (CoarseModel.cpp). It is rigid if at least half of its tissue is rigid and it contains no joint. It is held if one
/// of the finer elements is held. A handle that is displaced further than a coarser grid can stretch is set back there
/// to a feasible place. Displacements are interpolated, smoothed without the limits of links, and projected to a
/// feasible state (Feasibility). Only connected components of tissue in which an element is held and a link is strained
/// move. Others are at rest as they are, or nothing holds them. But coarser grids cannot distinguish them from tissue
/// close by, so they are put back.
///
/// The result is rough, above all where links were beyond their limits and around rigid clusters. Its energy may be
/// higher than before although it is close to the optimum. So judge() compares energies only after the first sweeps on
/// the finest grid have smoothed it.
class CoarseToFine
{
public:
  /// `start`: the displacements at the start of run() or correct(), which these save there.
  CoarseToFine(Bricks& bricks, Handles& handles, StepStart& start);
  ~CoarseToFine();

  /// Runs one cycle through all grids. The state must be feasible, and stays so. Returns whether there was anything to
  /// do. If so, judge() has to follow, after at most sweepsToJudge sweeps.
  bool run(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  static constexpr int sweepsToJudge = 4;

  /// Runs one more cycle, for what the sweeps after judge() have left (correction.cl). Coarser grids solve for a
  /// correction here, not for the state itself, so what they show less well than the finest grid does no harm. Elements
  /// that the limits of links keep where they are stay there, and rigid clusters move as a whole. judge() has to follow
  /// as after run(). `energy`: that of the state.
  void correct(RigidClusters& clusters, const Elasticity& elasticity, double energy, const Checkpoint& checkpoint);
  /// Whether there are corrections after run(): not where elements rotate, strain costs no energy at first, with soft
  /// links, or where constraints differ by axis and rigid clusters can move.
  bool corrects(const RigidClusters& clusters, const Elasticity& elasticity) const
  {
    return !(this->bricks_.model().axes() > 1 && clusters.anyFree()) && !this->bricks_.rotations() &&
           !this->bricks_.softLinks() && elasticity.slack == 0.0f;
  }

  struct Judgement
  {
    double kept;   ///< the share of the step that is kept, in [0, 1]
    double energy; ///< of the state then
    double drop;   ///< the share of the energy before the step that is gone
  };
  /// If the energy is higher than before run() or correct(), goes back along the straight line to the state before it.
  /// It stops at the lowest energy on this line; all states on it are feasible. Where elements rotate, it goes back to
  /// the state before run() itself, also if the current state is infeasible.
  Judgement judge(const Elasticity& elasticity);

  /// The energy of the state.
  double energy(const Elasticity& elasticity) const;

  /// To be called at the end of a relaxation, also of one that was stopped: frees what only cycles need.
  void release();

  /// To be called after a cut or a carve: the coarser grids are built anew.
  void forget();

private:
  class Level;

  void build();
  void cycle(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  void smooth(RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  std::vector<char> movingComponents();
  bool isStrained(int component, const std::vector<char>& hasStrain);
  bool isStrained(int component, int brick);
  void putOthersBack();
  void addElements(int component, Elements& elements) const;

  Bricks& bricks_;
  Handles& handles_;
  StepStart& start_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  EnvelopePropagation propagation_;
  Feasibility feasibility_;
  Relaxation relaxation_;
  std::unique_ptr<TissueComponents> components_; ///< made together with the levels
  std::vector<char> moves_;                      ///< of each component whether this cycle may move it
  Field rotationsBefore_{ 3, sizeof(cl_float), "the rotations before a relaxation" };
  Field residual_{ 3, sizeof(cl_float), "the residuals of a relaxation" };
  bool rotatedBefore_ = false; ///< whether there were any rotations
  double energyBefore_ = 0.0;  ///< the energy before run() or correct()
  bool feasible_ = true;       ///< whether the finest grid could be made feasible
  Scratch list_{ "the list of bricks" };
  Scratch found_{ "the list of bricks" };
};

}
