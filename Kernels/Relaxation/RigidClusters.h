#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "Elements.h"
#include "RotatingClusters.h"
#include "SoftClusters.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// Rigid clusters: connected sets of rigid elements. Each cluster relaxes as one unknown (clusters.cl). Where
/// constraints differ by axis, each axis has its own clusters.
class RigidClusters
{
public:
  explicit RigidClusters(Bricks& bricks);

  /// The cluster of an axis that a voxel belongs to; -1 if there is none.
  int clusterOf(std::size_t voxel, int axis) const;
  bool isAnchored(int cluster) const { return this->clusters_[cluster].anchored; }
  /// Whether there is a cluster without an anchor.
  bool anyFree() const
  {
    return std::any_of(
      this->clusters_.begin(), this->clusters_.end(), [](const Cluster& cluster) { return !cluster.anchored; });
  }

  /// These voxels (ascending) and all members of their clusters for an image axis; ascending.
  std::vector<std::size_t> withClusters(const std::vector<std::size_t>& voxels, int axis) const;

  /// Calls visit(first, last, anchored) for each cluster, in the order of their first voxels: the range of its members,
  /// and whether one of them is an anchor. Where clusters differ by axis, only those of x are visited.
  template <typename Visit> void forClusters(const Visit& visit) const
  {
    for (std::size_t id = 0; id < this->clusters_.size() && this->clusters_[id].axis <= 0; ++id)
    {
      const auto first = this->voxels_.begin() + static_cast<std::ptrdiff_t>(this->clusters_[id].first);
      visit(first, first + static_cast<std::ptrdiff_t>(this->clusters_[id].count), this->clusters_[id].anchored);
    }
  }

  /// Starts a relaxation with all clusters inactive. A cluster that contains an anchor or one of `heldVoxels`
  /// (Grid::at) cannot become active, with one exception: where elements rotate, a cluster without an anchor may rotate
  /// about its held elements (RotatingClusters). A cluster with elements of `rotated` may not, because their rotation
  /// is prescribed.
  void begin(const std::vector<std::size_t>& heldVoxels, const std::vector<std::size_t>& rotated = {});
  /// Starts the relaxation of a correction (correction.cl), where elements do not rotate. Where `residual` is INFINITY
  /// along x, elements are fixed. A cluster with a fixed member cannot become active either, and where constraints
  /// differ by axis none can. Fixes all members of clusters that cannot. The soft links of the others are read again.
  void beginCorrection(const std::vector<std::size_t>& heldVoxels, const Field& residual);

  /// Where elements rotate: projects every displaced cluster to a rigid motion, after its elements were moved one by
  /// one. This is the pose nearest to the current places or, without `rotates`, the nearest one with the current
  /// rotation. Elements held by probes keep their places; clusters with an anchor are at rest.
  void projectToRigid(bool rotates = true);

  /// Activates the clusters of these bricks and makes all bricks of these clusters updatable.
  void activate(const std::vector<int>& bricks);
  bool anyActive() const { return !this->active_.empty() && (!this->chunkList_.empty() || this->soft_.any()); }
  /// Bricks of inactive clusters that could move.
  std::vector<int> inactiveBricks() const;

  /// Reads the places of the active clusters again, after anything except relax() has moved them.
  void refresh();

  /// CLUSTERS_ARGUMENTS of cluster.clh for the active clusters.
  auto arguments() const
  {
    const auto orNone = [this](const cl::Buffer& list) -> const cl::Buffer&
    { return this->anyActive() ? list : this->bricks_.constraint(); }; // empty lists are not read
    return std::tuple_cat(
      std::tie(orNone(this->chunks_), orNone(this->links_), orNone(this->directions_), orNone(this->heads_),
        orNone(this->members_), orNone(this->partial_), orNone(this->places_), orNone(this->moves_)),
      std::make_tuple(this->soft_.list()));
  }
  /// The numbers of chunks, clusters and members.
  cl_int4 counts() const
  {
    return { { static_cast<cl_int>(this->chunkList_.size()), static_cast<cl_int>(this->active_.size()),
      static_cast<cl_int>(this->memberList_.size()), 0 } };
  }

  /// Launches the third colour pass: one update of every active cluster.
  void relax(float omega, float still, const Elasticity& elasticity, const PassArguments& pass);

private:
  struct Cluster
  {
    int axis; ///< -1 for all three
    std::size_t first;
    std::size_t count; ///< members: voxels_[first .. first + count)
    bool anchored;
    bool held; ///< whether it can neither move nor rotate
    bool active;
    std::vector<std::size_t> heldVoxels; ///< its members that are held by probes, Grid::at
    std::vector<int> bricks;
  };

  /// Whether clusters rotate. Where constraints differ by axis, a cluster of one axis has no rotation.
  bool clustersRotate() const { return this->bricks_.rotations() && this->bricks_.model().axes() == 1; }
  RotatingClusters::Body bodyOf(const Cluster& cluster) const;
  void addMembers(const Cluster& cluster, Elements& elements) const;
  Elements membersOf(const std::vector<int>& clusters) const;
  void beginSoft();
  void alignAxis(const Cluster& cluster);
  std::vector<int> bricksLinkedTo(const std::vector<int>& clusters) const;
  void list();
  void upload();

  Bricks& bricks_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> voxels_;
  std::unordered_map<int, std::vector<int>> ofBrick_;
  std::vector<int> active_; ///< cluster numbers, in the order of the device's lists
  std::vector<int> listed_; ///< the clusters in these lists, also when none is active

  SoftClusters soft_;
  RotatingClusters rotating_; ///< where elements rotate
  std::vector<RotatingClusters::Body> bodyList_;
  std::vector<cl_uchar> directionList_;

  std::vector<cl_int4> chunkList_;
  std::vector<cl_uint> linkList_;
  std::vector<cl_uint2> memberList_;
  std::vector<cl_int4> clusterList_;
  cl::Buffer chunks_;
  cl::Buffer links_;
  cl::Buffer directions_;
  cl::Buffer members_;
  cl::Buffer heads_;
  cl::Buffer places_;
  cl::Buffer partial_;
  cl::Buffer moves_;
};

}
