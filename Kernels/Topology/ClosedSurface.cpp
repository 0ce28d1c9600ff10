#include "ClosedSurface.h"

#include "Error.h"
#include "Format.h"
#include "Rays.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace chainmail
{

namespace
{

/// One side of a triangle.
struct Side
{
  int low; ///< the two points, the lower number first
  int high;
  bool backwards; ///< whether the triangle runs from high to low
  int triangle;

  int way() const { return this->backwards ? -1 : 1; }
  bool sameEdge(const Side& other) const { return this->low == other.low && this->high == other.high; }
  bool operator<(const Side& other) const
  {
    return std::make_pair(this->low, this->high) < std::make_pair(other.low, other.high);
  }
};

/// An axis-aligned box, and its volume as `content`.
struct Box
{
  Fixed3 low;
  Fixed3 high;

  void add(const Fixed3& place)
  {
    for (int a = 0; a < 3; ++a)
    {
      this->low[a] = std::min(this->low[a], place[a]);
      this->high[a] = std::max(this->high[a], place[a]);
    }
  }
  long double content() const
  {
    long double product = 1.0L;
    for (int a = 0; a < 3; ++a)
    {
      product *= static_cast<long double>(this->high[a] - this->low[a]);
    }
    return product;
  }
};

/// For every point the first point at the same position.
std::vector<int> merged(const std::vector<Fixed3>& points)
{
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(
    order.begin(), order.end(), [&](int a, int b) { return points[a] != points[b] ? points[a] < points[b] : a < b; });
  std::vector<int> first(points.size());
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    const bool same = n > 0 && points[order[n]] == points[order[n - 1]];
    first[order[n]] = same ? first[order[n - 1]] : order[n];
  }
  return first;
}

/// The triangles with three different corners, as the first points at each position. The others enclose nothing.
std::vector<std::array<int, 3>> distinct(const Surface& surface, const std::vector<Fixed3>& points)
{
  const std::vector<int> first = merged(points);
  std::vector<std::array<int, 3>> triangles;
  triangles.reserve(surface.triangles.size());
  for (const std::array<int, 3>& ids : surface.triangles)
  {
    const std::array<int, 3> t{ { first[ids[0]], first[ids[1]], first[ids[2]] } };
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
    {
      triangles.push_back(t);
    }
  }
  return triangles;
}

/// The sides of all triangles, those at one edge next to each other.
std::vector<Side> sidesOf(const std::vector<std::array<int, 3>>& triangles)
{
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    for (int e = 0; e < 3; ++e)
    {
      const int a = triangles[t][e];
      const int b = triangles[t][(e + 1) % 3];
      sides.push_back({ std::min(a, b), std::max(a, b), a > b, static_cast<int>(t) });
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Calls f(begin, end) for the sides at each edge.
template <typename F> void forEdges(const std::vector<Side>& sides, F&& f)
{
  for (std::size_t n = 0; n < sides.size();)
  {
    std::size_t end = n;
    while (end < sides.size() && sides[end].sameEdge(sides[n]))
    {
      ++end;
    }
    f(sides.data() + n, sides.data() + end);
    n = end;
  }
}

void checkClosed(const std::vector<Side>& sides, const Surface& surface)
{
  std::size_t open = 0;
  const Side* example = nullptr;
  forEdges(sides,
    [&](const Side* begin, const Side* end)
    {
      if ((end - begin) % 2 != 0)
      {
        example = open == 0 ? begin : example;
        ++open;
      }
    });
  if (open == 0)
  {
    return;
  }
  Vector3 middle;
  for (int a = 0; a < 3; ++a)
  {
    middle[a] = 0.5 * (surface.points[example->low][a] + surface.points[example->high][a]);
  }
  throw InputError("The surface to carve with is not closed, so it has no inside: " + std::to_string(open) +
                   " of its " + "edges have no second triangle, one of them near " + toString(middle) +
                   " mm along the image's axes. Fill its holes, merge points that should be one (Clean to Grid), " +
                   "or use the surface as Cuts instead.");
}

/// Numbers the connected components. Returns their number.
int numberParts(const std::vector<Side>& sides, std::size_t triangles, std::vector<int>& part)
{
  std::vector<int> root(triangles);
  std::iota(root.begin(), root.end(), 0);
  const auto rootOf = [&](int t)
  {
    while (root[t] != t)
    {
      root[t] = root[root[t]];
      t = root[t];
    }
    return t;
  };
  forEdges(sides,
    [&](const Side* begin, const Side* end)
    {
      for (const Side* side = begin + 1; side < end; ++side)
      {
        const auto pair = std::minmax({ rootOf(begin->triangle), rootOf(side->triangle) });
        root[pair.second] = pair.first;
      }
    });
  int count = 0;
  part.assign(triangles, -1);
  for (std::size_t t = 0; t < triangles; ++t)
  {
    const int r = rootOf(static_cast<int>(t));
    part[t] = r == static_cast<int>(t) ? count++ : part[r]; // the root has the lowest number
  }
  return count;
}

/// For each part whether some edge is traversed more often in one direction than in the other. Such a part has no
/// winding number. `turned` marks triangles that count as reversed.
std::vector<char> disagreeing(
  const std::vector<Side>& sides, const std::vector<int>& part, int parts, const std::vector<char>& turned)
{
  std::vector<char> result(parts, 0);
  forEdges(sides,
    [&](const Side* begin, const Side* end)
    {
      int sum = 0;
      for (const Side* side = begin; side < end; ++side)
      {
        sum += turned[side->triangle] ? -side->way() : side->way();
      }
      if (sum != 0)
      {
        result[part[begin->triangle]] = 1;
      }
    });
  return result;
}

/// Chooses which triangles of some parts to reverse (flood fill). Afterwards the two triangles at each edge are
/// oriented consistently, where that is possible.
std::vector<char> turnsToAgree(
  const std::vector<Side>& sides, const std::vector<int>& part, const std::vector<char>& ofParts)
{
  const std::size_t triangles = part.size();
  std::vector<std::array<int, 3>> neighbour(triangles, { { -1, -1, -1 } });
  std::vector<std::array<char, 3>> differs(triangles);
  std::vector<char> filled(triangles, 0);
  forEdges(sides,
    [&](const Side* begin, const Side* end)
    {
      if (end - begin == 2 && ofParts[part[begin->triangle]])
      {
        const int pair[2] = { begin[0].triangle, begin[1].triangle };
        for (int n = 0; n < 2; ++n)
        {
          const int slot = filled[pair[n]]++;
          neighbour[pair[n]][slot] = pair[1 - n];
          differs[pair[n]][slot] = begin[0].backwards == begin[1].backwards;
        }
      }
    });
  std::vector<char> turned(triangles, 0);
  std::vector<char> reached(triangles, 0);
  std::vector<int> queue;
  for (std::size_t seed = 0; seed < triangles; ++seed)
  {
    if (reached[seed] || !ofParts[part[seed]])
    {
      continue;
    }
    reached[seed] = 1;
    queue.assign(1, static_cast<int>(seed));
    while (!queue.empty())
    {
      const int t = queue.back();
      queue.pop_back();
      for (int e = 0; e < filled[t]; ++e)
      {
        const int next = neighbour[t][e];
        if (!reached[next])
        {
          reached[next] = 1;
          turned[next] = static_cast<char>(turned[t] != differs[t][e]);
          queue.push_back(next);
        }
      }
    }
  }
  return turned;
}

/// Six times the signed volume of each part: positive where normals point outwards.
std::vector<long double> volumesOf(const ClosedSurface& surface, std::size_t parts)
{
  std::vector<long double> volumes(parts, 0.0L);
  std::vector<int> origin(parts, -1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
  {
    const int p = surface.part[t];
    origin[p] = origin[p] < 0 ? surface.triangles[t][0] : origin[p];
    std::array<std::array<long double, 3>, 3> v;
    for (int corner = 0; corner < 3; ++corner)
    {
      for (int a = 0; a < 3; ++a)
      {
        v[corner][a] =
          static_cast<long double>(surface.points[surface.triangles[t][corner]][a] - surface.points[origin[p]][a]);
      }
    }
    volumes[p] += v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                  v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) + v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
  }
  return volumes;
}

/// The parts by size, the largest first: a part comes after those that enclose it.
std::vector<int> bySize(const ClosedSurface& surface, const std::vector<long double>& volumes)
{
  constexpr std::int64_t none = std::int64_t(1) << 62;
  std::vector<Box> boxes(volumes.size(), Box{ { { none, none, none } }, { { -none, -none, -none } } });
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
  {
    for (const int id : surface.triangles[t])
    {
      boxes[surface.part[t]].add(surface.points[id]);
    }
  }
  std::vector<long double> content;
  std::transform(boxes.begin(), boxes.end(), std::back_inserter(content), [](const Box& box) { return box.content(); });
  const auto size = [&](int p) { return std::make_pair(content[p], volumes[p] < 0.0L ? -volumes[p] : volumes[p]); };
  std::vector<int> order(volumes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });
  return order;
}

/// Finds the hollows, and orients their normals inwards and those of all other parts outwards. `trusted` says that the
/// orientation of all parts is as intended.
void orient(ClosedSurface& surface, bool trusted)
{
  const std::size_t parts = surface.alternating.size();
  const std::vector<long double> volumes = volumesOf(surface, parts);
  std::vector<int> facing(parts, 1);
  for (std::size_t p = 0; p < parts; ++p)
  {
    facing[p] = surface.alternating[p] == 0 && volumes[p] < 0.0L ? -1 : 1;
  }
  std::vector<int> factor = facing; // -1 for the parts to reverse
  if (parts > 1 &&
      (!trusted || std::count(facing.begin(), facing.end(), facing[0]) < static_cast<std::ptrdiff_t>(parts)))
  {
    const std::vector<int> order = bySize(surface, volumes);
    std::vector<std::vector<int>> corners(parts);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    {
      corners[surface.part[t]].insert(
        corners[surface.part[t]].end(), surface.triangles[t].begin(), surface.triangles[t].end());
    }
    const Rays rays(surface);
    std::vector<int> weights(parts, 0); // 0 for later parts: each is tested against the parts before it
    const auto holds = [&](int winding, int part) { return trusted ? winding * facing[part] < 0 : winding != 0; };
    for (const int part : order)
    {
      std::vector<int>& own = corners[part];
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      const bool isHollow = std::all_of(own.begin(), own.end(),
        [&](int id)
        {
          // A corner on the surface of a larger part counts as inside it.
          const Fixed3& at = surface.points[id];
          bool held = holds(rays.winding(at, weights), part);
          for (int n = 0; n < 8 && !held; ++n)
          {
            const Fixed3 near{ at[0] + (n & 1 ? 1 : -1), at[1] + (n & 2 ? 1 : -1), at[2] + (n & 4 ? 1 : -1) };
            held = holds(rays.winding(near, weights), part);
          }
          return held;
        });
      factor[part] = isHollow ? -facing[part] : facing[part];
      weights[part] = trusted ? 1 : factor[part];
      surface.found.hollows += isHollow;
      surface.found.reversed += trusted && !isHollow && facing[part] != facing[order[0]];
    }
  }
  for (std::size_t p = 0; p < parts; ++p)
  {
    surface.alternating[p] *= factor[p];
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
  {
    if (factor[surface.part[t]] < 0)
    {
      std::swap(surface.triangles[t][1], surface.triangles[t][2]);
    }
  }
}

}

ClosedSurface::ClosedSurface(const Surface& surface, const Grid& grid)
  : points(fixedPoints(surface, grid, "carve"))
  , triangles(distinct(surface, this->points))
{
  const std::vector<Side> sides = sidesOf(this->triangles);
  checkClosed(sides, surface);
  const int parts = numberParts(sides, this->triangles.size(), this->part);
  this->alternating.assign(parts, 0);
  std::vector<char> turned(this->triangles.size(), 0);
  const std::vector<char> mixed = disagreeing(sides, this->part, parts, turned);
  this->found.count = static_cast<std::size_t>(parts);
  this->found.mixed = static_cast<std::size_t>(std::count(mixed.begin(), mixed.end(), 1));
  if (this->found.mixed > 0)
  {
    turned = turnsToAgree(sides, this->part, mixed);
    const std::vector<char> still = disagreeing(sides, this->part, parts, turned);
    std::copy(still.begin(), still.end(), this->alternating.begin());
    for (std::size_t t = 0; t < this->triangles.size(); ++t)
    {
      if (turned[t])
      {
        std::swap(this->triangles[t][1], this->triangles[t][2]);
      }
    }
  }
  orient(*this, this->found.mixed == 0);
}

}
