#pragma once

#include "CoarseToFine.h"
#include "Relaxer.h"

#include <limits>

namespace chainmail
{

/// Relaxation by sweeps over the elements (Relaxation), which may start on coarser grids and be corrected there
/// (CoarseToFine). It ends early where what it still lacks is estimated to be small (RelaxationTask::error).
class MultiscaleRelaxation : public Relaxer
{
public:
  MultiscaleRelaxation(Bricks& bricks, Handles& handles)
    : handles_(handles)
    , relaxation_(bricks)
    , start_(bricks)
    , coarseToFine_(bricks, handles, start_)
  {
  }

  /// Whether the first sweeps after a restart start on coarser grids. Default: not.
  void startCoarse(bool wanted) { this->startsCoarse_ = wanted; }

  RelaxResult run(const RelaxationTask& task) override;
  bool keepsLimits() const override { return true; }
  void restart(bool mayStartCoarse) override
  {
    this->sweep_ = 0;
    this->mayStartCoarse_ = mayStartCoarse;
  }
  void tissueChanged() override;

private:
  void sweep(const RelaxationTask& task, RigidClusters& clusters, int most, RelaxResult& result);
  void correct(const RelaxationTask& task, RigidClusters& clusters, double energy, RelaxResult& result);
  void sweepRound(const RelaxationTask& task, RigidClusters& clusters, RelaxResult& result);
  bool isNear(const RelaxationTask& task) const { return task.error > 0.0 && this->distance_ <= task.error; }

  Handles& handles_;
  Relaxation relaxation_;
  StepStart start_;
  CoarseToFine coarseToFine_;
  bool startsCoarse_ = false;
  bool mayStartCoarse_ = true;
  int sweep_ = 0;            ///< sweeps since the last wave, cut, carve or correction
  Range range_ = Range::Far; ///< what these sweeps are for
  double distance_ =
    std::numeric_limits<double>::infinity(); ///< from the optimum, as estimated for RelaxationTask::error
};

}
