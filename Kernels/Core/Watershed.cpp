#include "Watershed.h"

#include "Components.h"
#include "DistanceMap.h"
#include "Neighbours.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace chainmail
{

namespace
{

using Basin = std::uint32_t;
constexpr Basin none = 0;
constexpr Basin pending = std::numeric_limits<Basin>::max(); // of the level that is flooded, and without a basin yet

/// Squared distances [half voxels].
using Level = std::uint16_t;
constexpr Level surface = 4; // of solid voxels at the surface; points between voxels have less unless all are solid
constexpr Level timesThePass = 4; // a basin stays apart if its maximum is at least this many times the pass

/// The points where the distance is known: the nodes [0, voxels()) are the centres of the voxels of a set, by their
/// numbers. The node voxels() + n is the point half a voxel further than the centre of number n along each axis that
/// has more than one voxel.
class Lattice
{
public:
  Lattice(const Grid& grid, const VoxelSet& where)
    : grid_(grid)
    , where_(where)
  {
    this->voxels_.reserve(where.count());
    where.forEach([this](std::size_t voxel) { this->voxels_.push_back(voxel); });
    for (int a = 0; a < 3; ++a)
    {
      for (const int way : { -1, 1 })
      {
        Index3 step{ 0, 0, 0 };
        step[a] = way;
        this->add(0, step, false);
        this->add(1, step, true);
      }
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      const Index3 step{ corner & 1, corner >> 1 & 1, corner >> 2 & 1 };
      this->add(0, { -step[0], -step[1], -step[2] }, true);
      this->add(1, step, false);
    }
  }

  std::size_t voxels() const { return this->voxels_.size(); }
  std::size_t nodes() const { return 2 * this->voxels(); }

  template <typename Visit> void forNeighbours(std::size_t node, const Visit& visit) const
  {
    const bool halfway = node >= this->voxels();
    const std::size_t voxel = this->voxels_[halfway ? node - this->voxels() : node];
    const Index3 at = this->grid_.indexOf(voxel);
    const bool isInside = this->isInside(at);
    for (const Step& step : this->steps_[halfway ? 1 : 0])
    {
      if (isInside || this->grid_.contains(at[0] + step.by[0], at[1] + step.by[1], at[2] + step.by[2]))
      {
        const std::size_t number = this->where_.numberOf(voxel + step.offset);
        if (number != VoxelSet::none)
        {
          visit(number + (step.toHalfway ? this->voxels() : 0));
        }
      }
    }
  }

private:
  struct Step
  {
    Index3 by;
    std::size_t offset; ///< of voxels; wraps around where it is negative
    bool toHalfway;
  };

  void add(int from, const Index3& by, bool toHalfway)
  {
    std::size_t offset = 0;
    const std::array<std::size_t, 3> strides = stridesOf(this->grid_);
    for (int a = 0; a < 3; ++a)
    {
      if (by[a] != 0 && this->grid_.size[a] == 1)
      {
        return;
      }
      offset += by[a] * strides[a];
    }
    this->steps_[from].push_back({ by, offset, toHalfway });
  }

  bool isInside(const Index3& at) const
  {
    bool is = true;
    for (int a = 0; a < 3; ++a)
    {
      is = is && at[a] > 0 && at[a] + 1 < this->grid_.size[a];
    }
    return is;
  }

  const Grid& grid_;
  const VoxelSet& where_;
  std::vector<std::size_t> voxels_;
  std::array<std::vector<Step>, 2> steps_; ///< from the centre of a voxel, from the point half a voxel further
};

/// Nodes in the order of their levels, the highest first.
struct Order
{
  std::vector<std::uint32_t> nodes;
  std::vector<std::pair<Level, std::size_t>> ends; ///< of each level that occurs, the place after its last node
};

/// Sorts the nodes of solid tissue by counting.
Order sortByLevel(const std::vector<Level>& levels)
{
  std::vector<std::size_t> places(std::size_t(farthest) + 2, 0);
  for (const Level level : levels)
  {
    places[level >= surface ? farthest - level + 1 : 0] += level >= surface ? 1 : 0;
  }
  Order order;
  for (std::size_t n = 1; n < places.size(); ++n)
  {
    places[n] += places[n - 1];
    if (places[n] > places[n - 1])
    {
      order.ends.emplace_back(static_cast<Level>(farthest + 1 - n), places[n]);
    }
  }
  order.nodes.resize(places.back());
  for (std::size_t n = 0; n < levels.size(); ++n)
  {
    if (levels[n] >= surface)
    {
      order.nodes[places[farthest - levels[n]]++] = static_cast<std::uint32_t>(n);
    }
  }
  return order;
}

/// Where two basins meet.
struct Pass
{
  Level level;          ///< the highest one of their contacts
  std::size_t contacts; ///< how many links between nodes have it
};

/// The flood. Basins are numbered by their maxima, the highest first.
class Flood
{
public:
  Flood(const Lattice& lattice, const std::vector<Level>& levels, std::vector<Basin>& basins, Basin next)
    : lattice_(lattice)
    , levels_(levels)
    , basins_(basins)
    , maxima_(next, farthest)
    , sizes_(next, 0)
  {
  }

  /// Floods the nodes of a level; all nodes above it have a basin. A node belongs to the basin of its highest
  /// neighbour. From there basins grow one step at a time. Where two of them arrive at once, the lower number takes the
  /// node.
  void flood(Level level, const std::uint32_t* first, const std::uint32_t* last)
  {
    std::for_each(first, last, [&](std::uint32_t node) { this->basins_[node] = pending; });
    this->growInto(first, last);
    for (const std::uint32_t* node = first; node < last; ++node)
    {
      if (this->basins_[*node] == pending)
      {
        this->start(*node, level);
      }
    }
    std::for_each(first, last, [&](std::uint32_t node) { this->findPasses(node, level); });
  }

  const std::vector<Level>& maxima() const { return this->maxima_; }

  /// All passes, the highest first; of equal ones that with the most contacts first, then that of larger basins.
  std::vector<std::pair<Pass, std::pair<Basin, Basin>>> passes() const
  {
    std::vector<std::pair<Pass, std::pair<Basin, Basin>>> sorted;
    for (const auto& [key, pass] : this->passes_)
    {
      sorted.push_back({ pass, { static_cast<Basin>(key >> 32), static_cast<Basin>(key) } });
    }
    const auto order = [&](const auto& one)
    {
      const auto sizes = std::minmax(this->sizes_[one.second.first], this->sizes_[one.second.second]);
      return std::make_tuple(one.first.level, one.first.contacts, sizes.second, sizes.first);
    };
    std::sort(sorted.begin(), sorted.end(),
      [&](const auto& a, const auto& b) { return order(a) != order(b) ? order(a) > order(b) : a.second < b.second; });
    return sorted;
  }

private:
  void growInto(const std::uint32_t* first, const std::uint32_t* last)
  {
    std::vector<std::pair<Basin, std::size_t>> entries;
    for (const std::uint32_t* node = first; node < last; ++node)
    {
      Basin best = pending;
      Level highest = 0;
      this->lattice_.forNeighbours(*node,
        [&](std::size_t beside)
        {
          const Basin basin = this->basins_[beside];
          const Level level = this->levels_[beside];
          if (basin != none && basin != pending && (level > highest || (level == highest && basin < best)))
          {
            best = basin;
            highest = level;
          }
        });
      if (best != pending)
      {
        entries.emplace_back(best, *node);
      }
    }
    // Each step visits nodes in the order of their basins and preserves it, so the first basin to arrive is the lowest.
    std::sort(entries.begin(), entries.end());
    this->front_.clear();
    for (const auto& [basin, node] : entries)
    {
      this->basins_[node] = basin;
      this->front_.push_back(node);
    }
    for (std::vector<std::size_t> next; !this->front_.empty(); this->front_.swap(next))
    {
      next.clear();
      for (const std::size_t node : this->front_)
      {
        this->spread(node, [&](std::size_t beside) { next.push_back(beside); });
      }
    }
  }

  /// Starts a basin at a maximum, which may have many nodes.
  void start(std::size_t first, Level level)
  {
    this->basins_[first] = static_cast<Basin>(this->maxima_.size());
    this->maxima_.push_back(level);
    this->sizes_.push_back(0);
    visitComponent(first, this->front_, [&](std::size_t node, const auto& add) { this->spread(node, add); });
  }

  /// Gives the basin of a node to its pending neighbours: add(neighbour).
  template <typename Add> void spread(std::size_t node, const Add& add)
  {
    this->lattice_.forNeighbours(node,
      [&](std::size_t beside)
      {
        if (this->basins_[beside] == pending)
        {
          this->basins_[beside] = this->basins_[node];
          add(beside);
        }
      });
  }

  void findPasses(std::size_t node, Level level)
  {
    const Basin own = this->basins_[node];
    ++this->sizes_[own];
    this->lattice_.forNeighbours(node,
      [&](std::size_t beside)
      {
        const Basin other = this->basins_[beside];
        if (other != none && other != own)
        {
          const std::uint64_t key = std::uint64_t(std::min(own, other)) << 32 | std::max(own, other);
          Pass& pass = this->passes_.emplace(key, Pass{ level, 0 }).first->second;
          pass.contacts += pass.level == level ? 1 : 0;
        }
      });
  }

  const Lattice& lattice_;
  const std::vector<Level>& levels_;
  std::vector<Basin>& basins_;
  std::vector<Level> maxima_;
  std::vector<std::size_t> sizes_;                 ///< [nodes]
  std::unordered_map<std::uint64_t, Pass> passes_; ///< by the numbers of both basins, the lower one in the upper half
  std::vector<std::size_t> front_;
};

}

VoxelMap<std::uint32_t> watershed(const Grid& grid, VoxelMap<std::uint32_t> bodies, int size, std::uint32_t next)
{
  const Lattice lattice(grid, bodies.where());
  std::vector<Level> levels;
  levels.reserve(lattice.nodes());
  {
    VoxelMap<char> solid(bodies.where());
    std::transform(bodies.values().begin(), bodies.values().end(), solid.values().begin(),
      [](std::uint32_t body) { return static_cast<char>(body == 0 ? 1 : 0); });
    for (const bool halfway : { false, true })
    {
      const std::vector<Level> distances = mapDistances(grid, solid, halfway);
      levels.insert(levels.end(), distances.begin(), distances.end());
    }
  }
  const Order order = sortByLevel(levels);

  // Where tissue is n voxels thick the distance is (n + 1) / 2 voxels.
  const std::uint64_t thick = (std::uint64_t(size) + 1) * (std::uint64_t(size) + 1);
  std::vector<Basin> basins(lattice.nodes(), none);
  Flood flood(lattice, levels, basins, next);
  bool isBelow = false;
  const std::uint32_t* first = order.nodes.data();
  for (const auto& [level, end] : order.ends)
  {
    if (!isBelow && level < thick)
    {
      isBelow = true;
      std::transform(bodies.values().begin(), bodies.values().end(), basins.begin(), basins.begin(),
        [](std::uint32_t body, Basin basin) { return body != 0 ? body : basin; });
    }
    const std::uint32_t* const last = order.nodes.data() + end;
    flood.flood(level, first, last);
    first = last;
  }

  std::vector<Level> maxima = flood.maxima();
  DisjointSets joined(maxima.size());
  for (const auto& [pass, pair] : flood.passes())
  {
    // The root is the lowest number: a fixed body, or the basin with the highest maximum.
    const Basin high = std::min(joined.root(pair.first), joined.root(pair.second));
    const Basin low = std::max(joined.root(pair.first), joined.root(pair.second));
    const bool isApart = low < next    ? true
                         : high < next ? maxima[low] >= thick
                                       : pass.level < thick && maxima[low] >= timesThePass * pass.level;
    if (!isApart)
    {
      joined.join(high, low);
    }
  }
  for (std::size_t n = 0; n < lattice.voxels(); ++n)
  {
    const Basin basin = bodies.values()[n] != 0 ? bodies.values()[n] : joined.root(basins[n]);
    bodies.values()[n] = maxima[basin] < timesThePass * surface ? none : basin;
  }
  return bodies;
}

}
