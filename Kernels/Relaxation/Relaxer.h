#pragma once

#include "Elasticity.h"
#include "RigidClusters.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// What one call of a relaxation is to do.
struct RelaxationTask
{
  std::function<RigidClusters&()> clusters; ///< gives the rigid clusters of the tissue as it is, which may take time
  const Elasticity& elasticity;
  const WavesUnderWay* waves; ///< waves that are under way; null where there are none
  int iterations;             ///< the most iterations, 1 or more
  double tolerance;
  std::function<void(int)> checkpoint; ///< to be called with the number of iterations done; throws to stop
};

/// A method by which tissue settles. To add one, derive a class, add a value to RelaxationMethod (Types.h) and a line
/// to Simulation::Impl::relaxer().
class Relaxer
{
public:
  virtual ~Relaxer() = default;

  virtual RelaxResult run(const RelaxationTask& task) = 0;

  /// Whether a feasible state stays feasible. If so, a state that is not is made feasible before run().
  virtual bool keepsLimits() const = 0;

  /// Called when something else has moved tissue: the next run() does not continue the last one. `mayStartCoarse`:
  /// whether it may start on coarser grids, where it is told to.
  virtual void restart(bool /* mayStartCoarse */) {}

  /// Called when links or elements are gone, or are back again. Implies restart().
  virtual void tissueChanged() {}

  /// Called when another method is chosen: gives back memory.
  virtual void release() {}
};

}
