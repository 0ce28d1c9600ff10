#include "RigidClusters.h"

#include "Components.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// The number of links that one work-item sums up. It is fixed so that no layout of the state changes a sum.
constexpr int chunkLength = 16;

}

int RigidClusters::label(const Bricks& bricks, int axis, std::vector<int>& out)
{
  const Grid& grid = bricks.model().grid();
  const int axes = bricks.model().axes();
  constexpr int unlabelled = -2;
  out.assign(grid.voxels(), -1);
  std::vector<float> row(static_cast<std::size_t>(grid.size[0]) * axes);
  for (int k = 0; k < grid.size[2]; ++k)
  {
    for (int j = 0; j < grid.size[1]; ++j)
    {
      bricks.row(0, j, k, grid.size[0], row.data());
      int* labels = out.data() + grid.at(0, j, k);
      for (int i = 0; i < grid.size[0]; ++i)
      {
        labels[i] = row[static_cast<std::size_t>(i) * axes + axis] == 0.0f ? unlabelled : -1;
      }
    }
  }

  int count = 0;
  std::vector<std::size_t> front;
  for (std::size_t seed = 0; seed < out.size(); ++seed)
  {
    if (out[seed] != unlabelled)
    {
      continue;
    }
    out[seed] = count;
    visitComponent(seed, front,
      [&](std::size_t voxel, const auto& add)
      {
        bricks.forNeighbours(grid.indexOf(voxel),
          [&](int, const Index3& next)
          {
            int& label = out[grid.at(next[0], next[1], next[2])];
            if (label == unlabelled)
            {
              label = count;
              add(grid.at(next[0], next[1], next[2]));
            }
          });
      });
    ++count;
  }
  return count;
}

RigidClusters::RigidClusters(Bricks& bricks)
  : bricks_(bricks)
{
  const Grid& grid = bricks.model().grid();
  const int axes = bricks.model().axes();
  std::vector<int> labels;
  for (int axis = 0; axis < axes; ++axis)
  {
    const std::size_t before = this->clusters_.size();
    const std::size_t firstVoxel = this->voxels_.size();
    const int count = label(bricks, axis, labels);

    // A counting sort leaves the members of each cluster in the order of voxels.
    std::vector<std::size_t> ends(count + 1, firstVoxel);
    for (const int id : labels)
    {
      if (id >= 0)
      {
        ++ends[id + 1];
      }
    }
    for (int id = 0; id < count; ++id)
    {
      ends[id + 1] += ends[id] - firstVoxel;
      this->clusters_.push_back({ axes == 1 ? -1 : axis, ends[id], ends[id + 1] - ends[id], false, false, false, {} });
    }
    this->voxels_.resize(ends[count]);
    std::vector<std::size_t> cursor(ends.begin(), ends.end());
    for (std::size_t voxel = 0; voxel < labels.size(); ++voxel)
    {
      if (labels[voxel] >= 0)
      {
        this->voxels_[cursor[labels[voxel]]++] = static_cast<std::uint32_t>(voxel);
      }
    }
    std::vector<float> c(axes);
    for (std::size_t id = before; id < this->clusters_.size(); ++id)
    {
      Cluster& cluster = this->clusters_[id];
      for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
      {
        const Index3 at = grid.indexOf(this->voxels_[n]);
        cluster.bricks.push_back(bricks.brickAt(at[0], at[1], at[2]));
        if (!cluster.anchored)
        {
          bricks.row(at[0], at[1], at[2], 1, c.data());
          cluster.anchored = std::signbit(c[axis]);
        }
      }
      std::sort(cluster.bricks.begin(), cluster.bricks.end());
      cluster.bricks.erase(std::unique(cluster.bricks.begin(), cluster.bricks.end()), cluster.bricks.end());
      for (const int brick : cluster.bricks)
      {
        this->ofBrick_[brick].push_back(static_cast<int>(id));
      }
    }
  }
}

std::vector<std::size_t> RigidClusters::withClusters(const std::vector<std::size_t>& voxels, int axis) const
{
  std::vector<std::size_t> all = voxels;
  std::vector<int> taken;
  for (const std::size_t voxel : voxels)
  {
    const int id = this->clusterOf(voxel, axis);
    if (id >= 0 && std::find(taken.begin(), taken.end(), id) == taken.end())
    {
      taken.push_back(id);
      const auto first = this->voxels_.begin() + this->clusters_[id].first;
      all.insert(all.end(), first, first + this->clusters_[id].count);
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

int RigidClusters::clusterOf(std::size_t voxel, int axis) const
{
  const Index3 at = this->bricks_.model().grid().indexOf(voxel);
  const auto here = this->ofBrick_.find(this->bricks_.brickAt(at[0], at[1], at[2]));
  if (here != this->ofBrick_.end())
  {
    for (const int id : here->second)
    {
      const Cluster& cluster = this->clusters_[id];
      const auto first = this->voxels_.begin() + cluster.first;
      if ((cluster.axis < 0 || cluster.axis == axis) &&
          std::binary_search(first, first + cluster.count, static_cast<std::uint32_t>(voxel)))
      {
        return id;
      }
    }
  }
  return -1;
}

void RigidClusters::begin(const std::vector<std::size_t>& heldVoxels)
{
  for (Cluster& cluster : this->clusters_)
  {
    cluster.held = cluster.anchored;
    cluster.active = false;
  }
  this->active_.clear();
  this->chunkList_.clear();
  this->linkList_.clear();
  this->memberList_.clear();
  this->clusterList_.clear();

  for (const std::size_t voxel : heldVoxels)
  {
    for (int axis = 0; axis < this->bricks_.model().axes(); ++axis)
    {
      const int id = this->clusterOf(voxel, axis);
      if (id >= 0)
      {
        this->clusters_[id].held = true;
      }
    }
  }
}

void RigidClusters::activate(const std::vector<int>& bricks)
{
  std::vector<int> added;
  for (const int brick : bricks)
  {
    const auto here = this->ofBrick_.find(brick);
    if (here == this->ofBrick_.end())
    {
      continue;
    }
    for (const int id : here->second)
    {
      Cluster& cluster = this->clusters_[id];
      if (!cluster.held && !cluster.active)
      {
        cluster.active = true;
        added.push_back(id);
      }
    }
  }
  if (added.empty())
  {
    return;
  }

  std::vector<int> needed;
  for (const int id : added)
  {
    needed.insert(needed.end(), this->clusters_[id].bricks.begin(), this->clusters_[id].bricks.end());
  }
  this->bricks_.require(needed);

  const Grid& grid = this->bricks_.model().grid();
  const int axes = this->bricks_.model().axes();
  std::vector<float> c(axes);
  for (const int id : added)
  {
    const Cluster& cluster = this->clusters_[id];
    const cl_int position = static_cast<cl_int>(this->active_.size());
    const int axis = std::max(0, cluster.axis);
    const std::size_t firstLink = this->linkList_.size();
    for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
    {
      const Index3 at = grid.indexOf(this->voxels_[n]);
      this->memberList_.push_back({ { this->bricks_.address(at[0], at[1], at[2]), static_cast<cl_uint>(position) } });
      this->bricks_.forNeighbours(at,
        [&](int, const Index3& next)
        {
          this->bricks_.row(next[0], next[1], next[2], 1, c.data());
          if (c[axis] != 0.0f && !std::isinf(c[axis]))
          {
            this->linkList_.push_back(this->bricks_.address(next[0], next[1], next[2]));
          }
        });
    }
    const cl_int firstChunk = static_cast<cl_int>(this->chunkList_.size());
    for (std::size_t link = firstLink; link < this->linkList_.size(); link += chunkLength)
    {
      const std::size_t length = std::min<std::size_t>(chunkLength, this->linkList_.size() - link);
      this->chunkList_.push_back({ { position, static_cast<cl_int>(link), static_cast<cl_int>(length), 0 } });
    }
    this->clusterList_.push_back(
      { { firstChunk, static_cast<cl_int>(this->chunkList_.size()) - firstChunk, cluster.axis, 0 } });
    this->active_.push_back(id);
  }
  this->upload();
}

void RigidClusters::upload()
{
  Context& context = this->bricks_.context();
  const char* purpose = "the rigid clusters";
  this->chunks_ = context.upload(this->chunkList_, purpose);
  this->links_ = context.upload(this->linkList_, purpose);
  this->members_ = context.upload(this->memberList_, purpose);
  this->heads_ = context.upload(this->clusterList_, purpose);
  this->partial_ = context.allocate(sizeof(cl_float) * 12 * std::max<std::size_t>(1, this->chunkList_.size()), purpose);
  this->moves_ = context.allocate(sizeof(cl_float) * this->active_.size(), purpose);
  this->refresh();
}

void RigidClusters::refresh()
{
  if (this->active_.empty())
  {
    return;
  }
  // The place of a cluster is that of its first member.
  std::vector<std::uint32_t> firsts;
  const Grid& grid = this->bricks_.model().grid();
  for (const int id : this->active_)
  {
    const Index3 at = grid.indexOf(this->voxels_[this->clusters_[id].first]);
    firsts.push_back(this->bricks_.address(at[0], at[1], at[2]));
  }
  this->places_ = this->bricks_.context().upload(this->bricks_.displacements(firsts), "the rigid clusters");
}

std::vector<int> RigidClusters::inactiveBricks() const
{
  std::vector<int> bricks;
  for (const Cluster& cluster : this->clusters_)
  {
    if (!cluster.held && !cluster.active)
    {
      bricks.insert(bricks.end(), cluster.bricks.begin(), cluster.bricks.end());
    }
  }
  return bricks;
}

void RigidClusters::relax(float omega, float still, const Elasticity& elasticity, const Turn& turn)
{
  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(false) + elasticity.ofLinks();

  context.launchOver(context.kernel("clusters.cl", defines, "clusterGather"), this->chunkList_.size(), turn.log,
    turn.turn, this->chunks_, this->links_, this->places_, elasticity.slack, this->bricks_.pitch(),
    this->bricks_.displacement, this->bricks_.constraint, this->partial_);

  context.launch(context.kernel("clusters.cl", defines, "clusterMove"), this->active_.size(),
    context.info().gpu ? 16 : 1, turn.log, turn.turn, this->heads_, static_cast<cl_int>(elasticity.limited), omega,
    still, this->partial_, this->places_, this->moves_);

  context.launchOver(context.kernel("clusters.cl", defines, "clusterScatter"), this->memberList_.size(), turn.activity,
    turn.turn, this->members_, this->heads_, this->places_, this->moves_, this->bricks_.pitch(),
    this->bricks_.displacement);
}

}
