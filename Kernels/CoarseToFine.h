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
/// An element of a coarser grid stands for 2 x 2 x 2. It gives about as much as they do, is rigid where at least
/// half of them are, and held where one of them is; a hand that goes further than a coarser grid stretches gives way
/// there. Displacements are interpolated, and the result made feasible (Repair); where that did not lower the energy
/// nothing changes. Pieces of tissue that do not hang on anything that moves stay where they are, however close.
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
  void cycle(const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint);
  void putOthersBack(const Checkpoint& checkpoint);

  Bricks& bricks_;
  Holds& holds_;
  std::vector<std::unique_ptr<Level>> levels_; ///< from finer to coarser
  Propagation propagation_;
  Repair repair_;
  Spread pieces_;
  Field before_{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  Field marks_{ 1, sizeof(cl_int), "what hangs together" };
  Scratch list_{ "the list of bricks" };
};

}
