#pragma once

#include "Bricks.h"

#include <memory>

namespace chainmail
{

/// The tissue on a grid of half as many elements per axis. `finer` must outlive it. `inMemory`: whether all constraints
/// are computed now and kept; else each is computed from `finer` whenever it is read.
std::shared_ptr<const Model> coarserModel(const Bricks& finer, bool inMemory);

/// Removes the links of a coarser grid that cuts of the finer grid have severed. A coarser link is removed in two
/// cases. Either all finer links across the boundary between its two elements are missing, or all those within its
/// lower element along that axis. In the latter case the lower element stays with its own lower neighbour.
void coarsenCuts(const Bricks& finer, Bricks& coarser);

}
