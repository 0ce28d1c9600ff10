#include "TissuePart.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace chainmail
{

namespace
{

template <typename T> void put(std::vector<char>& bytes, const T* values, std::size_t count)
{
  const auto* const from = reinterpret_cast<const char*>(values);
  bytes.insert(bytes.end(), from, from + sizeof(T) * count);
}

template <typename T> void put(std::vector<char>& bytes, const std::vector<T>& values)
{
  const std::uint64_t count = values.size();
  put(bytes, &count, 1);
  put(bytes, values.data(), values.size());
}

template <typename T> const char* take(const char* from, T* values, std::size_t count)
{
  if (count > 0) // an empty vector may have no memory
  {
    std::memcpy(values, from, sizeof(T) * count);
  }
  return from + sizeof(T) * count;
}

template <typename T> const char* take(const char* from, std::vector<T>& values)
{
  std::uint64_t count = 0;
  from = take(from, &count, 1);
  values.resize(count);
  return take(from, values.data(), values.size());
}

/// What a message begins with. All that follows is aligned to it.
enum class Kind : std::uint64_t
{
  Part,
  Displacements
};

}

BrickBox bricksOf(const OutputFrame& frame, const OutputDetail& detail)
{
  Vector3 low;
  Vector3 high;
  for (int a = 0; a < 3; ++a)
  {
    low[a] = std::max(frame.low[a], detail.first[a]);
    high[a] = std::min(frame.high[a], detail.last[a]);
  }
  return frame.between(low, high, frame.low, frame.high);
}

const std::vector<std::uint8_t>& RestElements::of(int brick)
{
  const auto known = this->known_.find(brick);
  if (known != this->known_.end())
  {
    return known->second;
  }
  const Model& model = this->bricks_.model();
  const std::size_t axes = static_cast<std::size_t>(model.axes());
  std::vector<float> constraints(static_cast<std::size_t>(this->bricks_.size()[0]) * axes);
  std::vector<std::uint8_t> bits(static_cast<std::size_t>(this->bricks_.elementsPerBrick()) / 8, 0);
  for (const Bricks::Row& row : this->bricks_.rows(brick))
  {
    const Index3 first = model.grid().indexOf(row.voxel);
    model.row(first[0], first[1], first[2], row.count, constraints.data());
    for (int i = 0; i < row.count; ++i)
    {
      if (!std::isinf(constraints[static_cast<std::size_t>(i) * axes]))
      {
        bits[row.local(i) / 8] |= static_cast<std::uint8_t>(1 << row.local(i) % 8);
      }
    }
  }
  return this->known_.emplace(brick, std::move(bits)).first->second;
}

std::vector<int> reachedBricks(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail)
{
  const BrickBox shown = bricksOf(frame, detail);
  BrickSet reached(bricks, bricks.model().grid().size);
  for (const BrickExtents& reach : reaches)
  {
    if (reach.voxels.meets(shown))
    {
      BrickBox arrives = reach.voxels;
      for (int a = 0; a < 3; ++a)
      {
        arrives.first[a] = std::max(arrives.first[a], shown.first[a]);
        arrives.last[a] = std::min(arrives.last[a], shown.last[a]);
      }
      arrives.each(frame.bricks,
        [&](std::size_t n)
        {
          const Index3 origin = frame.origin(n);
          if (bricks.model().grid().contains(origin[0], origin[1], origin[2]))
          {
            reached.add(bricks.brickAt(origin[0], origin[1], origin[2]));
          }
        });
    }
  }
  return reached.all();
}

Sources sourcesOf(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail)
{
  const Index3& grid = bricks.model().grid().size;
  const Index3 size = bricks.size();
  const BrickBox shown = bricksOf(frame, detail);
  BrickBox moved;
  for (const BrickExtents& reach : reaches)
  {
    if (reach.voxels.meets(shown) && !reach.cells.isEmpty())
    {
      moved.include(reach.cells.first);
      moved.include(reach.cells.last);
    }
  }
  // The voxels from `first` to `last` that are in the grid, or its nearest ones.
  const auto clipped = [&](const Index3& first, const Index3& last)
  {
    VoxelBox box;
    for (int a = 0; a < 3; ++a)
    {
      box.first[a] = std::clamp(first[a], 0, grid[a] - 1);
      box.size[a] = std::clamp(last[a], 0, grid[a] - 1) - box.first[a] + 1;
    }
    return box;
  };
  Index3 first;
  Index3 last;
  for (int a = 0; a < 3; ++a)
  {
    // Output voxels between those of the grid are interpolated.
    first[a] = std::max(frame.low[a], detail.first[a]);
    last[a] = std::min(frame.high[a], detail.last[a]) + (detail.finer > 1 ? 1 : 0);
  }
  Sources sources;
  sources.resting = clipped(first, last);
  if (!moved.isEmpty())
  {
    for (int a = 0; a < 3; ++a)
    {
      first[a] = (moved.first[a] + frame.firstBrick[a]) * size[a] - 1;
      last[a] = (moved.last[a] + 1 + frame.firstBrick[a]) * size[a];
    }
    sources.moved = clipped(first, last);
  }
  return sources;
}

BrickSet bricksAround(
  const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches, const OutputDetail& detail)
{
  const BrickBox shown = bricksOf(frame, detail);
  BrickSet sources(bricks, bricks.model().grid().size);
  for (const BrickExtents& reach : reaches)
  {
    if (reach.voxels.meets(shown))
    {
      reach.cells.each(frame.bricks,
        [&](std::size_t n)
        {
          const Index3 origin = frame.origin(n);
          sources.add(bricks.brickAt(origin[0], origin[1], origin[2]));
        });
    }
  }
  return sources.widened(aroundCells);
}

TissuePart partOf(Bricks& bricks, RestElements& rest, const OutputFrame& frame,
  const std::vector<BrickExtents>& reaches, const std::vector<int>& displaced, const OutputDetail& detail)
{
  const Grid& grid = bricks.model().grid();
  TissuePart part;
  part.frame.grid = grid;
  part.frame.brickSize = bricks.size();
  part.frame.detail = detail;
  part.frame.sources = sourcesOf(bricks, frame, reaches, detail);

  const BrickSet near = bricksAround(bricks, frame, reaches, detail);
  BrickSet loaded = near;
  for (const int brick : reachedBricks(bricks, frame, reaches, detail))
  {
    loaded.add(brick);
  }
  for (const int brick : displaced)
  {
    if (near.has(brick))
    {
      part.displaced.push_back(brick);
    }
  }
  std::sort(part.displaced.begin(), part.displaced.end());
  part.bricks = loaded.widened(bricks.size()).all(); // loading a brick loads all 26 around it
  for (const int brick : part.bricks)
  {
    const std::vector<std::uint8_t>& elements = rest.of(brick);
    part.elements.insert(part.elements.end(), elements.begin(), elements.end());
  }
  part.changed = part.displaced;
  for (const int brick : part.bricks)
  {
    if (bricks.links().all().count(brick) > 0)
    {
      part.topology.bits[brick] = bricks.links().shown(brick);
    }
    const auto distances = bricks.cutDistances().all().find(brick);
    if (distances != bricks.cutDistances().all().end())
    {
      part.topology.distances[brick] = distances->second.values();
    }
  }
  return part;
}

std::vector<char> TissuePart::toMessage() const
{
  std::vector<char> bytes;
  const Kind kind = Kind::Part;
  put(bytes, &kind, 1);
  put(bytes, &this->frame, 1);
  put(bytes, this->bricks);
  put(bytes, this->elements);
  put(bytes, this->displaced);
  put(bytes, this->changed);
  const std::uint64_t counts[] = { this->topology.bits.size(), this->topology.distances.size() };
  put(bytes, counts, 2);
  for (const auto& [brick, bits] : this->topology.bits)
  {
    put(bytes, &brick, 1);
    put(bytes, bits);
  }
  for (const auto& [brick, values] : this->topology.distances)
  {
    put(bytes, &brick, 1);
    put(bytes, values);
  }
  return bytes;
}

TissuePart TissuePart::fromMessage(const std::vector<char>& message)
{
  static_assert(std::is_trivially_copyable<Frame>::value, "it is copied as bytes");
  TissuePart part;
  const char* from = take(message.data() + sizeof(Kind), &part.frame, 1);
  from = take(from, part.bricks);
  from = take(from, part.elements);
  from = take(from, part.displaced);
  from = take(from, part.changed);
  std::uint64_t counts[2];
  from = take(from, counts, 2);
  for (std::uint64_t n = 0; n < counts[0]; ++n)
  {
    int brick = 0;
    from = take(from, &brick, 1);
    from = take(from, part.topology.bits[brick]);
  }
  for (std::uint64_t n = 0; n < counts[1]; ++n)
  {
    int brick = 0;
    from = take(from, &brick, 1);
    from = take(from, part.topology.distances[brick]);
  }
  return part;
}

std::vector<char> messageOf(const Bricks& bricks, const std::vector<int>& displaced)
{
  const auto count = static_cast<std::size_t>(bricks.elementsPerBrick());
  std::vector<char> message(sizeof(Kind) + sizeof(float) * 3 * count * displaced.size());
  const Kind kind = Kind::Displacements;
  std::memcpy(message.data(), &kind, sizeof(kind));
  auto* const values = reinterpret_cast<float*>(message.data() + sizeof(kind));
  std::vector<int> slots = bricks.slotsOf(displaced);
  std::unordered_map<int, std::size_t> places;
  for (std::size_t n = 0; n < slots.size(); ++n)
  {
    places[slots[n]] = n;
  }
  std::sort(slots.begin(), slots.end());
  bricks.readSlots<float>({ { bricks.displacement(), 3 } }, slots,
    [&](int slot, const Bricks::SlotValues<float>& u)
    {
      for (std::size_t a = 0; a < 3; ++a)
      {
        std::copy_n(u.of(a), count, values + (a * slots.size() + places.at(slot)) * count);
      }
    });
  return message;
}

const float* displacementsOf(const std::vector<char>& message)
{
  Kind kind = Kind::Part;
  std::memcpy(&kind, message.data(), sizeof(kind));
  return kind == Kind::Part ? nullptr : reinterpret_cast<const float*>(message.data() + sizeof(kind));
}

void inMessages(
  const Bricks& bricks, const std::vector<int>& list, const std::function<void(const std::vector<int>&)>& f)
{
  constexpr std::size_t bytesOfMessage = std::size_t(8) << 20;
  const std::size_t most = std::max<std::size_t>(1, bytesOfMessage / (sizeof(float) * 3 * bricks.elementsPerBrick()));
  for (std::size_t begin = 0; begin < list.size(); begin += most)
  {
    const auto first = list.begin() + static_cast<std::ptrdiff_t>(begin);
    f({ first, first + static_cast<std::ptrdiff_t>(std::min(most, list.size() - begin)) });
  }
}

}
