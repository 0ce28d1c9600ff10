#include "VoxelExtents.h"

#include "ElementRule.h"
#include "Elements.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

VoxelExtents::VoxelExtents(const Bricks& voxels, Bricks& elements, const Index3& factor)
  : voxels_(voxels)
  , elements_(elements)
  , factor_(factor)
{
}

void VoxelExtents::find(const std::unordered_map<std::size_t, std::size_t>& owners)
{
  this->bricks_.clear();
  this->extents_.clear();
  this->counts_.clear();
  this->numbers_.assign(this->voxels_.numbers(), -1);
  for (const int slot : this->elements_.dirtySlots())
  {
    this->addElements(slot);
  }
  this->addRest();
  if (!this->bricks_.empty())
  {
    this->addOwners(owners);
  }
  this->sort();
}

/// The displacements of the voxels of one element. A rotation adds most at the element's corners.
VoxelExtents::Bounds VoxelExtents::boundsOf(const float* displacement, const float* spin) const
{
  std::array<float, 3> rotated{};
  for (int b = 0; spin && b < 3; ++b)
  {
    const auto& proportions = this->elements_.rotations()->proportions.s;
    float offset[3];
    rule::single::rotationOffsetOfAxis(spin, b, offset);
    for (int a = 0; a < 3; ++a)
    {
      rotated[a] += 0.5f * this->factor_[a] * std::fabs(offset[a]) * proportions[b] / proportions[a];
    }
  }
  Bounds bounds;
  for (int a = 0; a < 3; ++a)
  {
    bounds.low[a] = this->factor_[a] * displacement[a] - rotated[a];
    bounds.high[a] = this->factor_[a] * displacement[a] + rotated[a];
  }
  return bounds;
}

void VoxelExtents::include(int brick, const Bounds& bounds)
{
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (this->numbers_[brick] < 0)
  {
    this->numbers_[brick] = static_cast<int>(this->bricks_.size());
    this->bricks_.push_back(brick);
    this->counts_.push_back(0);
    this->extents_.emplace_back();
    BrickExtent& extent = this->extents_.back();
    for (int a = 0; a < 3; ++a)
    {
      extent.low[a] = infinity;
      extent.high[a] = -infinity;
      extent.last[a] = static_cast<float>(this->voxels_.size()[a] - 1);
    }
  }
  BrickExtent& extent = this->extents_[static_cast<std::size_t>(this->numbers_[brick])];
  for (int a = 0; a < 3; ++a)
  {
    extent.low[a] = std::min(extent.low[a], bounds.low[a]);
    extent.high[a] = std::max(extent.high[a], bounds.high[a]);
  }
}

/// Adds the voxels around the displaced elements of a slot. Those up to half an element further are interpolated from
/// an element, too.
void VoxelExtents::addElements(int slot)
{
  const Index3& whole = this->voxels_.model().grid().size;
  const Index3& grid = this->elements_.model().grid().size;
  const Index3 size = this->voxels_.size();
  const bool rotate = this->elements_.activeRotations() != nullptr;
  std::vector<float> u;
  std::vector<float> spins;
  this->elements_.readSlot(slot, u);
  if (rotate)
  {
    this->elements_.readRotations(slot, spins);
  }
  const auto count = static_cast<std::size_t>(this->elements_.elementsPerBrick());
  for (const Bricks::Row& row : this->elements_.rows(this->elements_.brick(slot)))
  {
    Index3 at = this->elements_.model().grid().indexOf(row.voxel);
    for (int n = 0; n < row.count && at[0] < grid[0]; ++n, ++at[0])
    {
      const std::size_t local = row.local(n);
      const float displacement[3] = { u[local], u[count + local], u[2 * count + local] };
      if (displacement[0] == 0.0f && displacement[1] == 0.0f && displacement[2] == 0.0f)
      {
        continue;
      }
      float spin[3];
      for (std::size_t a = 0; rotate && a < 3; ++a)
      {
        spin[a] = spins[a * count + local];
      }
      const Bounds bounds = this->boundsOf(displacement, rotate ? spin : nullptr);
      Index3 first;
      Index3 last;
      for (int a = 0; a < 3; ++a)
      {
        const int half = this->factor_[a] / 2;
        first[a] = std::max(at[a] * this->factor_[a] - half, 0) / size[a];
        last[a] = std::min((at[a] + 1) * this->factor_[a] + half - 1, whole[a] - 1) / size[a];
      }
      for (int z = first[2]; z <= last[2]; ++z)
      {
        for (int y = first[1]; y <= last[1]; ++y)
        {
          for (int x = first[0]; x <= last[0]; ++x)
          {
            const int brick = this->voxels_.brickAt(x * size[0], y * size[1], z * size[2]);
            this->include(brick, bounds);
            ++this->counts_[static_cast<std::size_t>(this->numbers_[brick])];
          }
        }
      }
    }
  }
}

/// Includes 0 where some of the elements around a brick are at rest, or air.
void VoxelExtents::addRest()
{
  const Index3& whole = this->voxels_.model().grid().size;
  const Index3& grid = this->elements_.model().grid().size;
  for (std::size_t n = 0; n < this->bricks_.size(); ++n)
  {
    const Index3 origin = this->voxels_.origin(this->bricks_[n]);
    int around = 1;
    for (int a = 0; a < 3; ++a)
    {
      const int half = this->factor_[a] / 2;
      const int last = std::min(origin[a] + this->voxels_.size()[a], whole[a]) - 1;
      const int from = std::max(origin[a] - half, 0) / this->factor_[a];
      const int to = std::min((last + half) / this->factor_[a], grid[a] - 1);
      around *= to - from + 1;
    }
    if (this->counts_[n] < around)
    {
      this->include(this->bricks_[n], Bounds());
    }
  }
}

void VoxelExtents::addOwners(const std::unordered_map<std::size_t, std::size_t>& owners)
{
  Elements elements(this->elements_);
  std::vector<int> bricks;
  for (const auto& [voxel, element] : owners)
  {
    const Index3 at = this->voxels_.model().grid().indexOf(voxel);
    bricks.push_back(this->voxels_.brickAt(at[0], at[1], at[2]));
    elements.add(element);
  }
  const std::vector<float> displacements = elements.displacements();
  const bool rotate = this->elements_.activeRotations() != nullptr;
  const std::vector<float> spins = rotate ? elements.rotations() : std::vector<float>();
  for (std::size_t n = 0; n < bricks.size(); ++n)
  {
    this->include(bricks[n], this->boundsOf(&displacements[3 * n], rotate ? &spins[3 * n] : nullptr));
  }
}

/// Makes the bricks ascending.
void VoxelExtents::sort()
{
  std::vector<BrickExtent> extents;
  extents.reserve(this->extents_.size());
  std::sort(this->bricks_.begin(), this->bricks_.end());
  for (const int brick : this->bricks_)
  {
    extents.push_back(this->extents_[static_cast<std::size_t>(this->numbers_[brick])]);
  }
  this->extents_ = std::move(extents);
}

}
