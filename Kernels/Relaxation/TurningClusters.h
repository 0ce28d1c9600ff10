#pragma once

#include "Bricks.h"
#include "Elasticity.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// The places and rotations of rigid clusters in a relaxation in which elements turn (turnclusters.cl).
class TurningClusters
{
public:
  explicit TurningClusters(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  /// What a cluster is free to do.
  enum class Freedom
  {
    All,   ///< to move and to turn
    Ball,  ///< to turn about the one element that is held
    Hinge, ///< to turn about the axis on which all elements lie that are held
    None
  };

  /// A cluster: what it is free to do, and about what.
  struct Body
  {
    Freedom freedom = Freedom::All;
    Vector3 middle{};       ///< what its pose is counted from [indices]: the place of `member`
    double radius = 0.0;    ///< of the ball about the middle that holds it [mean spacings]
    Vector3 axis{};         ///< of a hinge, at rest, of length 1 [mm]
    std::size_t member = 0; ///< the element that tells where it is (Grid::at): one that is held, or the middle one. An
                            ///< element gives back the pose that it was given, to the bit.
  };

  /// The body of a cluster of which these elements are held.
  static Body bodyOf(const Bricks& bricks, const std::uint32_t* members, std::size_t count,
    const std::vector<std::size_t>& held, bool anchored);

  /// Gives the elements of a cluster the pose of a rigid body that is nearest to where they are now; unless it `turns`,
  /// with the spin they have. Those that are held stay. `places` and `spins` have 3 values a member.
  static void straighten(const Bricks& bricks, const std::uint32_t* members, std::size_t count, const Body& body,
    bool anchored, const std::vector<std::size_t>& held, bool turns, float* places, float* spins);

  /// Takes these clusters, in the order of the lists of RigidClusters.
  void upload(const std::vector<Body>& bodies, std::size_t chunks);
  /// Reads the poses of the clusters from their members again.
  void refresh();

  /// What turns: the lists of RigidClusters on the device.
  struct Lists
  {
    const cl::Buffer& chunks;
    std::size_t chunkCount;
    const cl::Buffer& links;
    std::size_t linkCount;
    const cl::Buffer& ways; ///< the directions of links
    const cl::Buffer& heads;
    const cl::Buffer& members;
    std::size_t memberCount;
  };
  /// The arguments that sweep.clh needs for one turn.
  struct Turn
  {
    const cl::Buffer& activity;
    const cl::Buffer& log;
    cl_int4 turn;
  };
  /// Launches one update of every cluster. `soft`: what soft links pull them with (SoftClusters), or null.
  void relax(const Lists& lists, const cl::Buffer* soft, float omega, float still, bool limited, const Turn& turn);

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
