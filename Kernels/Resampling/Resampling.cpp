#include "Resampling.h"

#include "Measurement.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// Output voxels handled at once: 16 bytes each on the device.
constexpr std::size_t voxelsPerBatch = std::size_t(1) << 22;

/// Rounds down, also below zero.
int floorDiv(int n, int divisor)
{
  return n >= 0 ? n / divisor : -((divisor - 1 - n) / divisor);
}

/// The part of a brick of the output that lies in the output.
ResampledBox clipped(const Index3& origin, const Index3& size, const Index3& low, const Index3& high,
  const float* offsets, std::vector<float>& copy)
{
  ResampledBox box{ origin, size, offsets };
  Index3 last;
  for (int a = 0; a < 3; ++a)
  {
    box.first[a] = std::max(origin[a], low[a]);
    last[a] = std::min(origin[a] + size[a] - 1, high[a]);
    box.size[a] = last[a] - box.first[a] + 1;
  }
  if (box.size == size)
  {
    return box;
  }
  copy.clear();
  for (int k = box.first[2]; k <= last[2]; ++k)
  {
    for (int j = box.first[1]; j <= last[1]; ++j)
    {
      const std::size_t row =
        static_cast<std::size_t>(size[0]) * ((j - origin[1]) + static_cast<std::size_t>(size[1]) * (k - origin[2]));
      const float* from = offsets + 3 * (row + (box.first[0] - origin[0]));
      copy.insert(copy.end(), from, from + 3 * box.size[0]);
    }
  }
  box.offset = copy.data();
  return box;
}

cl_int4 int4(const Index3& v)
{
  return { { v[0], v[1], v[2], 0 } };
}

}

void Resampling::run(const Index3& padding, const std::function<void(double)>& checkpoint,
  const std::function<void(const ResampledBox&)>& visit)
{
  const Grid& grid = this->bricks_.model().grid();
  const Index3 size = this->bricks_.size();

  // The bricks of the output.
  const Index3 low{ -padding[0], -padding[1], -padding[2] };
  const Index3 high{ grid.size[0] - 1 + padding[0], grid.size[1] - 1 + padding[1], grid.size[2] - 1 + padding[2] };
  Index3 firstBrick;
  Index3 brickCounts;
  for (int a = 0; a < 3; ++a)
  {
    firstBrick[a] = floorDiv(low[a], size[a]);
    brickCounts[a] = floorDiv(high[a], size[a]) - firstBrick[a] + 1;
  }
  const Grid output{ brickCounts, {} };

  // A carved element leaves its voxel. A displaced element moves the cells around it and, through the border that
  // follows tissue, those one further: two voxels. Their bricks are the sources; the bricks that they may arrive at or
  // leave are reached.
  std::vector<char> isSource(output.voxels(), 0);
  std::vector<char> isReached(output.voxels(), 0);
  const std::vector<BrickFigures> figures = measureBricks(this->bricks_);
  for (std::size_t n = 0; n < figures.size(); ++n)
  {
    const BrickFigures& brick = figures[n];
    if (brick.displaced == 0.0f)
    {
      continue;
    }
    const Index3 origin = this->bricks_.origin(this->bricks_.brick(static_cast<int>(n) + 1));
    Vector3 first;
    Vector3 last;
    for (int a = 0; a < 3; ++a)
    {
      first[a] = origin[a] - 2 + (a == 0 ? 0.0 : brick.firstRow[a - 1]);
      last[a] = origin[a] + 2 + (a == 0 ? size[0] - 1.0 : brick.lastRow[a - 1]);
    }
    // Marks the bricks of a box within limits. Clamped before the conversion: a displacement may be far larger than any
    // image.
    const auto mark =
      [&](std::vector<char>& marks, const Vector3& from, const Vector3& to, const Index3& least, const Index3& most)
    {
      Index3 begin;
      Index3 end;
      for (int a = 0; a < 3; ++a)
      {
        if (from[a] > most[a] || to[a] < least[a])
        {
          return;
        }
        begin[a] = floorDiv(static_cast<int>(std::max<double>(from[a], least[a])), size[a]) - firstBrick[a];
        end[a] = floorDiv(static_cast<int>(std::min<double>(to[a], most[a])), size[a]) - firstBrick[a];
      }
      for (int k = begin[2]; k <= end[2]; ++k)
      {
        for (int j = begin[1]; j <= end[1]; ++j)
        {
          for (int i = begin[0]; i <= end[0]; ++i)
          {
            marks[output.at(i, j, k)] = 1;
          }
        }
      }
    };
    mark(isSource, first, last, { 0, 0, 0 }, { grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1 });
    for (int a = 0; a < 3; ++a)
    {
      first[a] += std::floor(brick.low[a]);
      last[a] += std::ceil(brick.high[a]);
    }
    mark(isReached, first, last, low, high);
  }

  for (const int brick : this->bricks_.carvedBricks())
  {
    const Index3 origin = this->bricks_.origin(brick);
    const std::size_t at = output.at(
      origin[0] / size[0] - firstBrick[0], origin[1] / size[1] - firstBrick[1], origin[2] / size[2] - firstBrick[2]);
    isSource[at] = 1;
    isReached[at] = 1;
  }

  std::vector<int> sources;
  std::vector<Index3> origins;
  std::vector<int> tissue;
  for (std::size_t n = 0; n < output.voxels(); ++n)
  {
    const Index3 at = output.indexOf(n);
    Index3 origin;
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = (at[a] + firstBrick[a]) * size[a];
    }
    const bool inside = grid.contains(origin[0], origin[1], origin[2]);
    const int brick = inside ? this->bricks_.brickAt(origin[0], origin[1], origin[2]) : 0;
    if (isSource[n])
    {
      sources.push_back(brick);
    }
    if (isReached[n])
    {
      origins.push_back(origin);
      if (inside)
      {
        tissue.push_back(brick);
      }
    }
  }
  // The kernels must know the tissue that is at rest where other tissue arrives.
  this->bricks_.require(tissue);

  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(true);
  const std::size_t items = this->bricks_.workItems(true);
  const std::size_t perBrick = this->bricks_.elementsPerBrick();
  const std::size_t perBatch = std::max<std::size_t>(1, voxelsPerBatch / perBrick);
  const Index3 flat{ grid.size[0] == 1, grid.size[1] == 1, grid.size[2] == 1 };
  std::vector<float> offsets;
  std::vector<float> copy;
  for (std::size_t begin = 0; begin < origins.size(); begin += perBatch)
  {
    checkpoint(static_cast<double>(begin) / origins.size());
    const std::size_t count = std::min(perBatch, origins.size() - begin);
    std::vector<int> places(output.voxels(), -1);
    std::vector<cl_int4> firsts;
    for (std::size_t n = 0; n < count; ++n)
    {
      const Index3& origin = origins[begin + n];
      places[output.at(floorDiv(origin[0], size[0]) - firstBrick[0], floorDiv(origin[1], size[1]) - firstBrick[1],
        floorDiv(origin[2], size[2]) - firstBrick[2])] = static_cast<int>(n);
      firsts.push_back(int4(origin));
    }

    const std::size_t voxels = count * perBrick;
    const cl::Buffer& claims = this->claims_.sized(context, sizeof(cl_uint) * voxels);
    const cl::Buffer& offsetBuffer = this->offsets_.sized(context, sizeof(cl_float) * 3 * voxels);
    context.queue().enqueueFillBuffer(claims, cl_uint(0xFFFFFFFFu), 0, sizeof(cl_uint) * voxels);
    const auto common = std::tuple_cat(this->bricks_.table(), std::make_tuple(this->bricks_.pitch()),
      this->bricks_.state(), std::make_tuple(int4(grid.size), int4(flat)));
    context.launch(context.kernel("claim.cl", defines, "claim"), sources.size(), items,
      this->list_.holding(context, sources), common,
      int4({ firstBrick[0] * size[0], firstBrick[1] * size[1], firstBrick[2] * size[2] }), int4(brickCounts),
      this->places_.holding(context, places), claims);
    context.launch(context.kernel("locate.cl", defines, "locate"), count, items, common,
      this->firsts_.holding(context, firsts), claims, offsetBuffer);

    offsets.resize(3 * voxels);
    context.read(offsetBuffer, offsets);
    for (std::size_t n = 0; n < count; ++n)
    {
      visit(clipped(origins[begin + n], size, low, high, offsets.data() + 3 * perBrick * n, copy));
    }
  }
}

}
