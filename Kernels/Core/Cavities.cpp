#include "Cavities.h"

#include "Components.h"
#include "Neighbours.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace chainmail
{

namespace
{

/// The voxels outside a set, as runs along x, and which runs touch.
class OpenRuns
{
public:
  OpenRuns(const Grid& grid, const VoxelSet& closed)
    : grid_(grid)
  {
    const std::size_t rows = static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2]);
    this->begins_.reserve(rows + 1);
    for (std::size_t row = 0; row < rows; ++row)
    {
      this->begins_.push_back(this->runs_.size());
      const std::size_t first = row * static_cast<std::size_t>(grid.size[0]);
      for (int x = 0; x < grid.size[0]; ++x)
      {
        if (closed.contains(first + x))
        {
          continue;
        }
        if (x == 0 || closed.contains(first + x - 1))
        {
          this->runs_.push_back({ x, x });
        }
        this->runs_.back().last = x;
      }
    }
    this->begins_.push_back(this->runs_.size());
  }

  std::size_t count() const { return this->runs_.size(); }

  /// The run of a voxel, which has to have one.
  std::size_t runOf(std::size_t voxel) const
  {
    const int x = this->grid_.indexOf(voxel)[0];
    const std::size_t row = voxel / static_cast<std::size_t>(this->grid_.size[0]);
    const auto first = this->runs_.begin() + static_cast<std::ptrdiff_t>(this->begins_[row]);
    const auto last = this->runs_.begin() + static_cast<std::ptrdiff_t>(this->begins_[row + 1]);
    const auto run = std::partition_point(first, last, [x](const Run& r) { return r.last < x; });
    return static_cast<std::size_t>(run - this->runs_.begin());
  }

  /// Connected components of runs.
  DisjointSets components() const
  {
    DisjointSets sets(this->runs_.size());
    for (int k = 0; k < this->grid_.size[2]; ++k)
    {
      for (int j = 0; j < this->grid_.size[1]; ++j)
      {
        const std::size_t row = static_cast<std::size_t>(k) * this->grid_.size[1] + j;
        if (j > 0)
        {
          this->join(row - 1, row, sets);
        }
        if (k > 0)
        {
          this->join(row - this->grid_.size[1], row, sets);
        }
      }
    }
    return sets;
  }

  /// Calls visit(voxel) for each voxel of the runs for which isWanted(run).
  template <typename IsWanted, typename Visit> void forEach(const IsWanted& isWanted, const Visit& visit) const
  {
    for (std::size_t row = 0; row + 1 < this->begins_.size(); ++row)
    {
      for (std::size_t run = this->begins_[row]; run < this->begins_[row + 1]; ++run)
      {
        if (!isWanted(run))
        {
          continue;
        }
        for (int x = this->runs_[run].first; x <= this->runs_[run].last; ++x)
        {
          visit(row * static_cast<std::size_t>(this->grid_.size[0]) + x);
        }
      }
    }
  }

private:
  struct Run
  {
    int first;
    int last;
  };

  /// Joins the runs of two rows that have voxels side by side.
  void join(std::size_t one, std::size_t other, DisjointSets& sets) const
  {
    std::size_t a = this->begins_[one];
    std::size_t b = this->begins_[other];
    while (a < this->begins_[one + 1] && b < this->begins_[other + 1])
    {
      if (this->runs_[a].first <= this->runs_[b].last && this->runs_[b].first <= this->runs_[a].last)
      {
        sets.join(a, b);
      }
      ++(this->runs_[a].last < this->runs_[b].last ? a : b);
    }
  }

  const Grid& grid_;
  std::vector<Run> runs_;
  std::vector<std::size_t> begins_; ///< of each row, its first run
};

/// Calls visit(voxel) for the voxels of a face of the grid that a path within the face connects with its sides, all of
/// them outside `closed`.
template <typename Visit> void forOpenFace(const Grid& grid, int face, const VoxelSet& closed, const Visit& visit)
{
  const int across = face / 2;
  const int u = (across + 1) % 3;
  const int v = (across + 2) % 3;
  const int width = grid.size[u];
  const int height = grid.size[v];
  std::vector<char> seen(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  std::vector<std::size_t> front;
  const auto enter = [&](int i, int j, const auto& add)
  {
    Index3 at;
    at[across] = face % 2 == 0 ? 0 : grid.size[across] - 1;
    at[u] = i;
    at[v] = j;
    const std::size_t voxel = grid.at(at[0], at[1], at[2]);
    const std::size_t place = static_cast<std::size_t>(j) * width + i;
    if (seen[place] == 0 && !closed.contains(voxel))
    {
      seen[place] = 1;
      visit(voxel);
      add(place);
    }
  };
  const auto start = [&](int i, int j)
  {
    enter(i, j,
      [&](std::size_t first)
      {
        visitComponent(first, front,
          [&](std::size_t here, const auto& add)
          {
            const int x = static_cast<int>(here % width);
            const int y = static_cast<int>(here / width);
            for (const auto& [dx, dy] : { std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1) })
            {
              if (x + dx >= 0 && x + dx < width && y + dy >= 0 && y + dy < height)
              {
                enter(x + dx, y + dy, add);
              }
            }
          });
      });
  };
  for (int i = 0; i < width; ++i)
  {
    start(i, 0);
    start(i, height - 1);
  }
  for (int j = 0; j < height; ++j)
  {
    start(0, j);
    start(width - 1, j);
  }
}

}

void fillCavities(const Grid& grid, const VoxelSet& outside, VoxelSet& solid)
{
  VoxelSet closed = solid;
  closed.insert(outside);
  const OpenRuns runs(grid, closed);
  DisjointSets components = runs.components();
  std::vector<char> isOpen(runs.count(), 0); // of each component, at its root
  const auto open = [&](std::size_t voxel) { isOpen[components.root(runs.runOf(voxel))] = 1; };
  for (int face = 0; face < 6; ++face)
  {
    forOpenFace(grid, face, closed, open);
  }
  outside.forEach(
    [&](std::size_t voxel)
    {
      forFaces(grid, voxel,
        [&](std::size_t beside)
        {
          if (!closed.contains(beside))
          {
            open(beside);
          }
        });
    });
  runs.forEach([&](std::size_t run) { return isOpen[components.root(run)] == 0; },
    [&](std::size_t voxel) { solid.insert(voxel); });
}

}
