#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "SoftClusters.h"
#include "TurningClusters.h"

#include <unordered_map>
#include <vector>

namespace chainmail
{

/// Rigid clusters: connected sets of rigid elements, each of which relaxes as one unknown (clusters.cl). Where
/// constraints differ by axis, so do the clusters.
class RigidClusters
{
public:
  explicit RigidClusters(Bricks& bricks);

  /// Rigid voxels that follow each other along x, and that links join.
  struct Run
  {
    std::size_t first; ///< Grid::at
    std::uint32_t count;
    int cluster;
  };
  /// All runs for one axis of the constraint, in the order of voxels. Clusters are numbered by their first voxels.
  static std::vector<Run> runs(const Bricks& bricks, int axis);

  /// The cluster of an axis that a voxel belongs to; -1 where there is none.
  int clusterOf(std::size_t voxel, int axis) const;
  bool isAnchored(int cluster) const { return this->clusters_[cluster].anchored; }

  /// These voxels (ascending) and all members of their clusters along an image axis.
  std::vector<std::size_t> withClusters(const std::vector<std::size_t>& voxels, int axis) const;

  /// Visits the clusters of all axes, or those of x where they differ by axis, in the order of their first voxels, with
  /// their members: visit(first, last, whether it holds an anchor).
  template <typename Visit> void forClusters(const Visit& visit) const
  {
    for (std::size_t id = 0; id < this->clusters_.size() && this->clusters_[id].axis <= 0; ++id)
    {
      const auto first = this->voxels_.begin() + static_cast<std::ptrdiff_t>(this->clusters_[id].first);
      visit(first, first + static_cast<std::ptrdiff_t>(this->clusters_[id].count), this->clusters_[id].anchored);
    }
  }

  /// Starts a relaxation with no cluster taking part. Those that hold an anchor or one of these voxels (Grid::at) never
  /// will; where elements turn, a cluster may still turn about what it is held by (TurningClusters), but not one with
  /// elements of `turned`, whose rotation is prescribed.
  void begin(const std::vector<std::size_t>& heldVoxels, const std::vector<std::size_t>& turned = {});

  /// Where elements turn: makes every cluster rigid again whose elements were moved one by one, with the pose nearest
  /// to where they are now or, unless they `turn`, the nearest one with the spins they have. Elements of probes stay
  /// where they are, and so do clusters that hold an anchor.
  void straighten(bool turn = true);

  /// Makes the clusters of these bricks take part from now on. Gives memory to all bricks of these clusters.
  void activate(const std::vector<int>& bricks);
  bool anyActive() const { return !this->active_.empty() && (!this->chunkList_.empty() || this->soft_.any()); }
  /// Bricks of the clusters that could move but do not take part yet.
  std::vector<int> inactiveBricks() const;

  /// Reads the places of the active clusters again, after anything but relax() has moved them.
  void refresh();

  /// What kernels need of the active clusters: how many chunks, clusters and members there are, and CLUSTER_LISTS of
  /// cluster.clh.
  auto lists() const
  {
    const auto orNone = [this](const cl::Buffer& list) -> const cl::Buffer&
    { return this->anyActive() ? list : this->bricks_.constraint; }; // of 0 entries nothing is read
    return std::tuple_cat(
      std::tuple<cl_int4>({ { static_cast<cl_int>(this->chunkList_.size()), static_cast<cl_int>(this->active_.size()),
        static_cast<cl_int>(this->memberList_.size()), 0 } }),
      std::tie(orNone(this->chunks_), orNone(this->links_), orNone(this->ways_), orNone(this->heads_),
        orNone(this->members_), orNone(this->partial_), orNone(this->places_), orNone(this->moves_)));
  }

  /// What soft links pull the active clusters with (cluster.clh); null where there are none.
  const cl::Buffer* softList() const { return this->soft_.list(); }

  using Turn = TurningClusters::Turn;

  /// Launches the third colour pass: one update of every active cluster.
  void relax(float omega, float still, const Elasticity& elasticity, const Turn& turn);

private:
  struct Cluster
  {
    int axis; ///< -1 for all three
    std::size_t first;
    std::size_t count; ///< members: voxels_[first .. first + count)
    bool anchored;
    bool held; ///< so that it can neither move nor turn
    bool active;
    std::vector<std::size_t> heldVoxels; ///< where elements turn
    std::vector<int> bricks;
  };

  /// Whether clusters turn. Where constraints differ by axis, a cluster of one axis has no rotation.
  bool turns() const { return this->bricks_.spins() && this->bricks_.model().axes() == 1; }
  TurningClusters::Body bodyOf(const Cluster& cluster) const;
  std::vector<std::uint32_t> addressesOf(const Cluster& cluster) const;
  void alignAxis(const Cluster& cluster);
  std::vector<int> bricksLinkedTo(const std::vector<int>& clusters) const;
  void list();
  void upload();

  Bricks& bricks_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> voxels_;
  std::unordered_map<int, std::vector<int>> ofBrick_;
  std::vector<int> active_; ///< cluster numbers, in the order of the device's lists
  std::vector<int> listed_; ///< what these lists hold, also when nothing is active

  SoftClusters soft_;
  TurningClusters turning_; ///< where elements turn
  std::vector<TurningClusters::Body> bodyList_;
  std::vector<cl_uchar> wayList_;

  std::vector<cl_int4> chunkList_;
  std::vector<cl_uint> linkList_;
  std::vector<cl_uint2> memberList_;
  std::vector<cl_int4> clusterList_;
  cl::Buffer chunks_;
  cl::Buffer links_;
  cl::Buffer ways_;
  cl::Buffer members_;
  cl::Buffer heads_;
  cl::Buffer places_;
  cl::Buffer partial_;
  cl::Buffer moves_;
};

}
