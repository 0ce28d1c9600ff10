#include "DistanceMap.h"

#include "Neighbours.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace chainmail
{

namespace
{

/// The lower envelope of parabolas (x - middle)^2 + height over the integers. Parabolas are added in ascending order of
/// their middles.
class Envelope
{
public:
  explicit Envelope(int most)
    : parabolas_(most)
  {
  }

  void clear() { this->count_ = 0; }

  void add(std::int64_t middle, std::int64_t height)
  {
    std::int64_t first = std::numeric_limits<std::int64_t>::min();
    for (; this->count_ > 0; --this->count_)
    {
      // The new parabola is below the last one where 2 x (middle - last.middle) > rise.
      const Parabola& last = this->parabolas_[this->count_ - 1];
      const std::int64_t rise = middle * middle + height - last.middle * last.middle - last.height;
      const std::int64_t run = 2 * (middle - last.middle);
      first = (rise - (rise < 0 ? run - 1 : 0)) / run + 1;
      if (first > last.first)
      {
        break;
      }
      first = std::numeric_limits<std::int64_t>::min();
    }
    this->parabolas_[this->count_++] = { middle, height, first };
  }

  /// Calls visit(n, value at x = 2 n + offset) for n in [0, count); not where there are no parabolas.
  template <typename Visit> void evaluate(int count, int offset, const Visit& visit) const
  {
    if (this->count_ == 0)
    {
      return;
    }
    const Parabola* lowest = this->parabolas_.data();
    const Parabola* const last = lowest + this->count_ - 1;
    for (int n = 0; n < count; ++n)
    {
      const std::int64_t x = 2 * std::int64_t(n) + offset;
      while (lowest < last && lowest[1].first <= x)
      {
        ++lowest;
      }
      const std::int64_t way = x - lowest->middle;
      visit(n, way * way + lowest->height);
    }
  }

private:
  struct Parabola
  {
    std::int64_t middle;
    std::int64_t height;
    std::int64_t first; ///< the x from which on it is the lowest
  };
  std::vector<Parabola> parabolas_;
  int count_ = 0;
};

}

std::vector<std::uint16_t> mapDistances(const Grid& grid, const VoxelMap<char>& solid, bool halfway)
{
  const VoxelSet& where = solid.where();
  std::vector<std::uint16_t> distances(solid.values().size());
  std::transform(solid.values().begin(), solid.values().end(), distances.begin(),
    [](char is) { return is != 0 ? farthest : std::uint16_t(0); });
  // Of voxels outside `where`, which are not solid: the way from the point to their own centres, as far as it is known.
  std::uint16_t elsewhere = 0;
  for (int a = 0; a < 3; ++a)
  {
    const int size = grid.size[a];
    const std::size_t stride = stridesOf(grid)[a];
    const int offset = halfway && size > 1 ? 1 : 0;
    std::vector<std::size_t> numbers(static_cast<std::size_t>(size));
    Envelope envelope(size);
    VoxelSet lines(grid); // with a voxel of `where`; of each its first voxel
    where.forEach([&](std::size_t voxel) { lines.insert(voxel - grid.indexOf(voxel)[a] * stride); });
    lines.forEach(
      [&](std::size_t first)
      {
        envelope.clear();
        for (int n = 0; n < size; ++n)
        {
          numbers[n] = where.numberOf(first + n * stride);
          const std::uint16_t height = numbers[n] == VoxelSet::none ? elsewhere : distances[numbers[n]];
          if (height < farthest)
          {
            envelope.add(2 * std::int64_t(n), height);
          }
        }
        envelope.evaluate(size, offset,
          [&](int n, std::int64_t value)
          {
            if (numbers[n] != VoxelSet::none)
            {
              distances[numbers[n]] = static_cast<std::uint16_t>(std::min<std::int64_t>(value, farthest));
            }
          });
      });
    elsewhere = static_cast<std::uint16_t>(elsewhere + offset);
  }
  std::size_t number = 0;
  where.forEach(
    [&](std::size_t voxel)
    {
      const Index3 at = grid.indexOf(voxel);
      for (int a = 0; a < 3; ++a)
      {
        const bool isBeyond = halfway && grid.size[a] > 1 && at[a] + 1 == grid.size[a];
        distances[number] = isBeyond ? std::uint16_t(0) : distances[number];
      }
      ++number;
    });
  return distances;
}

}
