#include "ProbeSelection.h"

#include "Error.h"
#include "Format.h"
#include "Measurement.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>
#include <unordered_set>

namespace chainmail
{

namespace
{

/// Selects the elements that a probe grabs, among those that are offered to it one by one.
class ProbeSelection
{
public:
  ProbeSelection(const Probe& probe, const Grid& grid)
    : probe_(probe)
    , spacing_(grid.spacing)
  {
    // Where no element is within the radius, the nearest one is taken if it is at most half a voxel's diagonal away.
    for (int a = 0; a < 3; ++a)
    {
      this->reach2_ += 0.25 * grid.spacing[a] * grid.spacing[a];
    }
    this->reach2_ *= 1.0 + 1e-9;
    this->radius2_ = probe.radius * probe.radius * (1.0 + 1e-9);
  }

  const Probe& probe() const { return this->probe_; }

  /// Elements further from the probe than this need not be offered [mm].
  double farthest() const { return std::sqrt(std::max(this->reach2_, this->radius2_)); }

  /// Offers an element at its current place [voxels].
  void offer(std::size_t voxel, const Vector3& place)
  {
    const double dx = place[0] * this->spacing_[0] - this->probe_.position[0];
    const double dy = place[1] * this->spacing_[1] - this->probe_.position[1];
    const double dz = place[2] * this->spacing_[2] - this->probe_.position[2];
    const double distance2 = dx * dx + dy * dy + dz * dz;
    if (this->probe_.radius > 0.0 && distance2 <= this->radius2_)
    {
      this->within_.push_back(voxel);
    }
    if (distance2 < this->nearest2_ || (distance2 == this->nearest2_ && voxel < this->nearest_))
    {
      this->nearest2_ = distance2;
      this->nearest_ = voxel;
    }
  }

  /// The elements that the probe grabs, ascending; empty where no tissue is near.
  std::vector<std::size_t> grabbed()
  {
    if (this->within_.empty() && this->nearest2_ <= this->reach2_)
    {
      return { this->nearest_ };
    }
    std::sort(this->within_.begin(), this->within_.end());
    return this->within_;
  }

private:
  const Probe& probe_;
  Vector3 spacing_;
  double reach2_ = 0.0;
  double radius2_ = 0.0;
  std::vector<std::size_t> within_;
  std::size_t nearest_ = 0;
  double nearest2_ = std::numeric_limits<double>::infinity();
};

/// Narrows [begin, end] to the voxels of one axis whose current places can lie within `farthest` of `position`, given
/// that their displacements are between `low` and `high` voxels.
void clampRange(
  double position, double farthest, double spacing, double low, double high, int begin, int end, int& first, int& last)
{
  first = static_cast<int>(
    std::min(std::max(std::ceil((position - farthest) / spacing - high), static_cast<double>(begin)), end + 0.0));
  last =
    static_cast<int>(std::max(std::min(std::floor((position + farthest) / spacing - low), end - 1.0), begin - 1.0));
}

/// Calls f(i, j, k) for every element of a box.
template <typename F> void forElements(const Bricks& bricks, const Index3& first, const Index3& last, const F& f)
{
  if (first[0] > last[0])
  {
    return;
  }
  const int axes = bricks.model().axes();
  const int count = last[0] - first[0] + 1;
  std::vector<float> row(static_cast<std::size_t>(count) * axes);
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      bricks.row(first[0], j, k, count, row.data());
      for (int n = 0; n < count; ++n)
      {
        if (!std::isinf(row[static_cast<std::size_t>(n) * axes]))
        {
          f(first[0] + n, j, k);
        }
      }
    }
  }
}

/// Offers tissue that has moved, brick by brick. Returns the bricks that hold such tissue.
std::unordered_set<int> offerDisplaced(Bricks& bricks, std::vector<ProbeSelection>& grasps)
{
  std::unordered_set<int> displaced;
  if (bricks.dirtySlots().empty())
  {
    return displaced;
  }
  const Grid& grid = bricks.model().grid();
  const Index3 size = bricks.size();
  const std::vector<BrickFigures> figures = measureBricks(bricks);
  std::vector<float> u;
  for (std::size_t n = 0; n < figures.size(); ++n)
  {
    if (figures[n].displaced == 0.0f)
    {
      continue;
    }
    const int slot = static_cast<int>(n) + 1;
    displaced.insert(bricks.brick(slot));
    const Index3 origin = bricks.origin(bricks.brick(slot));
    bool read = false;
    for (ProbeSelection& grasp : grasps)
    {
      Index3 first;
      Index3 last;
      bool near = true;
      for (int a = 0; near && a < 3; ++a)
      {
        clampRange(grasp.probe().position[a], grasp.farthest(), grid.spacing[a], figures[n].low[a], figures[n].high[a],
          origin[a], std::min(origin[a] + size[a], grid.size[a]), first[a], last[a]);
        near = first[a] <= last[a];
      }
      if (!near)
      {
        continue;
      }
      if (!read)
      {
        bricks.readSlot(slot, u);
        read = true;
      }
      forElements(
        bricks, first, last, [&](int i, int j, int k) { grasp.offer(grid.at(i, j, k), bricks.place(i, j, k, u)); });
    }
  }
  return displaced;
}

/// Offers the tissue of all other bricks, which is at rest.
void offerAtRest(const Bricks& bricks, const std::unordered_set<int>& displaced, ProbeSelection& grasp)
{
  const Grid& grid = bricks.model().grid();
  Index3 first;
  Index3 last;
  for (int a = 0; a < 3; ++a)
  {
    clampRange(
      grasp.probe().position[a], grasp.farthest(), grid.spacing[a], 0.0, 0.0, 0, grid.size[a], first[a], last[a]);
  }
  forElements(bricks, first, last,
    [&](int i, int j, int k)
    {
      if (displaced.empty() || displaced.count(bricks.brickAt(i, j, k)) == 0)
      {
        grasp.offer(grid.at(i, j, k), { double(i), double(j), double(k) });
      }
    });
}

/// Those of these voxels that are tissue, ascending.
std::vector<std::size_t> tissueOf(const Bricks& bricks, const std::vector<std::size_t>& voxels)
{
  std::vector<std::size_t> tissue;
  std::copy_if(voxels.begin(), voxels.end(), std::back_inserter(tissue),
    [&](std::size_t voxel) { return bricks.isElement(bricks.model().grid().indexOf(voxel)); });
  std::sort(tissue.begin(), tissue.end());
  tissue.erase(std::unique(tissue.begin(), tissue.end()), tissue.end());
  return tissue;
}

}

std::string nameOf(const Probe& probe, std::size_t number)
{
  return "Probe " + std::to_string(number) + " at " + toString(probe.position) + " mm along the image's axes";
}

std::vector<std::vector<std::size_t>> elementsAround(
  Bricks& bricks, const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers)
{
  if (probes.empty())
  {
    return {};
  }
  std::vector<ProbeSelection> grasps;
  for (const Probe& probe : probes)
  {
    grasps.emplace_back(probe, bricks.model().grid());
  }
  const std::unordered_set<int> displaced = offerDisplaced(bricks, grasps);
  std::vector<std::vector<std::size_t>> grabbed;
  for (ProbeSelection& grasp : grasps)
  {
    const Probe& probe = grasp.probe();
    const std::size_t number = numbers[grabbed.size()];
    if (probe.voxels)
    {
      grabbed.push_back(tissueOf(bricks, *probe.voxels));
    }
    else
    {
      offerAtRest(bricks, displaced, grasp);
      grabbed.push_back(grasp.grabbed());
    }
    if (grabbed.back().empty())
    {
      throw ProbeError(number, nameOf(probe, number),
        probe.voxels
          ? "holds no tissue: none of its voxels is tissue. Give the probe other voxels, or lower TissueThreshold."
          : "holds no tissue: no voxel within its radius of " + toString(probe.radius) +
              " mm is tissue. Move the probe onto tissue, enlarge its radius, or lower TissueThreshold.");
    }
  }
  return grabbed;
}

std::vector<std::size_t> withNotches(const Bricks& bricks, std::vector<std::size_t> elements)
{
  constexpr float stiff =
    0.12f; // constraint up to which links do not stretch by one step of longestRotation (Waves.cpp)
  constexpr int layers = 3;
  const Grid& grid = bricks.model().grid();
  const auto constraintOf = [&](const Index3& at)
  {
    float constraint;
    bricks.row(at[0], at[1], at[2], 1, &constraint);
    return constraint;
  };
  std::vector<std::size_t> outermost;
  std::copy_if(elements.begin(), elements.end(), std::back_inserter(outermost),
    [&](std::size_t voxel) { return constraintOf(grid.indexOf(voxel)) == 0.0f; });
  const std::unordered_set<std::size_t> own(elements.begin(), elements.end());
  std::unordered_map<std::size_t, int> links; // for other elements: how many links to bone or to added elements
  for (int layer = 0; layer < layers && !outermost.empty(); ++layer)
  {
    std::vector<std::size_t> next;
    for (const std::size_t voxel : outermost)
    {
      bricks.forNeighbours(grid.indexOf(voxel),
        [&](int, const Index3& at)
        {
          const std::size_t beside = grid.at(at[0], at[1], at[2]);
          const float constraint = constraintOf(at);
          if (constraint > 0.0f && constraint <= stiff && own.count(beside) == 0 && ++links[beside] == 2)
          {
            next.push_back(beside);
          }
        });
    }
    elements.insert(elements.end(), next.begin(), next.end());
    outermost = std::move(next);
  }
  std::sort(elements.begin(), elements.end());
  return elements;
}

}
