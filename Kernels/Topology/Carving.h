#pragma once

#include "Bricks.h"
#include "ClosedSurface.h"

namespace chainmail
{

/// Removes the elements whose current position lies inside the surface. The decision is exact: where two surfaces share
/// a face, every element there lies in just one of them. Returns the removed elements (Grid::at), ascending.
std::vector<std::size_t> carveElements(Bricks& bricks, const ClosedSurface& surface);

}
