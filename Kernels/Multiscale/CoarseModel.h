#pragma once

#include "Bricks.h"

#include <memory>

namespace chainmail
{

/// The tissue on a grid of half as many elements per axis. `finer` must outlive it. `inMemory`: whether all constraints
/// are computed now and kept; else each is computed from `finer` whenever it is read.
std::shared_ptr<const Model> coarserModel(const Bricks& finer, bool inMemory);

/// Removes the links of a coarser grid that cuts of the finer grid have severed. Where a cut divides the tissue of a
/// coarser element, the element stands for the largest part and is on its side of the cut. A link of such an element
/// stays where a finer link joins this part to that of the other element. So no link leads across a cut, in whatever
/// direction the cut runs through the grid.
void coarsenCuts(const Bricks& finer, Bricks& coarser);

}
