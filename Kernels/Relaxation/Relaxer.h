#pragma once

#include "Elasticity.h"
#include "RigidClusters.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// The arguments of one run of a relaxation.
struct RelaxationTask
{
  std::function<RigidClusters&()> clusters; ///< returns the rigid clusters of the current tissue; may take time
  const Elasticity& elasticity;
  const WavesUnderWay* waves; ///< waves that are under way; null where there are none
  int iterations;             ///< maximum number of iterations, 1 or more
  double tolerance;
  double error; ///< the relaxation also ends where its distance from the optimum is estimated to be at most this, rms,
                ///< as a fraction of the largest displacement; 0: no estimate
  std::function<void(int)> checkpoint; ///< called with the number of iterations done; throws to stop
};

/// A relaxation method. To add one, derive a class and add a value to RelaxationMethod (Types.h). Simulation::Impl
/// keeps it as a member, which relaxer() returns and tissueChanged() tells of changes. In the filter it is a value of
/// RelaxationMethod: in its header, in Choices.h, and in the panel's XML.
class Relaxer
{
public:
  virtual ~Relaxer() = default;

  virtual RelaxResult run(const RelaxationTask& task) = 0;

  /// Whether a feasible state stays feasible. If so, an infeasible state is made feasible before run().
  virtual bool keepsLimits() const = 0;

  /// Called when anything else has moved tissue: the next run() does not continue the previous one. `mayStartCoarse`:
  /// whether the next run() may start on coarser grids, if that is switched on.
  virtual void restart(bool /* mayStartCoarse */) {}

  /// Called when links or elements have been removed or restored. Implies restart().
  virtual void tissueChanged() {}

  /// Called when another method is chosen: frees memory.
  virtual void release() {}
};

}
