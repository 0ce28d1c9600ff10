#pragma once

#include "Relaxer.h"
#include "SweepSchedule.h"

namespace chainmail
{

/// Relaxation as published (paper.cl): every element that is not held goes, all at once, to the weighted mean of the
/// places that its neighbours offer it, w = 1 / (D + eps). Rodriguez, Leon, Arroyo: Parallel deformation of
/// heterogeneous ChainMail models, eqs. 7 and 8.
///
/// Only active bricks are visited.
///
/// Limitations, all of the method:
/// - the limits of links are ignored: links end outside them, so the next wave starts from a state that is not feasible
///   (Statistics::maxLinkExcess tells by how much);
/// - elements of two colours change places for ever: a checkerboard never decays where nothing is held;
/// - rigid elements are held where they are by each other: a bone hardly follows, and bends.
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
