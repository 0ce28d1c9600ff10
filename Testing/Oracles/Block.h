#pragma once

// Independent oracles: double precision, one thread, no code of the engine. They are simple rather than fast.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace oracle
{

using Index3 = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// A link without a limit from one element to a place: it costs (u - t)^2 / tolerance on each axis [mm].
struct Soft
{
  std::size_t voxel = 0;
  Vector3 target{};       ///< fractions of the spacing
  double tolerance = 1.0; ///< [mm]
};

/// A block of tissue. Displacements are in fractions of the spacing, per axis; axes are independent of each other.
struct Block
{
  Index3 size{};
  Vector3 spacing{ 1.0, 1.0, 1.0 };
  std::vector<char> tissue;      ///< 1: element, 0: air
  std::vector<Vector3> give;     ///< constraint of each voxel on each axis, fraction of the spacing
  std::vector<char> anchored;    ///< 1: held where it is
  std::vector<std::uint8_t> cut; ///< bit a: the link from this voxel to its neighbour in direction +a is removed
  double slack = 0.0;            ///< strain of a link up to this share of its limit costs no energy
  std::vector<Soft> soft;        ///< any number for any element

  Block() = default;
  explicit Block(const Index3& n)
    : size(n)
    , tissue(this->count(), 1)
    , give(this->count(), Vector3{})
    , anchored(this->count(), 0)
    , cut(this->count(), 0)
  {
  }

  std::size_t count() const { return static_cast<std::size_t>(this->size[0]) * this->size[1] * this->size[2]; }
  std::size_t at(int i, int j, int k) const
  {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(this->size[0]) *
                                           (static_cast<std::size_t>(j) + static_cast<std::size_t>(this->size[1]) * k);
  }
  Index3 index(std::size_t voxel) const
  {
    const std::size_t x = this->size[0], y = this->size[1];
    return { static_cast<int>(voxel % x), static_cast<int>(voxel / x % y), static_cast<int>(voxel / x / y) };
  }
};

/// The energy [mm] of a block's soft links in a state [fractions of the spacing].
inline double softEnergy(const Block& block, const std::vector<Vector3>& state)
{
  double sum = 0.0;
  for (const Soft& soft : block.soft)
  {
    for (int a = 0; a < 3; ++a)
    {
      const double distance = block.spacing[a] * (state[soft.voxel][a] - soft.target[a]);
      sum += distance * distance / soft.tolerance;
    }
  }
  return sum;
}

/// One link between two elements.
struct Link
{
  std::size_t from = 0;
  std::size_t to = 0;
  int direction = 0; ///< the axis the link runs along at rest
};

/// Every link that exists, once.
inline std::vector<Link> links(const Block& block)
{
  std::vector<Link> result;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    const Index3 p = block.index(v);
    for (int direction = 0; direction < 3; ++direction)
    {
      Index3 q = p;
      if (++q[direction] >= block.size[direction])
      {
        continue;
      }
      const std::size_t w = block.at(q[0], q[1], q[2]);
      if (block.tissue[v] && block.tissue[w] && !(block.cut[v] >> direction & 1))
      {
        result.push_back({ v, w, direction });
      }
    }
  }
  return result;
}

/// The limit of a link on an axis: the mean of its two ends.
inline double limit(const Block& block, const Link& link, int axis)
{
  return 0.5 * (block.give[link.from][axis] + block.give[link.to][axis]);
}

/// For each voxel, its neighbours and the limits to them on one axis.
struct Neighbour
{
  std::size_t voxel = 0;
  double limit = 0.0;
};

inline std::vector<std::vector<Neighbour>> graph(const Block& block, int axis)
{
  std::vector<std::vector<Neighbour>> result(block.count());
  for (const Link& link : links(block))
  {
    const double d = limit(block, link, axis);
    result[link.from].push_back({ link.to, d });
    result[link.to].push_back({ link.from, d });
  }
  return result;
}

/// Numbers the connected components of a block in the order of their first voxels; air is -1. Only links for which
/// `accept` is true connect.
template <typename Accept> std::vector<int> parts(const Block& block, Accept&& accept, int* number = nullptr)
{
  std::vector<std::vector<std::size_t>> neighbours(block.count());
  for (const Link& link : links(block))
  {
    if (accept(link))
    {
      neighbours[link.from].push_back(link.to);
      neighbours[link.to].push_back(link.from);
    }
  }
  std::vector<int> label(block.count(), -1);
  int next = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (!block.tissue[v] || label[v] >= 0)
    {
      continue;
    }
    std::vector<std::size_t> stack{ v };
    label[v] = next;
    while (!stack.empty())
    {
      const std::size_t here = stack.back();
      stack.pop_back();
      for (const std::size_t there : neighbours[here])
      {
        if (label[there] < 0)
        {
          label[there] = next;
          stack.push_back(there);
        }
      }
    }
    ++next;
  }
  if (number)
  {
    *number = next;
  }
  return label;
}

/// The components by all links.
inline std::vector<int> parts(const Block& block, int* number = nullptr)
{
  return parts(
    block, [](const Link&) { return true; }, number);
}

/// Rigid clusters on one axis: components by links of limit 0, numbered in the order of their first rigid voxels; -1
/// where the element is not rigid.
inline std::vector<int> clusters(const Block& block, int axis)
{
  const std::vector<int> all = parts(block, [&](const Link& link) { return limit(block, link, axis) == 0.0; });
  std::vector<int> renumber(block.count(), -1);
  std::vector<int> result(block.count(), -1);
  int next = 0;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && block.give[v][axis] == 0.0)
    {
      int& name = renumber[all[v]];
      if (name < 0)
      {
        name = next++;
      }
      result[v] = name;
    }
  }
  return result;
}

/// sum over links and axes of spacing * max(0, |u(i) - u(j)| - slack D)^2 / (D + epsilon), u and D as fractions of the
/// spacing.
inline double energy(const Block& block, const std::vector<Vector3>& state, double epsilon = 1e-6)
{
  double sum = 0.0;
  for (const Link& link : links(block))
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      const double d = limit(block, link, axis);
      const double strain = std::abs(state[link.from][axis] - state[link.to][axis]);
      const double paid = std::max(0.0, strain - block.slack * d);
      sum += block.spacing[axis] * paid * paid / (d + epsilon);
    }
  }
  return sum;
}

/// Largest violation of a link's limit on any axis, as a fraction of the spacing; 0 if none.
inline double maxLinkExcess(const Block& block, const std::vector<Vector3>& state)
{
  double worst = 0.0;
  for (const Link& link : links(block))
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      const double difference = state[link.from][axis] - state[link.to][axis];
      const double excess = (difference < 0 ? -difference : difference) - limit(block, link, axis);
      worst = excess > worst ? excess : worst;
    }
  }
  return worst;
}

}
