#include "TightGroups.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace chainmail
{

namespace
{

/// The elements that have moved and those around them, as plain arrays over a box of the grid.
struct Box
{
  Index3 first;
  Index3 size;
  std::vector<float> u[3];
  std::vector<float> c[3];        ///< signed constraints, as Model::row() and the probes in hand have them
  std::vector<std::uint8_t> cuts; ///< empty where there are none

  std::size_t voxels() const { return static_cast<std::size_t>(this->size[0]) * this->size[1] * this->size[2]; }
  std::size_t step(int axis) const
  {
    return axis == 0 ? 1 : axis == 1 ? this->size[0] : static_cast<std::size_t>(this->size[0]) * this->size[1];
  }
};

/// Links from an element to the next ones along the axes of the grid: calls f(lower, upper, limit).
template <typename F> void forLinks(const Box& box, const std::vector<float>& c, F&& f)
{
  std::size_t n = 0;
  for (int k = 0; k < box.size[2]; ++k)
  {
    for (int j = 0; j < box.size[1]; ++j)
    {
      for (int i = 0; i < box.size[0]; ++i, ++n)
      {
        if (std::isinf(c[n]))
        {
          continue;
        }
        const bool inside[3] = { i + 1 < box.size[0], j + 1 < box.size[1], k + 1 < box.size[2] };
        for (int a = 0; a < 3; ++a)
        {
          const std::size_t m = n + box.step(a);
          const bool cut = !box.cuts.empty() && (box.cuts[n] & (2 << (2 * a))) != 0;
          if (inside[a] && !cut && !std::isinf(c[m]))
          {
            f(n, m, 0.5f * (std::fabs(c[n]) + std::fabs(c[m])));
          }
        }
      }
    }
  }
}

/// Disjoint sets; the root is the lowest member, so that no order of joining changes it.
class Sets
{
public:
  explicit Sets(std::size_t count)
    : parent_(count)
  {
    std::iota(this->parent_.begin(), this->parent_.end(), 0u);
  }

  std::uint32_t root(std::size_t n)
  {
    std::uint32_t at = static_cast<std::uint32_t>(n);
    while (this->parent_[at] != at)
    {
      this->parent_[at] = this->parent_[this->parent_[at]];
      at = this->parent_[at];
    }
    return at;
  }
  void join(std::size_t n, std::size_t m)
  {
    const std::uint32_t a = this->root(n);
    const std::uint32_t b = this->root(m);
    this->parent_[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<std::uint32_t> parent_;
};

Box readBox(Bricks& bricks)
{
  const Grid& grid = bricks.model().grid();
  const Index3 brickSize = bricks.size();
  Index3 first = grid.size;
  Index3 last{ -1, -1, -1 };
  for (const int slot : bricks.touchedSlots())
  {
    const Index3 origin = bricks.origin(bricks.brick(slot));
    for (int a = 0; a < 3; ++a)
    {
      first[a] = std::min(first[a], std::max(0, origin[a] - 1));
      last[a] = std::max(last[a], std::min(grid.size[a] - 1, origin[a] + brickSize[a]));
    }
  }
  Box box;
  box.first = first;
  box.size = { last[0] - first[0] + 1, last[1] - first[1] + 1, last[2] - first[2] + 1 };
  if (last[0] < 0)
  {
    box.size = { 0, 0, 0 };
    return box;
  }

  const int axes = bricks.model().axes();
  for (int a = 0; a < 3; ++a)
  {
    box.u[a].assign(box.voxels(), 0.0f);
    box.c[a].assign(a < axes ? box.voxels() : 0, -std::numeric_limits<float>::infinity());
  }
  if (bricks.anyCut())
  {
    box.cuts.assign(box.voxels(), 0);
  }
  std::vector<int> slots;
  for (int slot = 1; slot < bricks.slots(); ++slot)
  {
    const Index3 origin = bricks.origin(bricks.brick(slot));
    bool inside = true;
    for (int a = 0; a < 3; ++a)
    {
      inside = inside && origin[a] <= last[a] && origin[a] + brickSize[a] > first[a];
    }
    if (inside)
    {
      slots.push_back(slot);
    }
  }
  bricks.readSlots<float>({ { bricks.displacement, 3 }, { bricks.constraint, static_cast<std::size_t>(axes) } }, slots,
    [&](int slot, const Bricks::SlotValues<float>& values)
    {
      const Index3 origin = bricks.origin(bricks.brick(slot));
      Index3 from;
      Index3 to;
      for (int a = 0; a < 3; ++a)
      {
        from[a] = std::max(origin[a], first[a]);
        to[a] = std::min(origin[a] + brickSize[a] - 1, last[a]);
      }
      for (int k = from[2]; k <= to[2]; ++k)
      {
        for (int j = from[1]; j <= to[1]; ++j)
        {
          for (int i = from[0]; i <= to[0]; ++i)
          {
            const std::size_t n = (i - first[0]) + box.step(1) * (j - first[1]) + box.step(2) * (k - first[2]);
            const std::uint32_t local = bricks.local(i, j, k);
            for (int a = 0; a < 3; ++a)
            {
              box.u[a][n] = values(a, local);
              if (a < axes)
              {
                box.c[a][n] = values(3 + a, local);
              }
            }
            if (!box.cuts.empty())
            {
              box.cuts[n] = bricks.cutBits(i, j, k);
            }
          }
        }
      }
    });
  return box;
}

/// What the links of a unit or group ask of it.
struct Pull
{
  double weight = 0.0;
  double force = 0.0;
  bool held = false;
};

/// Moves the groups of one axis within the box; returns the largest move.
float moveAxis(
  const Box& box, const std::vector<float>& c, std::vector<float>& u, const Elasticity& elasticity, float still)
{
  const std::size_t count = box.voxels();

  // Units: rigid clusters and single elements, with what pulls at each.
  Sets units(count);
  forLinks(box, c,
    [&](std::size_t n, std::size_t m, float limit)
    {
      if (limit == 0.0f)
      {
        units.join(n, m);
      }
    });
  std::vector<Pull> pulls(count);
  for (std::size_t n = 0; n < count; ++n)
  {
    // Tissue that is still at rest stays: beyond the box nothing is known of it.
    if (std::signbit(c[n]) || u[n] == 0.0f)
    {
      pulls[units.root(n)].held = true;
    }
  }
  forLinks(box, c,
    [&](std::size_t n, std::size_t m, float limit)
    {
      const double weight = Elasticity::weight(limit);
      const double force = weight * elasticity.pull(u[n], u[m], limit);
      if (units.root(n) != units.root(m))
      {
        pulls[units.root(n)].weight += weight;
        pulls[units.root(n)].force += force;
        pulls[units.root(m)].weight += weight;
        pulls[units.root(m)].force -= force;
      }
    });

  // Groups: units joined by links that block.
  Sets groups = units;
  bool any = false;
  forLinks(box, c,
    [&](std::size_t n, std::size_t m, float limit)
    {
      if (units.root(n) == units.root(m))
      {
        return;
      }
      const Pull& atN = pulls[units.root(n)];
      const Pull& atM = pulls[units.root(m)];
      const float stretch = u[n] - u[m];
      const float rounding = 1e-6f * std::max(1.0f, std::fabs(u[n]));
      const bool above = stretch >= limit - rounding;  // n is as far above m as it can be
      const bool below = -stretch >= limit - rounding; // and the other way
      const bool blocks =
        (above && (atN.force > 0.0 || atM.force < 0.0)) || (below && (atN.force < 0.0 || atM.force > 0.0));
      if (blocks && !atN.held && !atM.held)
      {
        groups.join(n, m);
        any = true;
      }
    });
  if (!any)
  {
    return 0.0f;
  }

  // Members and outgoing links of each group of several units, in the order of voxels.
  std::vector<int> idOf(count, -1);
  std::vector<std::vector<std::uint32_t>> members;
  for (std::size_t n = 0; n < count; ++n)
  {
    if (std::isinf(c[n]) || units.root(n) == groups.root(n))
    {
      continue;
    }
    int& id = idOf[groups.root(n)];
    if (id < 0)
    {
      id = static_cast<int>(members.size());
      members.emplace_back();
    }
  }
  for (std::size_t n = 0; n < count; ++n)
  {
    const int id = idOf[groups.root(n)];
    if (id >= 0 && !std::isinf(c[n]))
    {
      members[id].push_back(static_cast<std::uint32_t>(n));
    }
  }
  struct Outgoing
  {
    std::uint32_t inner;
    std::uint32_t outer;
    float limit;
  };
  std::vector<std::vector<Outgoing>> outgoing(members.size());
  forLinks(box, c,
    [&](std::size_t n, std::size_t m, float limit)
    {
      const std::uint32_t a = groups.root(n);
      const std::uint32_t b = groups.root(m);
      if (a != b && idOf[a] >= 0)
      {
        outgoing[idOf[a]].push_back({ static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(m), limit });
      }
      if (a != b && idOf[b] >= 0)
      {
        outgoing[idOf[b]].push_back({ static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(n), limit });
      }
    });

  float largest = 0.0f;
  for (std::size_t id = 0; id < members.size(); ++id)
  {
    double weight = 0.0;
    double force = 0.0;
    float lower = -std::numeric_limits<float>::infinity();
    float upper = std::numeric_limits<float>::infinity();
    for (const Outgoing& link : outgoing[id])
    {
      const double w = Elasticity::weight(link.limit);
      weight += w;
      force += w * elasticity.pull(u[link.inner], u[link.outer], link.limit);
      lower = std::max(lower, u[link.outer] - link.limit - u[link.inner]);
      upper = std::min(upper, u[link.outer] + link.limit - u[link.inner]);
    }
    const float wanted = weight > 0.0 ? static_cast<float>(force / weight) : 0.0f;
    const float way = std::min(std::max(wanted, lower), upper);
    // Against the wish of the group it never goes: where rounding has closed its box it stays.
    if (!(lower <= upper) || !(std::fabs(way) > still) || way * wanted <= 0.0f)
    {
      continue;
    }
    for (const std::uint32_t n : members[id])
    {
      u[n] += way;
    }
    largest = std::max(largest, std::fabs(way));
  }
  return largest;
}

}

float moveTightGroups(Bricks& bricks, const Elasticity& elasticity, float still, std::vector<int>& moved)
{
  Box box = readBox(bricks);
  const std::vector<float> before[3] = { box.u[0], box.u[1], box.u[2] };
  float largest = 0.0f;
  for (int a = 0; a < 3 && box.voxels() > 0; ++a)
  {
    largest =
      std::max(largest, moveAxis(box, box.c[std::min(a, bricks.model().axes() - 1)], box.u[a], elasticity, still));
  }
  if (largest == 0.0f)
  {
    return largest;
  }

  std::vector<std::size_t> changed;
  for (std::size_t n = 0; n < box.voxels(); ++n)
  {
    if (box.u[0][n] != before[0][n] || box.u[1][n] != before[1][n] || box.u[2][n] != before[2][n])
    {
      changed.push_back(n);
    }
  }
  const Grid boxGrid{ box.size, {} };
  for (const std::size_t n : changed)
  {
    const Index3 at = boxGrid.indexOf(n);
    moved.push_back(bricks.brickAt(at[0] + box.first[0], at[1] + box.first[1], at[2] + box.first[2]));
  }
  std::vector<int> distinct = moved;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  bricks.require(distinct);
  moved = distinct;

  std::vector<std::uint32_t> addresses;
  std::vector<float> values;
  for (const std::size_t n : changed)
  {
    const Index3 at = boxGrid.indexOf(n);
    addresses.push_back(bricks.address(at[0] + box.first[0], at[1] + box.first[1], at[2] + box.first[2]));
    values.insert(values.end(), { box.u[0][n], box.u[1][n], box.u[2][n] });
  }
  bricks.setDisplacements(addresses, values);
  return largest;
}

}
