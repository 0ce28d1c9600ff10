#pragma once

#include "Bricks.h"
#include "Types.h"

namespace chainmail
{

/// Removes the links that the surface crosses at the current positions of their elements. Returns how many.
///
/// The decision is exact (ExactGeometry.h): a surface without holes leaves no link across it. Throws as fixedPoints()
/// does.
std::size_t cutLinks(Bricks& bricks, const Surface& surface);

}
