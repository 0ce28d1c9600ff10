#pragma once

#include "Bricks.h"
#include "RotatingClusters.h"

#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The sums of the soft links of each rigid cluster's members. All members move together, so a few numbers per cluster
/// give the energy of any number of links (cluster.clh, rotatingclusters.cl).
class SoftClusters
{
public:
  explicit SoftClusters(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  /// Starts a relaxation: finds the clusters that have soft links. `visit(voxel, f)` calls f(cluster) for each cluster
  /// that contains the voxel.
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

  /// Uploads the sums of the active clusters. `bodies`: the body of each of them where clusters rotate, else empty.
  void upload(const std::vector<int>& clusters, const std::vector<RotatingClusters::Body>& bodies);

  bool any() const { return !this->links_.empty(); }
  /// The sums, as a kernel argument; null without soft links.
  const cl::Buffer* list() const { return this->bricks_.softLinks() ? &this->sums_ : nullptr; }

private:
  Bricks& bricks_;
  std::unordered_map<int, std::vector<const SoftLink*>> links_; ///< by cluster, in the order of voxels
  cl::Buffer sums_;
};

}
