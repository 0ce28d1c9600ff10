#pragma once

#include "Elasticity.h"
#include "RigidClusters.h"
#include "Types.h"
#include "WavesUnderWay.h"

#include <functional>

namespace chainmail
{

/// What a relaxation is asked for.
struct RelaxationTask
{
  std::function<RigidClusters&()> clusters; ///< of the tissue as it is; finding them takes time
  const Elasticity& elasticity;
  const WavesUnderWay* waves; ///< null: none
  int iterations;             ///< at most so many, 1 or more
  double tolerance;
  std::function<void(int)> checkpoint; ///< to be called with the number of iterations that are done; throws to stop
};

/// A way in which tissue settles. Another one is a class of its own that implements this, a value of RelaxationMethod
/// (Types.h) and a line in Simulation::Impl::relaxer().
class Relaxer
{
public:
  virtual ~Relaxer() = default;

  virtual RelaxResult run(const RelaxationTask& task) = 0;

  /// Whether a feasible state stays so. One that is not is made so before.
  virtual bool keepsLimits() const = 0;

  /// Something else has moved tissue: what run() does next is not the continuation of what it did last.
  virtual void restart() {}

  /// Links or elements are gone, or are back again. Implies restart().
  virtual void tissueChanged() {}

  /// Another one is asked from now on: gives back memory.
  virtual void release() {}
};

}
