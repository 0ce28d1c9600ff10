#pragma once

#include "Bricks.h"
#include "TurningClusters.h"

#include <unordered_map>
#include <vector>

namespace chainmail
{

/// What soft links pull the members of rigid clusters with, summed up for each cluster. All members move together, so
/// few numbers tell what any number of links cost (cluster.clh, turnclusters.cl).
class SoftClusters
{
public:
  explicit SoftClusters(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  /// Starts a relaxation: finds the clusters that have soft links. `visit(voxel, f)` calls f(cluster) for the clusters
  /// of which a voxel is a member.
  template <typename Visit> void begin(const Visit& visit)
  {
    this->links_.clear();
    this->sums_ = cl::Buffer();
    if (!this->bricks_.softLinks())
    {
      return;
    }
    for (const SoftLink& link : this->bricks_.softLinks()->all())
    {
      visit(link.voxel, [&](int cluster) { this->links_[cluster].push_back(&link); });
    }
    this->upload({}, {});
  }

  /// Lists the clusters that take part. `bodies` has one for each where clusters turn; else it is empty.
  void upload(const std::vector<int>& clusters, const std::vector<TurningClusters::Body>& bodies);

  bool any() const { return !this->links_.empty(); }
  /// The list, as the argument of kernels; null where there is no soft link.
  const cl::Buffer* list() const { return this->bricks_.softLinks() ? &this->sums_ : nullptr; }

private:
  Bricks& bricks_;
  std::unordered_map<int, std::vector<const SoftLink*>> links_; ///< by clusters, in the order of voxels
  cl::Buffer sums_;
};

}
