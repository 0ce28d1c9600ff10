#include "Resampling.h"

#include "Error.h"
#include "Measurement.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// Output voxels that are handled at once. Each takes 17 bytes on the device, but cells at the border of a batch are
/// gone over for both its sides.
constexpr std::size_t voxelsPerBatch = std::size_t(1) << 21;

/// Claims can tell fewer cells than this apart (resample.clh).
constexpr std::size_t mostCells = std::size_t(1) << 28;

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

  /// The first voxel of brick number `n` of `bricks`.
  Index3 origin(std::size_t n, const Index3& size) const
  {
    Index3 origin = this->bricks.indexOf(n);
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = (origin[a] + this->firstBrick[a]) * size[a];
    }
    return origin;
  }

  /// The number, in `bricks`, of the brick that begins at a voxel.
  std::size_t at(const Index3& origin, const Index3& size) const
  {
    return this->bricks.at(floorDiv(origin[0], size[0]) - this->firstBrick[0],
      floorDiv(origin[1], size[1]) - this->firstBrick[1], floorDiv(origin[2], size[2]) - this->firstBrick[2]);
  }
};

/// Some bricks of the output, from `first` to `last`, counted as in Frame::bricks.
struct BrickBox
{
  Index3 first{ 0, 0, 0 };
  Index3 last{ -1, -1, -1 };

  bool isEmpty() const
  {
    return this->first[0] > this->last[0] || this->first[1] > this->last[1] || this->first[2] > this->last[2];
  }
  bool meets(const BrickBox& other) const
  {
    bool meet = true;
    for (int a = 0; a < 3; ++a)
    {
      meet = meet && this->first[a] <= other.last[a] && other.first[a] <= this->last[a];
    }
    return meet;
  }
  void include(const Index3& brick)
  {
    const bool empty = this->isEmpty();
    for (int a = 0; a < 3; ++a)
    {
      this->first[a] = empty ? brick[a] : std::min(this->first[a], brick[a]);
      this->last[a] = empty ? brick[a] : std::max(this->last[a], brick[a]);
    }
  }
  void mark(std::vector<char>& marks, const Grid& bricks) const
  {
    for (int k = this->first[2]; k <= this->last[2]; ++k)
    {
      for (int j = this->first[1]; j <= this->last[1]; ++j)
      {
        for (int i = this->first[0]; i <= this->last[0]; ++i)
        {
          marks[bricks.at(i, j, k)] = 1;
        }
      }
    }
  }
};

/// The bricks that meet the box of voxels from `from` to `to` within the limits `least` and `most`. Clamps before the
/// conversion to integers, since a displacement may be far larger than any image.
BrickBox bricksBetween(const Frame& frame, const Index3& size, const Vector3& from, const Vector3& to,
  const Index3& least, const Index3& most)
{
  BrickBox box;
  for (int a = 0; a < 3; ++a)
  {
    if (from[a] > most[a] || to[a] < least[a])
    {
      return {};
    }
    box.first[a] = floorDiv(static_cast<int>(std::max<double>(from[a], least[a])), size[a]) - frame.firstBrick[a];
    box.last[a] = floorDiv(static_cast<int>(std::min<double>(to[a], most[a])), size[a]) - frame.firstBrick[a];
  }
  return box;
}

/// What the tissue of one brick makes necessary.
struct Reach
{
  BrickBox cells;  ///< bricks whose cells it moves
  BrickBox voxels; ///< bricks of the output where it may arrive or which it may leave
};

/// Finds what all tissue makes necessary. A carved element leaves its voxel. A displaced element moves the cells around
/// it and also, since the border follows tissue, the cells next to those: two voxels.
std::vector<Reach> findReaches(Bricks& bricks, const Frame& frame)
{
  const Grid& grid = bricks.model().grid();
  const Index3 size = bricks.size();
  std::vector<Reach> reaches;
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
    Reach reach;
    reach.cells =
      bricksBetween(frame, size, first, last, { 0, 0, 0 }, { grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1 });
    for (int a = 0; a < 3; ++a)
    {
      first[a] += std::floor(brick.low[a]);
      last[a] += std::ceil(brick.high[a]);
    }
    reach.voxels = bricksBetween(frame, size, first, last, frame.low, frame.high);
    reaches.push_back(reach);
  }
  for (const int brick : bricks.links().carvedBricks())
  {
    Reach reach;
    reach.cells.include(frame.bricks.indexOf(frame.at(bricks.origin(brick), size)));
    reach.voxels = reach.cells;
    reaches.push_back(reach);
  }
  return reaches;
}

/// `listed` holds the bricks of the output.
Resampling::Batch makeBatch(const Bricks& bricks, const Frame& frame, const std::vector<Reach>& reaches,
  const std::vector<std::size_t>& listed, std::size_t begin, std::size_t end)
{
  const Index3 size = bricks.size();
  Resampling::Batch batch;
  batch.bricks = frame.bricks;
  batch.firstVoxel = frame.origin(0, size);
  batch.places.assign(frame.bricks.voxels(), -1);
  BrickBox box;
  for (std::size_t n = begin; n < end; ++n)
  {
    batch.places[listed[n]] = static_cast<int>(n - begin);
    batch.firsts.push_back(int4(frame.origin(listed[n], size)));
    box.include(frame.bricks.indexOf(listed[n]));
  }
  std::vector<char> isSource(frame.bricks.voxels(), 0);
  for (const Reach& reach : reaches)
  {
    if (reach.voxels.meets(box))
    {
      reach.cells.mark(isSource, frame.bricks);
    }
  }
  batch.numbers.assign(frame.bricks.voxels(), -1);
  BrickBox cells;
  for (std::size_t n = 0; n < isSource.size(); ++n)
  {
    if (isSource[n])
    {
      batch.numbers[n] = static_cast<int>(batch.sources.size());
      const Index3 origin = frame.origin(n, size);
      batch.sources.push_back(bricks.brickAt(origin[0], origin[1], origin[2]));
      cells.include(frame.bricks.indexOf(n));
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    batch.cells.size[a] = (cells.last[a] - cells.first[a] + 1) * size[a];
    batch.firstCell[a] = (cells.first[a] + frame.firstBrick[a]) * size[a];
    batch.cells.size[a] = std::min(batch.cells.size[a], bricks.model().grid().size[a] - batch.firstCell[a]);
  }
  return batch;
}

}

const cl::Buffer& Resampling::locate(const Batch& batch)
{
  Context& context = this->bricks_.context();
  const Grid& grid = this->bricks_.model().grid();
  const std::string defines = this->bricks_.defines(true);
  const std::size_t items = this->bricks_.workItems(true);
  const std::size_t voxels = batch.firsts.size() * this->bricks_.elementsPerBrick();
  const Index3 flat{ grid.size[0] == 1, grid.size[1] == 1, grid.size[2] == 1 };
  const std::size_t cells = batch.sources.size() * (this->bricks_.elementsPerBrick() / this->bricks_.width(true));
  const cl::Buffer& claims = this->claims_.sized(context, sizeof(cl_uint) * voxels);
  const cl::Buffer& contested = this->contested_.sized(context, voxels);
  const cl::Buffer& again = this->again_.sized(context, cells);
  const cl::Buffer& found = this->offsets_.sized(context, sizeof(cl_float) * 3 * voxels);
  const auto tissue = std::tuple_cat(this->bricks_.table(), std::make_tuple(this->bricks_.pitch()),
    this->bricks_.state(), std::make_tuple(int4(grid.size), int4(flat)));
  const auto boxes =
    std::make_tuple(int4(batch.firstVoxel), int4(batch.bricks.size), int4(batch.firstCell), int4(batch.cells.size));
  const cl::Buffer& list = this->list_.holding(context, batch.sources);
  const cl::Buffer& places = this->places_.holding(context, batch.places);
  const auto cover = [&](bool claiming)
  {
    context.launch(context.kernel("cover.cl", defines, "cover"), batch.sources.size(), items, list, tissue, boxes,
      places, claims, contested, found, again, static_cast<cl_int>(claiming));
  };
  context.queue().enqueueFillBuffer(claims, cl_uint(0xFFFFFFFFu), 0, sizeof(cl_uint) * voxels);
  context.queue().enqueueFillBuffer(contested, cl_uchar(0), 0, voxels);
  context.queue().enqueueFillBuffer(again, cl_uchar(0), 0, cells);
  cover(true);
  context.launch(context.kernel("cover.cl", defines, "leave"), batch.firsts.size(), items, tissue, boxes,
    this->firsts_.holding(context, batch.firsts), this->numbers_.holding(context, batch.numbers), claims, contested,
    found, again);
  cover(false);
  return found;
}

void Resampling::run(const Index3& padding, const std::function<void(double)>& checkpoint,
  const std::function<void(const ResampledBox&)>& visit)
{
  const Grid& grid = this->bricks_.model().grid();
  const Index3 size = this->bricks_.size();
  const Frame frame(grid, padding, size);
  const std::vector<Reach> reaches = findReaches(this->bricks_, frame);
  std::vector<char> isReached(frame.bricks.voxels(), 0);
  for (const Reach& reach : reaches)
  {
    reach.voxels.mark(isReached, frame.bricks);
  }
  std::vector<std::size_t> reached; // bricks of the frame
  std::vector<int> tissue;          // those among them that are bricks of the grid
  for (std::size_t n = 0; n < isReached.size(); ++n)
  {
    const Index3 origin = frame.origin(n, size);
    if (isReached[n])
    {
      reached.push_back(n);
      if (grid.contains(origin[0], origin[1], origin[2]))
      {
        tissue.push_back(this->bricks_.brickAt(origin[0], origin[1], origin[2]));
      }
    }
  }
  // The kernels also have to read the tissue at rest where displaced tissue arrives.
  this->bricks_.know(tissue);

  const std::size_t perBrick = this->bricks_.elementsPerBrick();
  const std::size_t perBatch = std::max<std::size_t>(1, voxelsPerBatch / perBrick);
  std::vector<float> copy;
  for (std::size_t begin = 0, end = 0; begin < reached.size(); begin = end)
  {
    checkpoint(static_cast<double>(begin) / reached.size());
    end = std::min(begin + perBatch, reached.size());
    Batch batch = makeBatch(this->bricks_, frame, reaches, reached, begin, end);
    while (batch.cells.voxels() >= mostCells)
    {
      if (end - begin == 1)
      {
        throw InputError("Tissue comes together from a box of " + std::to_string(batch.cells.size[0]) + " x " +
                         std::to_string(batch.cells.size[1]) + " x " + std::to_string(batch.cells.size[2]) +
                         " voxels; at most 268 million can be resampled. Crop the image to what is to be deformed, or "
                         "resample it to fewer voxels.");
      }
      end = begin + (end - begin) / 2;
      batch = makeBatch(this->bricks_, frame, reaches, reached, begin, end);
    }
    this->bricks_.context().look<float>(this->locate(batch), 3 * perBrick * (end - begin),
      [&](const float* offsets)
      {
        for (std::size_t n = begin; n < end; ++n)
        {
          const float* offset = offsets + 3 * perBrick * (n - begin);
          visit(clipped(frame.origin(reached[n], size), size, frame.low, frame.high, offset, copy));
        }
      });
  }
}

}
