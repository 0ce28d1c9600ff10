#include "ReducedModel.h"

#include "Error.h"
#include "ReducedBox.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace chainmail
{

namespace
{

/// The elements of a box that do not touch its sides.
VoxelBox inside(const VoxelBox& box)
{
  VoxelBox inner;
  for (int a = 0; a < 3; ++a)
  {
    inner.first[a] = box.first[a] + 1;
    inner.size[a] = std::max(0, box.size[a] - 2);
  }
  return inner;
}

/// Adds what was found elsewhere: the constraints of the elements of `known`, and links.
void add(const ReducedBox& found, const VoxelBox& known, std::size_t axes, ReducedBox& all)
{
  const VoxelBox& box = found.elements;
  for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
  {
    for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
    {
      const auto from = found.linked.begin() + box.at(box.first[0], j, k);
      std::transform(from, from + box.size[0], all.linked.begin() + all.elements.at(box.first[0], j, k),
        all.linked.begin() + all.elements.at(box.first[0], j, k),
        [](std::uint8_t one, std::uint8_t other) { return static_cast<std::uint8_t>(one | other); });
      if (known.contains(known.first[0], j, k))
      {
        std::copy_n(found.constraints.begin() + axes * box.at(known.first[0], j, k), axes * known.size[0],
          all.constraints.begin() + axes * all.elements.at(known.first[0], j, k));
      }
    }
  }
}

/// All elements. Rows are read only where the model has not found them elsewhere. There they include the sides of each
/// box: what anchors faces of the image, and links across the sides of boxes, is found nowhere else.
ReducedBox reduceAll(const Bricks& finer, const Index3& factor, const Grid& grid)
{
  const Model& model = finer.model();
  const std::vector<ReducedBox> elsewhere = model.reduceElsewhere(factor);
  std::vector<VoxelBox> known;
  std::transform(elsewhere.begin(), elsewhere.end(), std::back_inserter(known),
    [](const ReducedBox& box) { return inside(box.elements); });
  ReducedBox all = reduceBox(
    model.grid(), factor, VoxelBox::all(grid), model.axes(),
    [&](int i, int j, int k, int count, float* out) { finer.row(i, j, k, count, out); }, known);
  for (std::size_t n = 0; n < known.size(); ++n)
  {
    add(elsewhere[n], known[n], static_cast<std::size_t>(model.axes()), all);
  }
  return all;
}

}

std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart)
{
  if (finer.model().isDivided())
  {
    throw InputError("A reduced model makes bone thicker, which closes the joints between bodies. Set ModelReduction "
                     "to 1, or do not divide the bone (BodyArray empty, JointSize 0).");
  }
  const Grid grid = reducedGrid(finer.model().grid(), factor);
  const std::size_t axes = static_cast<std::size_t>(finer.model().axes());
  ReducedBox all = reduceAll(finer, factor, grid);
  const auto constraints = std::make_shared<const std::vector<float>>(std::move(all.constraints));
  for (std::size_t n = 0; n < grid.voxels(); ++n)
  {
    const Index3 at = grid.indexOf(n);
    for (int a = 0; a < 3 && !std::isinf((*constraints)[n * axes]); ++a)
    {
      const Index3 next{ at[0] + (a == 0), at[1] + (a == 1), at[2] + (a == 2) };
      if (next[a] < grid.size[a] && !std::isinf((*constraints)[grid.at(next[0], next[1], next[2]) * axes]) &&
          !(all.linked[n] >> a & 1))
      {
        apart.push_back({ n, a });
      }
    }
  }
  return finer.model().derived(grid, [constraints, axes](std::size_t first, int count, float* out)
    { std::copy_n(constraints->begin() + first * axes, count * axes, out); });
}

}
