#include "CarryAir.h"

#include "Threads.h"

#include <algorithm>

namespace chainmail
{

template <typename Get> CarryAir::Level CarryAir::coarser(const Index3& size, const Get& get)
{
  Level level;
  level.size = { (size[0] + 1) / 2, (size[1] + 1) / 2, (size[2] + 1) / 2 };
  const std::size_t blocks = level.at(0, 0, level.size[2]);
  level.values.assign(3 * blocks, 0.0f);
  level.known.assign(blocks, 0);
  inParallel(static_cast<std::size_t>(level.size[2]),
    [&](std::size_t slice)
    {
      const int k = static_cast<int>(slice);
      for (int j = 0; j < level.size[1]; ++j)
      {
        for (int i = 0; i < level.size[0]; ++i)
        {
          Vector3 sum{};
          int count = 0;
          for (int n = 0; n < 8; ++n)
          {
            const Index3 at{ 2 * i + (n & 1), 2 * j + (n >> 1 & 1), 2 * k + (n >> 2) };
            const bool isThere = at[0] < size[0] && at[1] < size[1] && at[2] < size[2];
            count += isThere && get(at, sum) ? 1 : 0;
          }
          const std::size_t block = level.at(i, j, k);
          level.known[block] = count > 0;
          for (int a = 0; a < 3 && count > 0; ++a)
          {
            level.values[3 * block + a] = static_cast<float>(sum[a] / count);
          }
        }
      }
    });
  return level;
}

CarryAir::CarryAir(const RestModel& model)
{
  std::vector<Level> levels;
  levels.push_back(coarser(model.grid.size,
    [&](const Index3& at, Vector3& sum)
    {
      if (!model.isElement(at))
      {
        return false;
      }
      const Vector3 u = model.displacementAt(at);
      std::transform(sum.begin(), sum.end(), u.begin(), sum.begin(), [](double a, double b) { return a + b; });
      return true;
    }));
  const auto isFull = [](const Level& level)
  { return std::find(level.known.begin(), level.known.end(), 0) == level.known.end(); };
  while (!isFull(levels.back()) && levels.back().known.size() > 1)
  {
    const Level& fine = levels.back();
    levels.push_back(coarser(fine.size,
      [&](const Index3& at, Vector3& sum)
      {
        const std::size_t block = fine.at(at[0], at[1], at[2]);
        for (int a = 0; a < 3; ++a)
        {
          sum[a] += fine.values[3 * block + a]; // 0 where the block has no value
        }
        return fine.known[block] != 0;
      }));
  }
  for (std::size_t n = levels.size() - 1; n-- > 0;)
  {
    Level& fine = levels[n];
    inParallel(static_cast<std::size_t>(fine.size[2]),
      [&](std::size_t slice)
      {
        const int k = static_cast<int>(slice);
        for (int j = 0; j < fine.size[1]; ++j)
        {
          for (int i = 0; i < fine.size[0]; ++i)
          {
            const std::size_t block = fine.at(i, j, k);
            if (!fine.known[block])
            {
              const Vector3 u = interpolate(levels[n + 1], { i, j, k });
              std::transform(
                u.begin(), u.end(), fine.values.begin() + 3 * block, [](double a) { return static_cast<float>(a); });
            }
          }
        }
      });
  }
  this->finest_ = std::move(levels.front());
}

/// Trilinear interpolation between the centres of blocks: along each axis 3/4 of the block around the voxel and 1/4 of
/// the next one.
Vector3 CarryAir::interpolate(const Level& coarse, const Index3& fine)
{
  int block[3][2];
  for (int a = 0; a < 3; ++a)
  {
    block[a][0] = fine[a] / 2;
    block[a][1] = std::min(std::max(fine[a] / 2 + (fine[a] % 2 == 0 ? -1 : 1), 0), coarse.size[a] - 1);
  }
  Vector3 value{};
  for (int n = 0; n < 8; ++n)
  {
    const double weight = (n & 1 ? 0.25 : 0.75) * (n & 2 ? 0.25 : 0.75) * (n & 4 ? 0.25 : 0.75);
    const std::size_t at = coarse.at(block[0][n & 1], block[1][n >> 1 & 1], block[2][n >> 2]);
    for (int a = 0; a < 3; ++a)
    {
      value[a] += weight * coarse.values[3 * at + a];
    }
  }
  return value;
}

}
