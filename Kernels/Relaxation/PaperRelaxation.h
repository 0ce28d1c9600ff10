#pragma once

#include "Relaxer.h"
#include "SweepSchedule.h"

namespace chainmail
{

/// Relaxation as published (paper.cl; Rodriguez, Leon, Arroyo: Parallel deformation of heterogeneous ChainMail models,
/// eqs. 7 and 8): all elements that are not held go at once to the weighted mean of the places that their neighbours
/// ask for, with the weights 1 / (D + eps).
///
/// Only bricks in which something can change are visited.
///
/// The method has these limitations:
/// - It ignores the limits of links. Links end beyond them, so the next wave starts from a state that is not feasible
///   (Statistics::maxLinkExcess tells by how much).
/// - Elements of two colours may change places for ever: a checkerboard never decays where nothing is held.
/// - Rigid elements hold each other where they are: a bone hardly follows, and bends.
class PaperRelaxation : public Relaxer
{
public:
  explicit PaperRelaxation(Bricks& bricks)
    : bricks_(bricks)
    , schedule_(bricks)
  {
  }

  ~PaperRelaxation() override { this->bricks_.drop(this->next_); }

  RelaxResult run(const RelaxationTask& task) override;
  bool keepsLimits() const override { return false; }

  /// Gives back the memory of the second copy of the state.
  void release() override { this->bricks_.drop(this->next_); }

private:
  void relaxAll(const RelaxationTask& task, int iteration, bool back, float still);

  Bricks& bricks_;
  SweepSchedule schedule_;
  Field next_{ 3, sizeof(cl_float), "the state after an iteration of the published relaxation" };
};

}
