#pragma once

#include "Bricks.h"
#include "Elasticity.h"

namespace chainmail
{

/// Has programs built in the background that most scenes need between a pull and their first picture, in the order in
/// which they do. What a scene does not need costs nothing but the work of other cores; what is missing here is built
/// when it is needed.
///
/// `bricks` are the elements that deform, `voxels` those that are resampled. `projected` is the elasticity with which
/// tissue relaxes, null where it does not relax so.
void buildAhead(const Bricks& bricks, const Bricks& voxels, const Elasticity* projected, bool coarseToFine);

}
