#pragma once

#include "Bricks.h"
#include "Elasticity.h"

#include <unordered_map>
#include <vector>

namespace chainmail
{

/// Connected sets of rigid elements, which relax as one unknown each (clusters.cl). Where constraints differ by axis,
/// so do clusters.
class RigidClusters
{
public:
  explicit RigidClusters(Bricks& bricks);

  /// Cluster of every voxel for one constraint axis, -1 where it is not rigid; numbered by first voxel. Returns their
  /// number.
  static int label(const Bricks& bricks, int axis, std::vector<int>& out);

  /// Which cluster of an axis a voxel belongs to; -1: none.
  int clusterOf(std::size_t voxel, int axis) const;

  /// These voxels (sorted) and all that hang on them rigidly along an image axis.
  std::vector<std::size_t> withClusters(const std::vector<std::size_t>& voxels, int axis) const;

  /// Starts a relaxation: no cluster is active; those that hold an anchor or one of these voxels (Grid::at) never are.
  void begin(const std::vector<std::size_t>& heldVoxels);

  /// Makes the clusters of these bricks take part from now on. Gives their bricks memory.
  void activate(const std::vector<int>& bricks);
  bool anyActive() const { return !this->chunkList_.empty(); }
  /// Bricks of clusters that could move, but do not take part.
  std::vector<int> inactiveBricks() const;

  /// Reads again where the active clusters are, after others than relax() have moved them.
  void refresh();

  /// The account of a turn (sweep.clh).
  struct Turn
  {
    const cl::Buffer& activity;
    const cl::Buffer& log;
    cl_int4 turn;
  };

  /// Launches their turn: one update of every active cluster.
  void relax(float omega, float still, const Elasticity& elasticity, const Turn& turn);

private:
  struct Cluster
  {
    int axis; ///< -1: all three
    std::size_t first;
    std::size_t count; ///< members: voxels_[first .. first + count)
    bool anchored;
    bool held;
    bool active;
    std::vector<int> bricks;
  };

  void upload();

  Bricks& bricks_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> voxels_;
  std::unordered_map<int, std::vector<int>> ofBrick_;
  std::vector<int> active_; ///< in the order of the device's lists

  std::vector<cl_int4> chunkList_;
  std::vector<cl_uint> linkList_;
  std::vector<cl_uint2> memberList_;
  std::vector<cl_int4> clusterList_;
  cl::Buffer chunks_;
  cl::Buffer links_;
  cl::Buffer members_;
  cl::Buffer heads_;
  cl::Buffer places_;
  cl::Buffer partial_;
  cl::Buffer moves_;
};

}
