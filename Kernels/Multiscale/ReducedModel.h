#pragma once

#include "Bricks.h"

#include <memory>
#include <utility>
#include <vector>

namespace chainmail
{

/// The tissue on a grid whose elements stand for `factor` voxels of `finer` along each axis. The constraint of an
/// element is the mean of those of its tissue voxels, or 0 if one of them is rigid. Fills `apart` with (element, axis)
/// where this element and the next one along the axis exist but are not linked.
std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart);

}
