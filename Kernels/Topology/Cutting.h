#pragma once

#include "Bricks.h"
#include "Types.h"

namespace chainmail
{

/// Removes the links that a surface crosses at the current places of their elements. Returns how many.
///
/// Exact (ExactGeometry.h): a surface without holes leaves none.
std::size_t cutLinks(Bricks& bricks, const Surface& surface);

}
