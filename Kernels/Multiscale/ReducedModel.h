#pragma once

#include "Bricks.h"

#include <memory>
#include <utility>
#include <vector>

namespace chainmail
{

/// The tissue on a grid whose elements stand for `factor` voxels of `finer` along each axis; an element's constraint is
/// the mean of theirs. Fills `apart` with the elements that have no link to the next one along an axis, though both
/// exist.
std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart);

}
