#pragma once

#include "Block.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

namespace oracle
{

/// Dijkstra's algorithm on one axis from any number of sources, each with the value its path starts with:
/// min over sources k of value(k) + d(k, i); infinity where no source reaches.
inline std::vector<double> shortest(
  const Block& block, int axis, const std::vector<std::pair<std::size_t, double>>& sources)
{
  using Entry = std::pair<double, std::size_t>;
  const auto neighbours = graph(block, axis);
  std::vector<double> distance(block.count(), std::numeric_limits<double>::infinity());
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  for (const auto& [voxel, value] : sources)
  {
    if (value < distance[voxel])
    {
      distance[voxel] = value;
      queue.push({ value, voxel });
    }
  }
  while (!queue.empty())
  {
    const auto [reached, voxel] = queue.top();
    queue.pop();
    if (reached > distance[voxel])
    {
      continue;
    }
    for (const Neighbour& n : neighbours[voxel])
    {
      if (reached + n.limit < distance[n.voxel])
      {
        distance[n.voxel] = reached + n.limit;
        queue.push({ distance[n.voxel], n.voxel });
      }
    }
  }
  return distance;
}

/// The elements that a probe holds, and their common displacement [fractions of the spacing]. An anchor keeps them in
/// place.
struct Handle
{
  std::vector<std::size_t> elements;
  Vector3 target{};
  bool anchor = false;
};

struct Propagated
{
  std::vector<Vector3> state;
  std::vector<Vector3> reached; ///< displacement of each handle; of an anchor that of its first element
};

/// Formula (P*): u(i) = u0(i) clamped between the largest t_k - d(k, i) and the smallest t_k + d(k, i) over held
/// elements k. With policy Limit earlier handles and anchored tissue have precedence: a handle's target is first
/// clamped to the bounds that these set at each of its elements.
inline Propagated propagate(const Block& block, const std::vector<Vector3>& before, const std::vector<Handle>& handles)
{
  Propagated result{ before, std::vector<Vector3>(handles.size()) };
  for (int axis = 0; axis < 3; ++axis)
  {
    // Sources for shortest(). Upper envelope: min over k of t_k + d. Lower: max of t_k - d = -(min of -t_k + d).
    std::vector<std::pair<std::size_t, double>> up, down;
    const auto hold = [&](std::size_t voxel, double value)
    {
      up.push_back({ voxel, value });
      down.push_back({ voxel, -value });
    };
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.tissue[v] && block.anchored[v])
      {
        hold(v, before[v][axis]);
      }
    }
    // An anchor does not move its elements, so it is compatible with everything that is held.
    for (const Handle& handle : handles)
    {
      for (const std::size_t v : handle.elements)
      {
        if (handle.anchor)
        {
          hold(v, before[v][axis]);
        }
      }
    }
    for (std::size_t h = 0; h < handles.size(); ++h)
    {
      const Handle& handle = handles[h];
      if (handle.elements.empty())
      {
        continue;
      }
      if (handle.anchor)
      {
        result.reached[h][axis] = before[handle.elements.front()][axis];
        continue;
      }
      const std::vector<double> upper = shortest(block, axis, up);
      const std::vector<double> lower = shortest(block, axis, down);
      double high = std::numeric_limits<double>::infinity();
      double low = -high;
      for (const std::size_t v : handle.elements)
      {
        high = std::min(high, upper[v]);
        low = std::max(low, -lower[v]);
      }
      const double reached = std::min(std::max(handle.target[axis], low), high);
      result.reached[h][axis] = reached;
      for (const std::size_t v : handle.elements)
      {
        hold(v, reached);
      }
    }
    const std::vector<double> upper = shortest(block, axis, up);
    const std::vector<double> lower = shortest(block, axis, down);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.tissue[v])
      {
        result.state[v][axis] = std::min(std::max(before[v][axis], -lower[v]), upper[v]);
      }
    }
  }
  return result;
}

/// The same with policy Share: requests are clamped to the bounds of anchored tissue, then replaced by the mean of the
/// least and the greatest Lipschitz extension of all requests. Elements of one handle may get different displacements.
inline Propagated share(const Block& block, const std::vector<Vector3>& before, const std::vector<Handle>& handles)
{
  using Sources = std::vector<std::pair<std::size_t, double>>;
  Propagated result{ before, std::vector<Vector3>(handles.size()) };
  for (int axis = 0; axis < 3; ++axis)
  {
    Sources held, heldDown;
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.tissue[v] && block.anchored[v])
      {
        held.push_back({ v, before[v][axis] });
      }
    }
    for (const Handle& handle : handles)
    {
      for (const std::size_t v : handle.elements)
      {
        if (handle.anchor)
        {
          held.push_back({ v, before[v][axis] });
        }
      }
    }
    const auto negative = [](Sources sources)
    {
      for (auto& [voxel, value] : sources)
      {
        value = -value;
      }
      return sources;
    };
    const std::vector<double> above = shortest(block, axis, held);
    const std::vector<double> below = shortest(block, axis, negative(held));
    Sources asked;
    for (const Handle& handle : handles)
    {
      for (const std::size_t v : handle.elements)
      {
        if (!handle.anchor)
        {
          asked.push_back({ v, std::min(std::max(before[v][axis] + handle.target[axis], -below[v]), above[v]) });
        }
      }
    }
    const std::vector<double> greatest = shortest(block, axis, asked);
    const std::vector<double> least = shortest(block, axis, negative(asked));
    for (const auto& [voxel, value] : asked)
    {
      held.push_back({ voxel, 0.5 * (greatest[voxel] - least[voxel]) });
    }
    const std::vector<double> upper = shortest(block, axis, held);
    const std::vector<double> lower = shortest(block, axis, negative(held));
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.tissue[v])
      {
        result.state[v][axis] = std::min(std::max(before[v][axis], -lower[v]), upper[v]);
      }
    }
    for (std::size_t h = 0; h < handles.size(); ++h)
    {
      if (!handles[h].elements.empty())
      {
        const std::size_t first = handles[h].elements.front();
        result.reached[h][axis] = result.state[first][axis] - before[first][axis];
      }
    }
  }
  return result;
}

/// The elements that a probe grabs: all within `radius` of `position`, else the nearest one if it is within half a
/// voxel diagonal.
inline std::vector<std::size_t> grab(const Block& block, const Vector3& position, double radius)
{
  std::vector<std::size_t> within;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (!block.tissue[v])
    {
      continue;
    }
    const Index3 p = block.index(v);
    double square = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const double d = p[a] * block.spacing[a] - position[a];
      square += d * d;
    }
    if (square < least)
    {
      least = square;
      nearest = v;
    }
    if (radius > 0.0 && square <= radius * radius)
    {
      within.push_back(v);
    }
  }
  const Vector3& h = block.spacing;
  const double halfDiagonalSquare = 0.25 * (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  if (within.empty() && least <= halfDiagonalSquare * (1.0 + 1e-12))
  {
    within.push_back(nearest);
  }
  return within;
}

}
