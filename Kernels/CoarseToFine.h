#pragma once

#include "Holds.h"
#include "Relaxation.h"
#include "Repair.h"

#include <memory>
#include <vector>

namespace chainmail
{

/// Lowers the energy of a state fast and from afar: relaxes it on grids of an eighth, a sixty-fourth, ... of its
/// elements, each of which is the start of the next finer one (coarsen.cl). What a sweep carries by one voxel a coarse
/// one carries by many.
///
/// An element of a coarser grid stands for 2 x 2 x 2. It gives as much as they do on average, is rigid where at least
/// half of them are, and held where one of them is. Its displacement is interpolated, and the result made feasible
/// (Repair); where that did not lower the energy nothing changes.
class CoarseToFine
{
public:
  CoarseToFine(Bricks& bricks, Holds& holds);
  ~CoarseToFine();

  /// One cycle through all grids. The state must be feasible, and stays so. Returns whether it changed.
  bool run(const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);

  /// After a cut or a carve.
  void forget();

  std::size_t deviceBytes() const;

private:
  class Level;

  void build();
  double energy(const Elasticity& elasticity) const;

  Bricks& bricks_;
  Holds& holds_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  Propagation propagation_;
  Repair repair_;
};

}
