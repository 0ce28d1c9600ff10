#include "HoldingElement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

namespace chainmail
{

namespace
{

/// One axis of the tissue, read brick by brick as the search reaches it.
class NearTissue
{
public:
  struct Brick
  {
    std::vector<float> constraint; ///< signed, in the order of `local`
    std::vector<float> displacement;
    std::vector<float> rotations;  ///< rotations, 3 values an element; empty without rotations
    std::vector<double> key;       ///< the lowest found so far, see search()
    std::vector<std::size_t> from; ///< the element before it on the path of that key; itself where the path begins
  };

  NearTissue(Bricks& bricks, int axis)
    : bricks_(bricks)
    , axis_(axis)
  {
  }

  Brick& at(int brick)
  {
    const auto [entry, isNew] = this->known_.try_emplace(brick);
    Brick& here = entry->second;
    if (!isNew)
    {
      return here;
    }
    const std::size_t count = static_cast<std::size_t>(this->bricks_.elementsPerBrick());
    const int axes = this->bricks_.model().axes();
    here.constraint.assign(count, -std::numeric_limits<float>::infinity());
    here.displacement.assign(count, 0.0f);
    here.rotations.assign(this->bricks_.rotations() ? 3 * count : 0, 0.0f);
    here.key.assign(count, std::numeric_limits<double>::infinity());
    here.from.assign(count, 0);
    std::vector<float> row(static_cast<std::size_t>(this->bricks_.size()[0] * axes));
    for (const Bricks::Row& part : this->bricks_.rows(brick))
    {
      const Index3 first = this->bricks_.model().grid().indexOf(part.voxel);
      this->bricks_.row(first[0], first[1], first[2], part.count, row.data());
      for (int i = 0; i < part.count; ++i)
      {
        here.constraint[part.local(i)] = row[static_cast<std::size_t>(i * axes + (axes == 3 ? this->axis_ : 0))];
      }
    }
    if (this->bricks_.hasState(brick))
    {
      std::vector<float> u;
      this->bricks_.readSlot(this->bricks_.slot(brick), u);
      std::copy_n(u.begin() + this->axis_ * static_cast<std::ptrdiff_t>(count), count, here.displacement.begin());
      if (this->bricks_.rotations())
      {
        this->bricks_.readRotations(this->bricks_.slot(brick), u);
        for (std::size_t n = 0; n < 3 * count; ++n)
        {
          here.rotations[n] = u[n % 3 * count + n / 3];
        }
      }
    }
    return here;
  }

  /// The rest offset that the rotations of two neighbours give their link (Rotations::restOffset).
  double restOffset(const Index3& at, const Index3& next, int direction)
  {
    if (!this->bricks_.rotations())
    {
      return 0.0;
    }
    const float* spinI = this->at(this->bricks_.brickAt(at[0], at[1], at[2])).rotations.data();
    const float* spinJ = this->at(this->bricks_.brickAt(next[0], next[1], next[2])).rotations.data();
    return this->bricks_.rotations()->restOffset(spinI + 3 * this->bricks_.local(at[0], at[1], at[2]),
      spinJ + 3 * this->bricks_.local(next[0], next[1], next[2]), direction, this->axis_);
  }

private:
  Bricks& bricks_;
  int axis_;
  std::unordered_map<int, Brick> known_;
};

/// findHoldingElement() limited to paths that leave at most `room`. `others`: the voxels of other handles.
std::optional<HoldingElement> search(Bricks& bricks, const std::unordered_set<std::size_t>& others,
  const Handle& handle, int axis, double sign, double room)
{
  // Dijkstra's algorithm. The key of an element is the least room of any path to it from the handle. The room of a path
  // is the sum over its links of D + sign * (u(j) - u(i) - w), with w the rest offset. Terms are negative only by
  // rounding, and then count as 0.
  struct Entry
  {
    double key;
    bool soft; // some link of the path can stretch
    std::size_t voxel;
    bool operator<(const Entry& other) const
    {
      return std::tie(other.key, other.soft, other.voxel) < std::tie(this->key, this->soft, this->voxel);
    }
  };
  const Grid& grid = bricks.model().grid();
  NearTissue tissue(bricks, axis);
  std::priority_queue<Entry> queue;
  const auto offer = [&](const Index3& at, std::size_t from, double key, bool soft)
  {
    NearTissue::Brick& brick = tissue.at(bricks.brickAt(at[0], at[1], at[2]));
    const std::uint32_t local = bricks.local(at[0], at[1], at[2]);
    if (key < brick.key[local] && key <= room)
    {
      brick.key[local] = key;
      brick.from[local] = from;
      queue.push({ key, soft, grid.at(at[0], at[1], at[2]) });
    }
  };
  for (const std::size_t voxel : handle.voxels)
  {
    offer(grid.indexOf(voxel), voxel, 0.0, false);
  }
  const auto pathTo = [&](std::size_t voxel)
  {
    std::vector<std::size_t> path{ voxel };
    for (bool begins = false; !begins;)
    {
      const Index3 at = grid.indexOf(path.back());
      const std::size_t from = tissue.at(bricks.brickAt(at[0], at[1], at[2])).from[bricks.local(at[0], at[1], at[2])];
      begins = from == path.back();
      path.push_back(from);
    }
    path.pop_back();
    std::reverse(path.begin(), path.end());
    return path;
  };
  while (!queue.empty())
  {
    const Entry entry = queue.top();
    queue.pop();
    const Index3 at = grid.indexOf(entry.voxel);
    const NearTissue::Brick& brick = tissue.at(bricks.brickAt(at[0], at[1], at[2]));
    const std::uint32_t local = bricks.local(at[0], at[1], at[2]);
    if (entry.key > brick.key[local])
    {
      continue; // a shorter path has been found since
    }
    if (std::signbit(brick.constraint[local]) || others.count(entry.voxel) > 0)
    {
      return HoldingElement{ entry.voxel, !entry.soft, pathTo(entry.voxel) };
    }
    const float own = brick.constraint[local];
    const double place = brick.displacement[local];
    bricks.forNeighbours(at,
      [&](int direction, const Index3& next)
      {
        const NearTissue::Brick& beside = tissue.at(bricks.brickAt(next[0], next[1], next[2]));
        const std::uint32_t there = bricks.local(next[0], next[1], next[2]);
        if (!std::isinf(beside.constraint[there]))
        {
          const double limit = bricks.link(own, beside.constraint[there], direction, axis).limit;
          const double stretch = beside.displacement[there] - place - tissue.restOffset(at, next, direction);
          offer(next, entry.voxel, entry.key + std::max(0.0, limit + sign * stretch), entry.soft || limit > 0.0);
        }
      });
  }
  return std::nullopt;
}

}

std::optional<HoldingElement> findHoldingElement(
  Bricks& bricks, const std::vector<Handles::Pointer>& handles, const Handle& handle, int axis, double sign)
{
  std::unordered_set<std::size_t> others;
  for (const Handles::Pointer& other : handles)
  {
    if (other.get() != &handle && !other->isSoft())
    {
      others.insert(other->voxels.begin(), other->voxels.end());
    }
  }
  const std::vector<float> u = handle.elements.displacements();
  double largest = 1.0;
  for (const float displacement : u)
  {
    largest = std::max(largest, std::fabs(static_cast<double>(displacement)));
  }
  // The search starts with a room that covers rounding, along the path and in Waves, and allows more step by step.
  std::optional<HoldingElement> grip;
  for (double room = 1e-4; !grip && room <= 1.0; room *= 100.0)
  {
    grip = search(bricks, others, handle, axis, sign, room * largest);
  }
  return grip;
}

}
