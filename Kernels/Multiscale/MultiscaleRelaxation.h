#pragma once

#include "CoarseToFine.h"
#include "Relaxer.h"

namespace chainmail
{

/// Relaxation by sweeps over the elements (Relaxation), which may start on coarser grids and be corrected there
/// (CoarseToFine).
class MultiscaleRelaxation : public Relaxer
{
public:
  MultiscaleRelaxation(Bricks& bricks, Handles& handles)
    : handles_(handles)
    , relaxation_(bricks)
    , coarseToFine_(bricks, handles)
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
  Handles& handles_;
  Relaxation relaxation_;
  CoarseToFine coarseToFine_;
  bool startsCoarse_ = false;
  bool mayStartCoarse_ = true;
  int sweep_ = 0;            ///< sweeps since the last wave, cut, carve or correction
  Range range_ = Range::Far; ///< what these sweeps are for
};

}
