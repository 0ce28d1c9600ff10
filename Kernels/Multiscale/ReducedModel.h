#pragma once

#include "Bricks.h"

#include <memory>
#include <utility>
#include <vector>

namespace chainmail
{

/// The tissue on a grid whose elements stand for `factor` voxels of `finer` along each axis (see ReducedBox). Fills
/// `apart` with (element, axis) where this element and the next one along the axis exist but are not linked. To be
/// called before anything is cut or carved.
std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart);

}
