#include "RigidClusters.h"

#include "ElementRuns.h"
#include "Pass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace chainmail
{

namespace
{

/// The number of links that one work-item sums up. It is fixed, so sums do not depend on the layout of the state.
constexpr int chunkLength = 16;

/// Up to so many chunks a processor does a pass in one launch, see clusterPass(). Eight members count as a chunk.
/// Blocks with 342 took 0.8 to 1.0 times as long as in three launches, blocks with 760 1.1 to 1.5 times.
constexpr std::size_t fewChunks = 512;

}

RigidClusters::RigidClusters(Bricks& bricks)
  : bricks_(bricks)
  , soft_(bricks)
  , rotating_(bricks)
{
  const Grid& grid = bricks.model().grid();
  const int axes = bricks.model().axes();
  for (int axis = 0; axis < axes; ++axis)
  {
    const std::size_t before = this->clusters_.size();
    const std::size_t firstVoxel = this->voxels_.size();
    const std::vector<ElementRun> found = connectedRuns(bricks, axis, true);

    // A counting sort leaves the members of each cluster in the order of voxels.
    std::vector<std::size_t> ends(1, firstVoxel);
    for (const ElementRun& run : found)
    {
      ends.resize(std::max<std::size_t>(ends.size(), static_cast<std::size_t>(run.component) + 2), 0);
      ends[run.component + 1] += run.count;
    }
    const std::size_t count = ends.size() - 1;
    for (std::size_t id = 0; id < count; ++id)
    {
      ends[id + 1] += ends[id];
      this->clusters_.push_back(
        { axes == 1 ? -1 : axis, ends[id], ends[id + 1] - ends[id], false, false, false, {}, {} });
    }
    this->voxels_.resize(ends[count]);
    for (const ElementRun& run : found)
    {
      for (std::uint32_t n = 0; n < run.count; ++n)
      {
        this->voxels_[ends[run.component]++] = static_cast<std::uint32_t>(run.first + n);
      }
    }
    for (const ElementRun& run : found)
    {
      Cluster& cluster = this->clusters_[before + run.component];
      cluster.anchored = cluster.anchored || run.anchored;
    }
    for (std::size_t id = before; id < this->clusters_.size(); ++id)
    {
      Cluster& cluster = this->clusters_[id];
      for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
      {
        const Index3 at = grid.indexOf(this->voxels_[n]);
        cluster.bricks.push_back(bricks.brickAt(at[0], at[1], at[2]));
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

void RigidClusters::begin(const std::vector<std::size_t>& heldVoxels, const std::vector<std::size_t>& rotated)
{
  for (Cluster& cluster : this->clusters_)
  {
    cluster.held = cluster.anchored;
    cluster.active = false;
    cluster.heldVoxels.clear();
  }
  this->active_.clear();
  this->bodyList_.clear();
  this->beginSoft();

  for (const std::size_t voxel : heldVoxels)
  {
    for (int axis = 0; axis < this->bricks_.model().axes(); ++axis)
    {
      const int id = this->clusterOf(voxel, axis);
      if (id >= 0)
      {
        this->clusters_[id].held = this->clusters_[id].held || !this->clustersRotate();
        this->clusters_[id].heldVoxels.push_back(voxel);
      }
    }
  }
  for (const std::size_t voxel : rotated)
  {
    const int id = this->clusterOf(voxel, 0);
    if (id >= 0)
    {
      this->clusters_[id].held = true;
    }
  }
  for (Cluster& cluster : this->clusters_)
  {
    if (this->clustersRotate() && !cluster.held && !cluster.heldVoxels.empty())
    {
      std::sort(cluster.heldVoxels.begin(), cluster.heldVoxels.end());
      cluster.held = this->bodyOf(cluster).freedom == RotatingClusters::Freedom::None;
    }
  }
}

/// Finds the soft links of all clusters.
void RigidClusters::beginSoft()
{
  this->soft_.begin(
    [this](std::size_t voxel, const auto& add)
    {
      for (int axis = 0; axis < this->bricks_.model().axes(); ++axis)
      {
        const int id = this->clusterOf(voxel, axis);
        if (id >= 0)
        {
          add(id);
        }
      }
    });
}

void RigidClusters::beginCorrection(const std::vector<std::size_t>& heldVoxels, const Field& residual)
{
  this->begin(heldVoxels);
  const bool allStay = this->bricks_.model().axes() > 1;
  std::vector<int> free;
  for (std::size_t id = 0; id < this->clusters_.size(); ++id)
  {
    this->clusters_[id].held = this->clusters_[id].held || allStay;
    if (!this->clusters_[id].held)
    {
      free.push_back(static_cast<int>(id));
    }
  }
  const std::vector<float> residuals = this->membersOf(free).values(residual);
  auto along = residuals.begin();
  for (const int id : free)
  {
    Cluster& cluster = this->clusters_[id];
    for (std::size_t n = 0; n < cluster.count; ++n, along += 3)
    {
      cluster.held = cluster.held || std::isinf(*along);
    }
  }
  if (allStay)
  {
    return;
  }

  Elements fixed(this->bricks_);
  std::vector<std::size_t> moving;
  for (const Cluster& cluster : this->clusters_)
  {
    for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
    {
      const Index3 at = this->bricks_.model().grid().indexOf(this->voxels_[n]);
      if (!cluster.held)
      {
        moving.push_back(this->voxels_[n]);
      }
      else if (this->bricks_.hasState(this->bricks_.brickAt(at[0], at[1], at[2])))
      {
        fixed.add(at);
      }
    }
  }
  fixed.set(residual, std::vector<float>(3 * fixed.size(), std::numeric_limits<float>::infinity()));
  if (this->bricks_.softLinks())
  {
    std::sort(moving.begin(), moving.end());
    this->bricks_.readSoftLinks(moving);
    this->beginSoft();
  }
}

RotatingClusters::Body RigidClusters::bodyOf(const Cluster& cluster) const
{
  return RotatingClusters::bodyOf(
    this->bricks_, this->voxels_.data() + cluster.first, cluster.count, cluster.heldVoxels, cluster.anchored);
}

void RigidClusters::projectToRigid(bool rotates)
{
  std::set<int> touched;
  for (const int slot : this->bricks_.dirtySlots())
  {
    const auto here = this->ofBrick_.find(this->bricks_.brick(slot));
    if (here != this->ofBrick_.end())
    {
      touched.insert(here->second.begin(), here->second.end());
    }
  }
  std::vector<int> bricks;
  for (const int id : touched)
  {
    bricks.insert(bricks.end(), this->clusters_[id].bricks.begin(), this->clusters_[id].bricks.end());
  }
  this->bricks_.makeUpdatable(bricks);
  if (!this->clustersRotate())
  {
    for (const int id : touched)
    {
      this->alignAxis(this->clusters_[id]);
    }
    return;
  }
  const Elements members = this->membersOf(std::vector<int>(touched.begin(), touched.end()));
  std::vector<float> places = members.displacements();
  std::vector<float> rotations = members.rotations();
  std::size_t first = 0;
  for (const int id : touched)
  {
    const Cluster& cluster = this->clusters_[id];
    RotatingClusters::projectToRigid(this->bricks_, this->voxels_.data() + cluster.first, cluster.count,
      this->bodyOf(cluster), cluster.anchored, cluster.heldVoxels, rotates, &places[first], &rotations[first]);
    first += 3 * cluster.count;
  }
  members.setDisplacements(places);
  members.setRotations(rotations);
}

/// Adds the members of a cluster to a list.
void RigidClusters::addMembers(const Cluster& cluster, Elements& elements) const
{
  for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
  {
    elements.add(this->voxels_[n]);
  }
}

/// The members of these clusters, one cluster after the other.
Elements RigidClusters::membersOf(const std::vector<int>& clusters) const
{
  Elements members(this->bricks_);
  for (const int id : clusters)
  {
    this->addMembers(this->clusters_[id], members);
  }
  return members;
}

/// Gives all members of a cluster of one axis the same displacement along this axis, and no rotation.
void RigidClusters::alignAxis(const Cluster& cluster)
{
  Elements members(this->bricks_);
  this->addMembers(cluster, members);
  std::vector<float> places = members.displacements();
  const std::size_t axis = static_cast<std::size_t>(cluster.axis);
  double place = 0.0;
  if (!cluster.heldVoxels.empty())
  {
    const auto first = this->voxels_.begin() + static_cast<std::ptrdiff_t>(cluster.first);
    const auto held = std::lower_bound(first, first + static_cast<std::ptrdiff_t>(cluster.count),
      static_cast<std::uint32_t>(cluster.heldVoxels.front()));
    place = places[3 * static_cast<std::size_t>(held - first) + axis];
  }
  for (std::size_t n = 0; !cluster.anchored && cluster.heldVoxels.empty() && n < cluster.count; ++n)
  {
    place += places[3 * n + axis] / static_cast<double>(cluster.count);
  }
  for (std::size_t n = 0; n < cluster.count; ++n)
  {
    places[3 * n + axis] = static_cast<float>(place);
  }
  members.setDisplacements(places);
  members.setRotations(std::vector<float>(places.size(), 0.0f));
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
    if (this->clustersRotate())
    {
      this->bodyList_.push_back(this->bodyOf(this->clusters_[id]));
    }
  }
  this->bricks_.makeUpdatable(needed);
  this->active_.insert(this->active_.end(), added.begin(), added.end());
  this->list();
  if (this->clustersRotate())
  {
    this->rotating_.upload(this->bodyList_, this->chunkList_.size());
  }
  else
  {
    this->refresh();
  }
  this->soft_.upload(this->active_, this->bodyList_);
}

/// Lists the active clusters on the device. Most often they are those of the previous relaxation, in the same order.
void RigidClusters::list()
{
  if (this->active_ == this->listed_)
  {
    return;
  }
  if (this->listed_.size() > this->active_.size() ||
      !std::equal(this->listed_.begin(), this->listed_.end(), this->active_.begin()))
  {
    this->listed_.clear();
    this->directionList_.clear();
    this->chunkList_.clear();
    this->linkList_.clear();
    this->memberList_.clear();
    this->clusterList_.clear();
  }
  const std::vector<int> added(
    this->active_.begin() + static_cast<std::ptrdiff_t>(this->listed_.size()), this->active_.end());
  this->bricks_.allocateStates(this->bricksLinkedTo(added));
  const Grid& grid = this->bricks_.model().grid();
  std::vector<float> c(this->bricks_.model().axes());
  for (const int id : added)
  {
    const Cluster& cluster = this->clusters_[id];
    const cl_int position = static_cast<cl_int>(this->listed_.size());
    const int axis = std::max(0, cluster.axis);
    const std::size_t firstLink = this->linkList_.size();
    const cl_int firstMember = static_cast<cl_int>(this->memberList_.size());
    for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
    {
      const Index3 at = grid.indexOf(this->voxels_[n]);
      this->memberList_.push_back({ { this->bricks_.address(at[0], at[1], at[2]), static_cast<cl_uint>(position) } });
      this->bricks_.forNeighbours(at,
        [&](int direction, const Index3& next)
        {
          this->bricks_.row(next[0], next[1], next[2], 1, c.data());
          if (c[axis] != 0.0f && !std::isinf(c[axis]))
          {
            this->linkList_.push_back(this->bricks_.address(next[0], next[1], next[2]));
            this->directionList_.push_back(static_cast<cl_uchar>(direction));
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
      { { firstChunk, static_cast<cl_int>(this->chunkList_.size()) - firstChunk, cluster.axis, firstMember } });
    this->listed_.push_back(id);
  }
  this->upload();
}

/// The bricks of elements that a link between two bricks joins to a member of these clusters.
std::vector<int> RigidClusters::bricksLinkedTo(const std::vector<int>& clusters) const
{
  const Grid& grid = this->bricks_.model().grid();
  std::set<int> beside;
  for (const int id : clusters)
  {
    const Cluster& cluster = this->clusters_[id];
    for (std::size_t n = cluster.first; n < cluster.first + cluster.count; ++n)
    {
      const Index3 at = grid.indexOf(this->voxels_[n]);
      const int own = this->bricks_.brickAt(at[0], at[1], at[2]);
      this->bricks_.forNeighbours(at,
        [&](int, const Index3& next)
        {
          const int brick = this->bricks_.brickAt(next[0], next[1], next[2]);
          if (brick != own)
          {
            beside.insert(brick);
          }
        });
    }
  }
  return std::vector<int>(beside.begin(), beside.end());
}

void RigidClusters::upload()
{
  Context& context = this->bricks_.context();
  const char* purpose = "the rigid clusters";
  this->chunks_ = context.upload(this->chunkList_, purpose);
  this->links_ = context.upload(this->linkList_, purpose);
  this->directions_ = context.upload(this->directionList_, purpose);
  this->members_ = context.upload(this->memberList_, purpose);
  this->heads_ = context.upload(this->clusterList_, purpose);
  if (!this->clustersRotate())
  {
    const std::size_t chunks = std::max<std::size_t>(1, this->chunkList_.size());
    this->partial_ = context.allocate(sizeof(cl_float) * 12 * chunks, purpose);
    this->places_ = context.allocate(sizeof(cl_float) * 3 * this->active_.size(), purpose);
    this->moves_ = context.allocate(sizeof(cl_float) * this->active_.size(), purpose);
  }
}

void RigidClusters::refresh()
{
  if (this->active_.empty())
  {
    return;
  }
  if (this->clustersRotate())
  {
    this->rotating_.refresh();
    return;
  }
  // The place of a cluster is that of its first member.
  Elements firsts(this->bricks_);
  for (const int id : this->active_)
  {
    firsts.add(this->voxels_[this->clusters_[id].first]);
  }
  this->bricks_.context().write(this->places_, 0, firsts.displacements());
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

void RigidClusters::relax(float omega, float still, const Elasticity& elasticity, const PassArguments& pass)
{
  Context& context = this->bricks_.context();
  if (this->clustersRotate())
  {
    this->rotating_.relax(
      { this->chunks_, this->chunkList_.size(), this->links_, this->linkList_.size(), this->directions_, this->heads_,
        this->members_, this->memberList_.size(), this->soft_.list() },
      omega, still, elasticity.limited, pass);
    return;
  }
  const std::string defines = this->bricks_.defines(false) + elasticity.ofLinks() + this->bricks_.ofSoftLinks();
  const auto kernel = [&](const char* name) { return context.kernel("clusters.cl", defines, name); };
  const auto arguments =
    std::make_tuple(pass, this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), this->arguments(),
      omega, still, elasticity.slack, static_cast<cl_int>(elasticity.limited));

  if (!context.info().takesManyItems() && this->chunkList_.size() + this->memberList_.size() / 8 <= fewChunks)
  {
    launchPass(this->bricks_, kernel("clusterPass"), 1, 1, arguments, this->counts());
    return;
  }
  if (!this->chunkList_.empty())
  {
    context.launchOver(kernel("clusterGather"), this->chunkList_.size(), arguments);
  }
  context.launch(kernel("clusterMove"), this->active_.size(), context.info().takesManyItems() ? 16 : 1, arguments);
  launchPassOver(this->bricks_, kernel("clusterScatter"), this->memberList_.size(), arguments);
}

}
