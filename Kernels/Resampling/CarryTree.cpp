#include "CarryTree.h"

#include "Threads.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

/// Margin of boxes [voxels]: covers their rounding to float and the tolerance of positions in cells.
constexpr float slack = 2e-3f;

template <typename F> void forBlocks(const Index3& size, const F& f)
{
  inParallel(static_cast<std::size_t>(size[2]),
    [&](std::size_t slice)
    {
      for (int j = 0; j < size[1]; ++j)
      {
        for (int i = 0; i < size[0]; ++i)
        {
          f(Index3{ i, j, static_cast<int>(slice) });
        }
      }
    });
}

}

constexpr CarryTree::Box CarryTree::empty()
{
  constexpr float far = std::numeric_limits<float>::infinity();
  return { { far, far, far }, { -far, -far, -far } };
}

void CarryTree::include(Box& box, const Box& other)
{
  for (int a = 0; a < 3; ++a)
  {
    box.low[a] = std::min(box.low[a], other.low[a]);
    box.high[a] = std::max(box.high[a], other.high[a]);
  }
}

bool CarryTree::holds(const Box& box, const Vector3& place) const
{
  bool is = true;
  for (int a = 0; a < 3; ++a)
  {
    is = is && (this->model_.isFlat(a) || (place[a] >= box.low[a] && place[a] <= box.high[a]));
  }
  return is;
}

double CarryTree::squareTo(const Box& box, const Vector3& place) const
{
  double square = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    const double away = std::max({ box.low[a] - place[a], place[a] - box.high[a], 0.0 });
    square += away * away * this->model_.grid.spacing[a] * this->model_.grid.spacing[a];
  }
  return square;
}

CarryTree::CarryTree(const RestModel& model)
  : model_(model)
{
  this->findLeaves();
  while (this->levels_.back().boxes.size() > 1)
  {
    this->addLevel();
  }
}

bool CarryTree::isWhole(const Index3& first) const
{
  const RestModel& m = this->model_;
  for (int p = 0; p < 27; ++p)
  {
    const int step[3] = { p % 3, p / 3 % 3, p / 9 };
    const Index3 at{ first[0] + step[0], first[1] + step[1], first[2] + step[2] };
    if (!m.isElement(at))
    {
      return false;
    }
    const unsigned links = m.links ? m.links[m.grid.at(at[0], at[1], at[2])] : 63;
    for (int a = 0; a < 3; ++a)
    {
      if (step[a] < 2 && !(links >> (2 * a + 1) & 1))
      {
        return false;
      }
    }
  }
  return true;
}

/// The corners of a leaf's cells are at most two voxels from its first voxel. Corners in air or behind a cut have the
/// displacements of elements one voxel further. A leaf that may have such corners gets the box of its cells at
/// rest, extended by bounds of displacements. The bounds cover the 3 x 3 x 3 leaves around it. The box of a whole leaf
/// is that of its displaced corners.
void CarryTree::findLeaves()
{
  const Index3& size = this->model_.grid.size;
  Level leaves;
  leaves.grid.size = { (size[0] + 1) / 2, (size[1] + 1) / 2, (size[2] + 1) / 2 };
  std::vector<Box> displacements(leaves.grid.voxels(), empty());
  forBlocks(leaves.grid.size,
    [&](const Index3& block)
    {
      Box& box = displacements[leaves.grid.at(block[0], block[1], block[2])];
      for (int n = 0; n < 8; ++n)
      {
        const Index3 at{ 2 * block[0] + (n & 1), 2 * block[1] + (n >> 1 & 1), 2 * block[2] + (n >> 2) };
        if (this->model_.isElement(at))
        {
          const Vector3 u = this->model_.displacementAt(at);
          const auto x = static_cast<float>(u[0]), y = static_cast<float>(u[1]), z = static_cast<float>(u[2]);
          include(box, { { x, y, z }, { x, y, z } });
        }
      }
    });
  leaves.boxes.assign(displacements.size(), empty());
  leaves.moved.assign(displacements.size(), 0);
  forBlocks(leaves.grid.size,
    [&](const Index3& block)
    {
      Box u = empty();
      for (int p = 0; p < 27; ++p)
      {
        const Index3 at{ block[0] + p % 3 - 1, block[1] + p / 3 % 3 - 1, block[2] + p / 9 - 1 };
        if (leaves.grid.contains(at[0], at[1], at[2]))
        {
          include(u, displacements[leaves.grid.at(at[0], at[1], at[2])]);
        }
      }
      const std::size_t n = leaves.grid.at(block[0], block[1], block[2]);
      for (int a = 0; a < 3 && u.low[0] <= u.high[0]; ++a)
      {
        leaves.moved[n] = leaves.moved[n] || u.low[a] != 0.0f || u.high[a] != 0.0f;
        const auto first = static_cast<float>(2 * block[a]);
        leaves.boxes[n].low[a] = first + u.low[a] - slack;
        leaves.boxes[n].high[a] = first + 2.0f + u.high[a] + slack;
      }
      const Index3 first{ 2 * block[0], 2 * block[1], 2 * block[2] };
      if (!leaves.moved[n] || !this->isWhole(first))
      {
        return;
      }
      Box exact = empty();
      for (int p = 0; p < 27; ++p)
      {
        const Index3 at{ first[0] + p % 3, first[1] + p / 3 % 3, first[2] + p / 9 };
        const Vector3 d = this->model_.displacementAt(at);
        for (int a = 0; a < 3; ++a)
        {
          const auto place = static_cast<float>(at[a] + d[a]);
          exact.low[a] = std::min(exact.low[a], place - slack);
          exact.high[a] = std::max(exact.high[a], place + slack);
        }
      }
      leaves.boxes[n] = exact;
      leaves.moved[n] = whole;
    });
  this->levels_.push_back(std::move(leaves));
}

void CarryTree::addLevel()
{
  const Level& fine = this->levels_.back();
  const Index3& size = fine.grid.size;
  Level level;
  level.grid.size = { (size[0] + 1) / 2, (size[1] + 1) / 2, (size[2] + 1) / 2 };
  level.boxes.assign(level.grid.voxels(), empty());
  level.moved.assign(level.grid.voxels(), 0);
  forBlocks(level.grid.size,
    [&](const Index3& block)
    {
      const std::size_t n = level.grid.at(block[0], block[1], block[2]);
      for (int c = 0; c < 8; ++c)
      {
        const Index3 at{ 2 * block[0] + (c & 1), 2 * block[1] + (c >> 1 & 1), 2 * block[2] + (c >> 2) };
        if (fine.grid.contains(at[0], at[1], at[2]))
        {
          const std::size_t child = fine.grid.at(at[0], at[1], at[2]);
          include(level.boxes[n], fine.boxes[child]);
          level.moved[n] = level.moved[n] || fine.moved[child];
        }
      }
    });
  this->levels_.push_back(std::move(level));
}

bool CarryTree::findNearest(const Vector3& place, Index3& element) const
{
  Nearest nearest{ place, std::numeric_limits<double>::infinity(), {} };
  this->search(static_cast<int>(this->levels_.size()) - 1, { 0, 0, 0 }, nearest);
  element = nearest.element;
  return std::isfinite(nearest.square);
}

void CarryTree::search(int level, const Index3& at, Nearest& nearest) const
{
  if (level < 0)
  {
    if (this->model_.isElement(at))
    {
      const Vector3 u = this->model_.displacementAt(at);
      double square = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        const double away = (at[a] + u[a] - nearest.place[a]) * this->model_.grid.spacing[a];
        square += away * away;
      }
      if (square < nearest.square)
      {
        nearest.square = square;
        nearest.element = at;
      }
    }
    return;
  }
  // Branch and bound: the nearest child first, so most others can be skipped.
  const Index3& size = level == 0 ? this->model_.grid.size : this->levels_[level - 1].grid.size;
  std::array<std::pair<double, int>, 8> children;
  int count = 0;
  for (int n = 0; n < 8; ++n)
  {
    const Index3 child{ 2 * at[0] + (n & 1), 2 * at[1] + (n >> 1 & 1), 2 * at[2] + (n >> 2) };
    if (child[0] < size[0] && child[1] < size[1] && child[2] < size[2])
    {
      double square = 0.0;
      if (level > 0)
      {
        const Level& finer = this->levels_[level - 1];
        square = this->squareTo(finer.boxes[finer.grid.at(child[0], child[1], child[2])], nearest.place);
      }
      int c = count++;
      for (; c > 0 && children[c - 1].first > square; --c)
      {
        children[c] = children[c - 1];
      }
      children[c] = { square, n };
    }
  }
  for (int c = 0; c < count && children[c].first < nearest.square; ++c)
  {
    const int n = children[c].second;
    this->search(level - 1, { 2 * at[0] + (n & 1), 2 * at[1] + (n >> 1 & 1), 2 * at[2] + (n >> 2) }, nearest);
  }
}

}
