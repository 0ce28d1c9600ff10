#include "ElementRuns.h"

#include "Components.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// Tells which links exist between elements.
class Joined
{
public:
  explicit Joined(const Tissue& tissue)
    : tissue_(tissue)
    , isCut_(tissue.numbers(), 0)
  {
    for (const auto& [brick, bits] : tissue.links().all())
    {
      this->isCut_[brick] = 1;
    }
  }

  bool operator()(int i, int j, int k, int direction) const
  {
    return !this->tissue_.anyCut() || !this->isCut_[this->tissue_.brickAt(i, j, k)] ||
           (this->tissue_.cutBits(i, j, k) & CUT_BIT(direction)) == 0;
  }

private:
  const Tissue& tissue_;
  std::vector<char> isCut_; ///< bricks with links that were removed; looking one up takes longer
};

/// Joins runs of a row, [run, end), with the runs linked to them in the neighbouring row in `direction`, [other, last).
void joinRows(const Grid& grid, const Joined& areJoined, const std::vector<ElementRun>& runs, std::size_t run,
  std::size_t end, std::size_t other, std::size_t last, int direction, DisjointSets& joined)
{
  const std::size_t width = static_cast<std::size_t>(grid.size[0]);
  while (run < end && other < last)
  {
    const int first = static_cast<int>(std::max(runs[run].first % width, runs[other].first % width));
    const int endOfRun = static_cast<int>(runs[run].first % width + runs[run].count);
    const int endOfOther = static_cast<int>(runs[other].first % width + runs[other].count);
    const Index3 at = grid.indexOf(runs[run].first);
    for (int i = first; i < std::min(endOfRun, endOfOther); ++i)
    {
      if (areJoined(i, at[1], at[2], direction))
      {
        joined.join(run, other);
        break;
      }
    }
    (endOfRun < endOfOther ? run : other) += 1;
  }
}

}

std::vector<ElementRun> connectedRuns(const Tissue& tissue, int axis, bool rigidOnly)
{
  const Grid& grid = tissue.model().grid();
  const int axes = tissue.model().axes();
  const Joined areJoined(tissue);
  const std::size_t rowsInLayer = static_cast<std::size_t>(grid.size[1]);
  std::vector<ElementRun> runs;
  std::vector<std::size_t> firstOf; // the first run of each row
  std::vector<float> row(static_cast<std::size_t>(grid.size[0]) * axes);
  for (int k = 0; k < grid.size[2]; ++k)
  {
    for (int j = 0; j < grid.size[1]; ++j)
    {
      firstOf.push_back(runs.size());
      tissue.row(0, j, k, grid.size[0], row.data());
      bool goesOn = false;
      for (int i = 0; i < grid.size[0]; ++i)
      {
        const float c = row[static_cast<std::size_t>(i) * axes + axis];
        const bool counts = rigidOnly ? c == 0.0f : !std::isinf(c);
        if (counts && goesOn && areJoined(i, j, k, 0))
        {
          ++runs.back().count;
          runs.back().anchored = runs.back().anchored || std::signbit(c);
        }
        else if (counts)
        {
          runs.push_back({ grid.at(i, j, k), 1, 0, std::signbit(c) });
        }
        goesOn = counts;
      }
    }
  }
  firstOf.push_back(runs.size());

  DisjointSets joined(runs.size());
  for (std::size_t r = 0; r + 1 < firstOf.size(); ++r)
  {
    if (r % rowsInLayer > 0)
    {
      joinRows(grid, areJoined, runs, firstOf[r], firstOf[r + 1], firstOf[r - 1], firstOf[r], 2, joined);
    }
    if (r >= rowsInLayer)
    {
      const std::size_t below = r - rowsInLayer;
      joinRows(grid, areJoined, runs, firstOf[r], firstOf[r + 1], firstOf[below], firstOf[below + 1], 4, joined);
    }
  }
  int count = 0;
  for (std::size_t n = 0; n < runs.size(); ++n)
  {
    const std::size_t root = joined.root(n); // the first run of the component
    runs[n].component = root == n ? count++ : runs[root].component;
  }
  return runs;
}

}
