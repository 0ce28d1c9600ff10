#pragma once

#include "Bricks.h"

#include <memory>
#include <utility>
#include <vector>

namespace chainmail
{

/// The tissue on a grid whose elements stand for `factor` voxels along each axis, those of `finer`, and give as much as
/// these do on average. `apart`: its elements without a link to the next one along an axis, though both are there.
std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart);

}
