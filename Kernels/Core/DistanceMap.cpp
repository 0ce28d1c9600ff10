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

  /// Calls visit(n, value at x = 2 n + offset) for n in [0, count).
  template <typename Visit> void evaluate(int count, int offset, const Visit& visit) const
  {
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

void mapDistances(const Grid& grid, const std::vector<char>& solid, bool halfway, std::uint16_t* distances)
{
  std::transform(solid.begin(), solid.end(), distances, [](char is) { return is != 0 ? farthest : std::uint16_t(0); });
  for (int a = 0; a < 3; ++a)
  {
    const int size = grid.size[a];
    const int offset = halfway && size > 1 ? 1 : 0;
    Envelope envelope(size);
    forLines(grid, a,
      [&](std::size_t first, std::size_t stride)
      {
        std::uint16_t* const line = distances + first;
        const std::uint16_t here = line[0];
        envelope.clear();
        bool isUniform = true;
        for (int n = 0; n < size; ++n)
        {
          isUniform = isUniform && line[n * stride] == here;
        }
        if (isUniform)
        {
          for (int n = 0; offset != 0 && here < farthest && n < size; ++n)
          {
            line[n * stride] = static_cast<std::uint16_t>(here + 1);
          }
          return;
        }
        for (int n = 0; n < size; ++n)
        {
          if (line[n * stride] < farthest)
          {
            envelope.add(2 * std::int64_t(n), line[n * stride]);
          }
        }
        envelope.evaluate(size, offset,
          [&](int n, std::int64_t value)
          { line[n * stride] = static_cast<std::uint16_t>(std::min<std::int64_t>(value, farthest)); });
      });
  }
  for (int a = 0; a < 3; ++a)
  {
    if (halfway && grid.size[a] > 1)
    {
      forLines(
        grid, a, [&](std::size_t first, std::size_t stride) { distances[first + (grid.size[a] - 1) * stride] = 0; });
    }
  }
}

}
