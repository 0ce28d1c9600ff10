#include "ReducedBox.h"

#include "ElementRule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace chainmail
{

namespace
{

constexpr float air = -std::numeric_limits<float>::infinity();

/// The signed constraint of an element on one axis: the mean over its voxels.
struct Mean
{
  double sum = 0.0;
  int count = 0;
  bool rigid = false;
  bool anchored = false;

  void add(float c)
  {
    this->sum += std::fabs(c);
    ++this->count;
    this->rigid = this->rigid || c == 0.0f;
    this->anchored = this->anchored || std::signbit(c);
  }

  float signedConstraint() const
  {
    if (this->count == 0)
    {
      return air;
    }
    const float c = this->rigid ? 0.0f : static_cast<float>(this->sum / this->count);
    return rule::asHeld(c, this->anchored);
  }
};

/// Adds a row of voxels, which begins with an element, to the means of its elements.
void addRow(const std::vector<float>& row, std::size_t axes, std::size_t factor, Mean* means)
{
  for (std::size_t from = 0; from < row.size(); from += factor * axes, means += axes)
  {
    const std::size_t to = std::min(from + factor * axes, row.size());
    for (std::size_t a = 0; a < axes; ++a)
    {
      Mean mean = means[a]; // a copy is kept in registers
      for (std::size_t n = from + a; n < to; n += axes)
      {
        if (row[n] != air)
        {
          mean.add(row[n]);
        }
      }
      means[a] = mean;
    }
  }
}

/// Links the elements of a row along it.
void linkAlong(const std::uint8_t* tissue, std::size_t width, std::size_t factor, std::uint8_t* linked)
{
  for (std::size_t n = factor; n < width; n += factor, ++linked)
  {
    *linked |= tissue[n] & tissue[n - 1];
  }
}

/// Sets a bit of the elements that tissue of a row links to the one before it along another axis.
void linkAcross(const std::uint8_t* before, const std::uint8_t* tissue, std::size_t width, std::size_t factor,
  std::uint8_t bit, std::uint8_t* linked)
{
  for (std::size_t from = 0; from < width; from += factor, ++linked)
  {
    for (std::size_t n = from; n < std::min(from + factor, width); ++n)
    {
      *linked |= before[n] & tissue[n] ? bit : 0;
    }
  }
}

/// From the first to before the second.
using Range = std::pair<int, int>;

/// The parts of a row of elements that are in none of the boxes.
std::vector<Range> without(const std::vector<VoxelBox>& boxes, const Range& row, int j, int k)
{
  std::vector<Range> ranges{ row };
  for (const VoxelBox& box : boxes)
  {
    if (!box.contains(box.first[0], j, k))
    {
      continue;
    }
    const Range known{ box.first[0], box.first[0] + box.size[0] };
    std::vector<Range> rest;
    for (const Range& range : ranges)
    {
      for (const Range& side : { Range{ range.first, std::min(range.second, known.first) },
             Range{ std::max(range.first, known.second), range.second } })
      {
        if (side.first < side.second)
        {
          rest.push_back(side);
        }
      }
    }
    ranges = std::move(rest);
  }
  return ranges;
}

}

Grid reducedGrid(const Grid& whole, const Index3& factor)
{
  Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = (whole.size[a] + factor[a] - 1) / factor[a];
    grid.spacing[a] = factor[a] * whole.spacing[a];
  }
  return grid;
}

VoxelBox elementsWithin(const Grid& whole, const Index3& factor, const VoxelBox& voxels)
{
  VoxelBox elements;
  for (int a = 0; a < 3; ++a)
  {
    const int last = voxels.first[a] + voxels.size[a];
    const int end = last == whole.size[a] ? (last + factor[a] - 1) / factor[a] : last / factor[a];
    elements.first[a] = (voxels.first[a] + factor[a] - 1) / factor[a];
    elements.size[a] = std::max(0, end - elements.first[a]);
  }
  return elements.voxels() > 0 ? elements : VoxelBox();
}

ReducedBox reduceBox(const Grid& whole, const Index3& factor, const VoxelBox& elements, int axes, const VoxelRows& rows,
  const std::vector<VoxelBox>& known)
{
  const auto components = static_cast<std::size_t>(axes);
  ReducedBox reduced{ elements, std::vector<float>(elements.voxels() * components),
    std::vector<std::uint8_t>(elements.voxels(), 0) };
  if (elements.voxels() == 0)
  {
    return reduced; // a part of the image that is thinner than an element
  }
  Index3 first; // voxels of the box
  Index3 end;
  for (int a = 0; a < 3; ++a)
  {
    first[a] = elements.first[a] * factor[a];
    end[a] = std::min((elements.first[a] + elements.size[a]) * factor[a], whole.size[a]);
  }
  const auto rowOfElements = static_cast<std::size_t>(elements.size[0]);
  const std::size_t layerOfElements = rowOfElements * elements.size[1];
  const auto width = static_cast<std::size_t>(end[0] - first[0]);
  const std::size_t layer = width * (end[1] - first[1]);
  const auto along = static_cast<std::size_t>(factor[0]);
  std::vector<Mean> means(layerOfElements * components);
  std::vector<std::uint8_t> tissue(2 * layer); // 1 or 0, of this layer of voxels and of the one before it
  std::vector<float> row(width * components);
  for (int k = first[2]; k < end[2]; ++k)
  {
    std::uint8_t* here = tissue.data() + k % 2 * layer;
    const std::uint8_t* below = tissue.data() + (k + 1) % 2 * layer;
    for (int j = first[1]; j < end[1]; ++j, here += width, below += width)
    {
      if (!known.empty())
      {
        std::fill(row.begin(), row.end(), air);
      }
      const Range all{ elements.first[0], elements.first[0] + elements.size[0] };
      for (const Range& range : without(known, all, j / factor[1], k / factor[2]))
      {
        const int from = range.first * factor[0];
        const int to = std::min(range.second * factor[0], end[0]);
        rows(from, j, k, to - from, row.data() + (from - first[0]) * components);
      }
      for (std::size_t n = 0; n < width; ++n)
      {
        here[n] = row[n * components] != air ? 1 : 0;
      }
      const std::size_t element = elements.at(elements.first[0], j / factor[1], k / factor[2]);
      std::uint8_t* const linked = reduced.linked.data() + element;
      addRow(row, components, along, means.data() + element % layerOfElements * components);
      linkAlong(here, width, along, linked);
      if (j > first[1] && j % factor[1] == 0)
      {
        linkAcross(here - width, here, width, along, 2, linked - rowOfElements);
      }
      if (k > first[2] && k % factor[2] == 0)
      {
        linkAcross(below, here, width, along, 4, linked - layerOfElements);
      }
    }
    if ((k + 1) % factor[2] == 0 || k + 1 == end[2])
    {
      const auto place = static_cast<std::size_t>(k / factor[2] - elements.first[2]);
      std::transform(means.begin(), means.end(), reduced.constraints.begin() + means.size() * place,
        [](const Mean& mean) { return mean.signedConstraint(); });
      std::fill(means.begin(), means.end(), Mean());
    }
  }
  return reduced;
}

}
