#include "Resampling.h"

#include "Error.h"
#include "Measurement.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// Output voxels that are handled at once: each takes 16 bytes on the device, and 12 beside it.
constexpr std::size_t voxelsPerBatch = std::size_t(1) << 20;

/// Rounds down, also below zero.
int floorDiv(int n, int divisor)
{
  return n >= 0 ? n / divisor : -((divisor - 1 - n) / divisor);
}

/// The part of an output brick that lies within the output, from `low` to `high`.
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

/// The output, voxels `low` to `high`, and its division into bricks of the grid's brick size.
struct Frame
{
  Index3 low;
  Index3 high;
  Index3 firstBrick; ///< the lowest brick of the output, counted in bricks of the grid; may be negative
  Grid bricks;       ///< the bricks of the output, each as one voxel of this grid

  Frame(const Grid& grid, const Index3& padding, const Index3& size)
  {
    for (int a = 0; a < 3; ++a)
    {
      this->low[a] = -padding[a];
      this->high[a] = grid.size[a] - 1 + padding[a];
      this->firstBrick[a] = floorDiv(this->low[a], size[a]);
      this->bricks.size[a] = floorDiv(this->high[a], size[a]) - this->firstBrick[a] + 1;
    }
  }

  /// The number, in `bricks`, of the brick that begins at a voxel.
  std::size_t at(const Index3& origin, const Index3& size) const
  {
    return this->bricks.at(floorDiv(origin[0], size[0]) - this->firstBrick[0],
      floorDiv(origin[1], size[1]) - this->firstBrick[1], floorDiv(origin[2], size[2]) - this->firstBrick[2]);
  }
};

/// Calls f(number) for the bricks that meet the box from `from` to `to` within the limits `least` and `most`. Clamps
/// before the conversion to integers, since a displacement may be far larger than any image.
template <typename F>
void forBricks(const Frame& frame, const Index3& size, const Vector3& from, const Vector3& to, const Index3& least,
  const Index3& most, const F& f)
{
  Index3 begin;
  Index3 end;
  for (int a = 0; a < 3; ++a)
  {
    if (from[a] > most[a] || to[a] < least[a])
    {
      return;
    }
    begin[a] = floorDiv(static_cast<int>(std::max<double>(from[a], least[a])), size[a]) - frame.firstBrick[a];
    end[a] = floorDiv(static_cast<int>(std::min<double>(to[a], most[a])), size[a]) - frame.firstBrick[a];
  }
  for (int k = begin[2]; k <= end[2]; ++k)
  {
    for (int j = begin[1]; j <= end[1]; ++j)
    {
      for (int i = begin[0]; i <= end[0]; ++i)
      {
        f(frame.bricks.at(i, j, k));
      }
    }
  }
}

/// Layers of output voxels, both included.
struct Layers
{
  int first = std::numeric_limits<int>::max();
  int last = std::numeric_limits<int>::min();

  bool empty() const { return this->first > this->last; }
  bool meet(const Layers& other) const { return this->first <= other.last && this->last >= other.first; }
  void add(double from, double to, const Frame& frame)
  {
    const double least = frame.low[2];
    const double most = frame.high[2];
    this->first = std::min(this->first, static_cast<int>(std::min(std::max(from, least), most)));
    this->last = std::max(this->last, static_cast<int>(std::min(std::max(to, least), most)));
  }
};

/// The bricks that have to be visited.
struct Work
{
  std::vector<int> sources;    ///< bricks whose tissue is displaced or carved away, or beside such tissue
  std::vector<Layers> layers;  ///< for each of them: where its tissue may arrive, and where it may have been
  std::vector<Index3> origins; ///< first voxels of the output bricks where such tissue may arrive or which it may leave
  std::vector<int> tissue;     ///< those among these output bricks that are bricks of the grid
};

/// Finds the work. A carved element leaves its voxel. A displaced element moves the cells around it and also, since the
/// border follows tissue, the cells next to those: two voxels. The bricks of all these cells are the sources.
Work findWork(Bricks& bricks, const Frame& frame)
{
  const Grid& grid = bricks.model().grid();
  const Index3 size = bricks.size();
  std::vector<Layers> layers(frame.bricks.voxels()); // empty where the brick is no source
  std::vector<char> isReached(frame.bricks.voxels(), 0);
  const std::vector<BrickFigures> figures = measureBricks(bricks);
  for (std::size_t n = 0; n < figures.size(); ++n)
  {
    const BrickFigures& brick = figures[n];
    if (brick.displaced == 0.0f)
    {
      continue;
    }
    const Index3 origin = bricks.origin(bricks.brick(static_cast<int>(n) + 1));
    Vector3 first;
    Vector3 last;
    for (int a = 0; a < 3; ++a)
    {
      first[a] = origin[a] - 2 + (a == 0 ? 0.0 : brick.firstRow[a - 1]);
      last[a] = origin[a] + 2 + (a == 0 ? size[0] - 1.0 : brick.lastRow[a - 1]);
    }
    const double from = first[2] + std::floor(brick.low[2]);
    const double to = last[2] + std::ceil(brick.high[2]);
    forBricks(frame, size, first, last, { 0, 0, 0 }, { grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1 },
      [&](std::size_t source) { layers[source].add(from, to, frame); });
    for (int a = 0; a < 3; ++a)
    {
      first[a] += std::floor(brick.low[a]);
      last[a] += std::ceil(brick.high[a]);
    }
    forBricks(frame, size, first, last, frame.low, frame.high, [&](std::size_t reached) { isReached[reached] = 1; });
  }
  for (const int brick : bricks.links().carvedBricks())
  {
    const Index3 origin = bricks.origin(brick);
    const std::size_t at = frame.at(origin, size);
    layers[at].add(origin[2] - 2, origin[2] + size[2] + 1, frame);
    isReached[at] = 1;
  }

  Work work;
  for (std::size_t n = 0; n < frame.bricks.voxels(); ++n)
  {
    const Index3 at = frame.bricks.indexOf(n);
    Index3 origin;
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = (at[a] + frame.firstBrick[a]) * size[a];
    }
    const bool inside = grid.contains(origin[0], origin[1], origin[2]);
    const int brick = inside ? bricks.brickAt(origin[0], origin[1], origin[2]) : 0;
    if (!layers[n].empty())
    {
      work.sources.push_back(brick);
      work.layers.push_back(layers[n]);
    }
    if (isReached[n])
    {
      work.origins.push_back(origin);
      if (inside)
      {
        work.tissue.push_back(brick);
      }
    }
  }
  return work;
}

/// The box of all cells whose lowest corner lies in one of these bricks.
struct CellBox
{
  Index3 first{ 0, 0, 0 };
  Index3 size{ 1, 1, 1 };

  /// Throws InputError where it holds more cells than claims can count (resample.clh).
  CellBox(const Bricks& bricks, const std::vector<int>& sources)
  {
    constexpr double most = 1 << 28;
    Index3 last{ 0, 0, 0 };
    for (const int brick : sources)
    {
      const Index3 origin = bricks.origin(brick);
      for (int a = 0; a < 3; ++a)
      {
        this->first[a] = brick == sources.front() ? origin[a] : std::min(this->first[a], origin[a]);
        last[a] = std::max(last[a], origin[a] + bricks.size()[a] - 1);
      }
    }
    double cells = 1.0;
    for (int a = 0; a < 3 && !sources.empty(); ++a)
    {
      this->size[a] = last[a] - this->first[a] + 1;
      cells *= this->size[a];
    }
    if (cells >= most)
    {
      throw InputError("The displaced tissue spans " + std::to_string(this->size[0]) + " x " +
                       std::to_string(this->size[1]) + " x " + std::to_string(this->size[2]) +
                       " voxels; at most 268 million can be resampled. Crop the image to what is to be deformed, or "
                       "resample it to fewer voxels.");
    }
  }
};

}

void Resampling::run(const Index3& padding, const std::function<void(double)>& checkpoint,
  const std::function<void(const ResampledBox&)>& visit)
{
  const Grid& grid = this->bricks_.model().grid();
  const Index3 size = this->bricks_.size();
  const Frame frame(grid, padding, size);
  const Work work = findWork(this->bricks_, frame);
  const std::vector<Index3>& origins = work.origins;
  if (origins.empty())
  {
    return;
  }
  // The kernels also have to read the tissue at rest where displaced tissue arrives.
  this->bricks_.know(work.tissue);

  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(true);
  const std::size_t items = this->bricks_.workItems(true);
  const std::size_t perBrick = this->bricks_.elementsPerBrick();
  const std::size_t perBatch = std::max<std::size_t>(1, voxelsPerBatch / perBrick);
  const Index3 flat{ grid.size[0] == 1, grid.size[1] == 1, grid.size[2] == 1 };
  const CellBox cells(this->bricks_, work.sources);
  // These are large, and what follows an update needs the room.
  const std::size_t most = std::min(perBatch, origins.size()) * perBrick;
  const cl::Buffer claims = context.allocate(sizeof(cl_uint) * most, "resampling", 1);
  const cl::Buffer offsetBuffer = context.allocate(sizeof(cl_float) * 3 * most, "resampling", 1);
  std::vector<float> offsets;
  std::vector<float> copy;
  for (std::size_t begin = 0; begin < origins.size(); begin += perBatch)
  {
    checkpoint(static_cast<double>(begin) / origins.size());
    const std::size_t count = std::min(perBatch, origins.size() - begin);
    std::vector<int> places(frame.bricks.voxels(), -1);
    std::vector<cl_int4> firsts;
    for (std::size_t n = 0; n < count; ++n)
    {
      places[frame.at(origins[begin + n], size)] = static_cast<int>(n);
      firsts.push_back(int4(origins[begin + n]));
    }

    // The output bricks come layer by layer, so most sources have to do with few of the batches.
    Layers batch;
    batch.add(origins[begin][2], origins[begin + count - 1][2] + size[2] - 1, frame);
    std::vector<int> sources;
    for (std::size_t n = 0; n < work.sources.size(); ++n)
    {
      if (work.layers[n].meet(batch))
      {
        sources.push_back(work.sources[n]);
      }
    }

    const std::size_t voxels = count * perBrick;
    context.queue().enqueueFillBuffer(claims, cl_uint(0xFFFFFFFFu), 0, sizeof(cl_uint) * voxels);
    const auto common = std::tuple_cat(this->bricks_.table(), std::make_tuple(this->bricks_.pitch()),
      this->bricks_.state(), std::make_tuple(int4(grid.size), int4(flat), int4(cells.first), int4(cells.size)));
    context.launch(context.kernel("claim.cl", defines, "claim"), sources.size(), items,
      this->list_.holding(context, sources), common,
      int4({ frame.firstBrick[0] * size[0], frame.firstBrick[1] * size[1], frame.firstBrick[2] * size[2] }),
      int4(frame.bricks.size), this->places_.holding(context, places), claims);
    context.launch(context.kernel("locate.cl", defines, "locate"), count, items, common,
      this->firsts_.holding(context, firsts), claims, offsetBuffer);

    offsets.resize(3 * voxels);
    context.read(offsetBuffer, offsets);
    for (std::size_t n = 0; n < count; ++n)
    {
      visit(clipped(origins[begin + n], size, frame.low, frame.high, offsets.data() + 3 * perBrick * n, copy));
    }
  }
}

}
