#pragma once

#include "Bricks.h"
#include "Elasticity.h"
#include "SweepSchedule.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// The places and rotations of rigid clusters in a relaxation in which elements rotate (rotatingclusters.cl).
class RotatingClusters
{
public:
  explicit RotatingClusters(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  /// The degrees of freedom of a cluster.
  enum class Freedom
  {
    All,   ///< moves and rotates
    Ball,  ///< rotates about its only held element
    Hinge, ///< rotates about the axis through all its held elements
    None
  };

  /// A cluster: its degrees of freedom and its reference element.
  struct Body
  {
    Freedom freedom = Freedom::All;
    Vector3 middle{};       ///< reference point of its pose [indices]: the place of `member`
    double radius = 0.0;    ///< of a ball about `middle` that contains the cluster [mean spacings]
    Vector3 axis{};         ///< direction of a hinge at rest, of length 1 [mm]
    std::size_t member = 0; ///< reference element (Grid::at), a held one or else the one nearest to the centre.
                            ///< Its state is the pose of the cluster, to the bit.
  };

  /// The body of a cluster with these held elements.
  static Body bodyOf(const Bricks& bricks, const std::uint32_t* members, std::size_t count,
    const std::vector<std::size_t>& held, bool anchored);

  /// Projects the elements of a cluster to the nearest rigid motion (least squares). Without `rotates`, or with a
  /// freedom other than All or Ball, it keeps the current rotation of Body::member. Held elements keep their places,
  /// and an anchored cluster is at rest. `places` and `rotations`: displacements and rotations, 3 values per member.
  static void projectToRigid(const Bricks& bricks, const std::uint32_t* members, std::size_t count, const Body& body,
    bool anchored, const std::vector<std::size_t>& held, bool rotates, float* places, float* rotations);

  /// Uploads these clusters, in the order of the lists of RigidClusters. `chunks`: the number of chunks.
  void upload(const std::vector<Body>& bodies, std::size_t chunks);
  /// Reads the poses of the clusters from their reference elements again.
  void refresh();

  /// The lists of RigidClusters on the device (cluster.clh).
  struct Lists
  {
    const cl::Buffer& chunks;
    std::size_t chunkCount;
    const cl::Buffer& links;
    std::size_t linkCount;
    const cl::Buffer& directions;
    const cl::Buffer& heads;
    const cl::Buffer& members;
    std::size_t memberCount;
    const cl::Buffer* soft; ///< the sums of the soft links of clusters (SoftClusters); null without soft links
  };
  /// Launches one update of every cluster.
  void relax(const Lists& lists, float omega, float still, bool limited, const PassArguments& pass);

private:
  Bricks& bricks_;
  std::vector<Body> list_;
  cl::Buffer bodies_;
  cl::Buffer poses_;
  cl::Buffer ends_;
  cl::Buffer steps_;
  cl::Buffer sums_;
  cl::Buffer bounds_;
  cl::Buffer checks_;
  cl::Buffer moves_;
};

}
