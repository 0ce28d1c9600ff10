#pragma once

#include "Relaxer.h"
#include "SweepSchedule.h"

namespace chainmail
{

/// Relaxation as published (paper.cl; Rodriguez, Leon, Arroyo: Parallel deformation of heterogeneous ChainMail models,
/// eqs. 7 and 8), a Jacobi iteration. All elements that are not held move at once, each to the weighted mean of the
/// target places of its links. The weights are 1 / (D + eps).
///
/// Only bricks in which something can change are visited.
///
/// The method has these limitations:
/// - It ignores the limits of links. Links end beyond them, so the next wave starts from an infeasible state
///   (Statistics::maxLinkExcess gives the excess).
/// - Elements of two colours may oscillate for ever: a checkerboard never decays where nothing is held.
/// - Rigid elements lock each other: a bone hardly follows, and bends.
class PaperRelaxation : public Relaxer
{
public:
  explicit PaperRelaxation(Bricks& bricks)
    : bricks_(bricks)
    , schedule_(bricks)
  {
  }

  ~PaperRelaxation() override { this->bricks_.removeField(this->next_); }

  RelaxResult run(const RelaxationTask& task) override;
  bool keepsLimits() const override { return false; }

  /// Frees the second copy of the state.
  void release() override { this->bricks_.removeField(this->next_); }

private:
  void relaxAll(const RelaxationTask& task, int iteration, bool back, float still);

  Bricks& bricks_;
  SweepSchedule schedule_;
  Field next_{ 3, sizeof(cl_float), "the state after an iteration of the published relaxation" };
};

}
