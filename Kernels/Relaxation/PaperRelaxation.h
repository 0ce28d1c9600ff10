#pragma once

#include "Relaxation.h"

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
class PaperRelaxation
{
public:
  explicit PaperRelaxation(Bricks& bricks)
    : bricks_(bricks)
    , schedule_(bricks)
  {
  }

  ~PaperRelaxation() { this->release(); }

  RelaxResult run(const Elasticity& elasticity, const WavesUnderWay* waves, int iterations, double tolerance,
    const std::function<void(int)>& checkpoint);

  /// Gives back the memory of the second copy of the state.
  void release() { this->bricks_.drop(this->next_); }

private:
  void relaxAll(int iteration, bool back, float still, const Elasticity& elasticity, const WavesUnderWay* waves);

  Bricks& bricks_;
  SweepSchedule schedule_;
  Field next_{ 3, sizeof(cl_float), "the state after an iteration of the published relaxation" };
};

}
