#pragma once

#include "Bricks.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The current positions of elements. Bricks that a deformation may have displaced (dirty, dirtySlots()) are read
/// from the device once.
class Places
{
public:
  struct Bounds
  {
    Vector3 low{};
    Vector3 high{};
  };

  explicit Places(Bricks& bricks)
    : Places(bricks, bricks.dirtySlots())
  {
  }

  /// The positions in some slots, ascending; elements of all others count as at rest.
  static Places of(Bricks& bricks, const std::vector<int>& slots) { return { bricks, slots }; }

  bool anyMoved() const { return !this->moved_.empty(); }

  Vector3 at(int i, int j, int k) const
  {
    if (!this->moved_.empty())
    {
      const auto moved = this->moved_.find(this->bricks_.brickAt(i, j, k));
      if (moved != this->moved_.end())
      {
        return this->bricks_.place(i, j, k, moved->second);
      }
    }
    return { double(i), double(j), double(k) };
  }

  /// Bounds on the displacement of both ends of a brick's links: in the brick itself and in the next one along each
  /// axis.
  Bounds bounds(int brick) const
  {
    Bounds all;
    if (!this->bounds_.empty())
    {
      for (const int b : { brick, this->bricks_.neighbour(brick, 1), this->bricks_.neighbour(brick, 3),
             this->bricks_.neighbour(brick, 5) })
      {
        const auto own = this->bounds_.find(b);
        for (int a = 0; own != this->bounds_.end() && a < 3; ++a)
        {
          all.low[a] = std::min(all.low[a], own->second.low[a]);
          all.high[a] = std::max(all.high[a], own->second.high[a]);
        }
      }
    }
    return all;
  }

  /// Bounds on the displacement of every element.
  Bounds widest() const
  {
    Bounds all;
    for (const auto& entry : this->bounds_)
    {
      for (int a = 0; a < 3; ++a)
      {
        all.low[a] = std::min(all.low[a], entry.second.low[a]);
        all.high[a] = std::max(all.high[a], entry.second.high[a]);
      }
    }
    return all;
  }

private:
  Places(Bricks& bricks, const std::vector<int>& slots)
    : bricks_(bricks)
  {
    for (const int slot : slots)
    {
      this->moved_[bricks.brick(slot)];
      this->bounds_[bricks.brick(slot)];
    }
    const std::size_t count = bricks.elementsPerBrick();
    bricks.readSlots<float>({ { bricks.displacement(), 3 } }, slots,
      [&](int slot, const Bricks::SlotValues<float>& u)
      {
        std::vector<float>& values = this->moved_.at(bricks.brick(slot));
        Bounds& bounds = this->bounds_.at(bricks.brick(slot));
        values.resize(3 * count);
        for (int a = 0; a < 3; ++a)
        {
          for (std::uint32_t n = 0; n < count; ++n)
          {
            values[a * count + n] = u(a, n);
          }
          const auto range = std::minmax_element(values.begin() + a * count, values.begin() + (a + 1) * count);
          bounds.low[a] = std::min(0.0f, *range.first);
          bounds.high[a] = std::max(0.0f, *range.second);
        }
      });
  }

  Bricks& bricks_;
  std::unordered_map<int, std::vector<float>> moved_;
  std::unordered_map<int, Bounds> bounds_;
};

}
