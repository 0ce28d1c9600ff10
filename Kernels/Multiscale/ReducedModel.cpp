#include "ReducedModel.h"

#include "ElementRule.h"
#include "Error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

Grid reducedGrid(const Grid& whole, const Index3& factor)
{
  Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = (whole.size[a] + factor[a] - 1) / factor[a];
    grid.spacing[a] = factor[a] * whole.spacing[a];
  }
  return grid;
}

/// The signed constraint of an element on one axis: the mean over its voxels.
struct Mean
{
  double sum = 0.0;
  int count = 0;
  bool rigid = false;
  bool anchored = false;

  void add(float c)
  {
    this->sum += std::fabs(c);
    ++this->count;
    this->rigid = this->rigid || c == 0.0f;
    this->anchored = this->anchored || std::signbit(c);
  }

  float signedConstraint() const
  {
    if (this->count == 0)
    {
      return -std::numeric_limits<float>::infinity();
    }
    const float c = this->rigid ? 0.0f : static_cast<float>(this->sum / this->count);
    return rule::asHeld(c, this->anchored);
  }
};

}

std::shared_ptr<const Model> reducedModel(
  const Bricks& finer, const Index3& factor, std::vector<std::pair<std::size_t, int>>& apart)
{
  if (finer.model().isDivided())
  {
    throw InputError("A reduced model makes bone thicker, which closes the joints between bodies. Set ModelReduction "
                     "to 1, or do not divide the bone (BodyArray empty, JointSize 0).");
  }
  const Grid& whole = finer.model().grid();
  const Grid grid = reducedGrid(whole, factor);
  const std::size_t axes = static_cast<std::size_t>(finer.model().axes());
  const std::size_t width = static_cast<std::size_t>(whole.size[0]);
  const std::size_t layer = width * whole.size[1];
  auto constraints = std::make_shared<std::vector<float>>(grid.voxels() * axes);
  std::vector<std::uint8_t> linked(grid.voxels(), 0); // bit a: linked to the next one along axis a
  std::vector<Mean> means(static_cast<std::size_t>(grid.size[0]) * grid.size[1] * axes);
  std::vector<char> tissue(2 * layer); // of this layer of voxels and of the one before it
  std::vector<float> row(width * axes);
  for (int k = 0; k < whole.size[2]; ++k)
  {
    char* const here = tissue.data() + k % 2 * layer;
    const char* const below = tissue.data() + (k + 1) % 2 * layer;
    const bool crossesZ = k > 0 && k % factor[2] == 0;
    for (int j = 0; j < whole.size[1]; ++j)
    {
      finer.row(0, j, k, whole.size[0], row.data());
      const bool crossesY = j > 0 && j % factor[1] == 0;
      const std::size_t first = grid.at(0, j / factor[1], k / factor[2]);
      const std::size_t inLayer = first - grid.at(0, 0, k / factor[2]);
      char* const line = here + j * width;
      for (int i = 0; i < whole.size[0]; ++i)
      {
        line[i] = !std::isinf(row[i * axes]);
        if (!line[i])
        {
          continue;
        }
        const std::size_t x = static_cast<std::size_t>(i / factor[0]);
        for (std::size_t a = 0; a < axes; ++a)
        {
          means[(inLayer + x) * axes + a].add(row[i * axes + a]);
        }
        if (i > 0 && i % factor[0] == 0 && line[i - 1])
        {
          linked[first + x - 1] |= 1;
        }
        if (crossesY && line[i - static_cast<std::ptrdiff_t>(width)])
        {
          linked[first + x - grid.size[0]] |= 2;
        }
        if (crossesZ && below[j * width + i])
        {
          linked[first + x - static_cast<std::size_t>(grid.size[0]) * grid.size[1]] |= 4;
        }
      }
    }
    if ((k + 1) % factor[2] == 0 || k + 1 == whole.size[2])
    {
      std::transform(means.begin(), means.end(), constraints->begin() + means.size() * (k / factor[2]),
        [](const Mean& mean) { return mean.signedConstraint(); });
      std::fill(means.begin(), means.end(), Mean());
    }
  }

  for (std::size_t n = 0; n < grid.voxels(); ++n)
  {
    const Index3 at = grid.indexOf(n);
    for (int a = 0; a < 3 && !std::isinf((*constraints)[n * axes]); ++a)
    {
      const Index3 next{ at[0] + (a == 0), at[1] + (a == 1), at[2] + (a == 2) };
      if (next[a] < grid.size[a] && !std::isinf((*constraints)[grid.at(next[0], next[1], next[2]) * axes]) &&
          !(linked[n] >> a & 1))
      {
        apart.push_back({ n, a });
      }
    }
  }
  return finer.model().derived(grid, [constraints, axes](std::size_t first, int count, float* out)
    { std::copy_n(constraints->begin() + first * axes, count * axes, out); });
}

}
