#pragma once

#include "Bricks.h"

#include <memory>

namespace chainmail
{

/// The tissue on a grid of half as many elements per axis. `finer` must outlive it.
std::shared_ptr<const Model> coarserModel(const Bricks& finer);

/// Removes the links of a coarser grid that cuts of the finer one have severed. A coarser link goes where all links
/// across the boundary of its two elements are gone, or all those within an element along that axis; that element then
/// stays with the lower side.
void coarsenCuts(const Bricks& finer, Bricks& coarser);

}
