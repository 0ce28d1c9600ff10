#pragma once

#include "Propagation.h"
#include "RigidClusters.h"
#include "Simulation.h"

namespace chainmail
{

/// Three-colour projected over-relaxation (relax.cl, clusters.cl): red elements, black elements, rigid clusters.
///
/// Only bricks in which something can change are visited. That is exact: an element stays put, to the bit, when neither
/// it nor a neighbour moved since its last turn, so the result does not depend on the size of the bricks.
class Relaxation
{
public:
  explicit Relaxation(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  RelaxResult run(RigidClusters& clusters, int firstSweep, int iterations, double tolerance,
    const std::function<void(int)>& checkpoint);

private:
  struct Activity
  {
    int any = -1000;                                                         ///< turn in which an element last moved
    std::array<int, 6> face{ { -1000, -1000, -1000, -1000, -1000, -1000 } }; ///< one that touches this face
  };

  std::vector<int> pending();
  float relaxColour(int colour, float omega, float still);
  void note(int slot, int faces);

  Bricks& bricks_;
  std::vector<Activity> activity_;
  int turn_ = 0;
  Scratch list_{ "the list of active bricks" };
  Scratch result_{ "the list of active bricks" };
};

}
