// Arrival times in bricks whose memory is allocated while the times are computed.

#include "Scene.h"

#include <cmath>

namespace
{

using namespace chainmail;

// A chain with a cross section of one element, dragged sideways at one end, further in each scene. So the range of the
// wave, and of the elements linked to it, ends at every place of a brick, also where the memory of bricks has to grow.
TEST(ArrivalTimes, OfAChainAreItsLengthWhateverMemoryBricksHave)
{
  constexpr int length = 400;
  constexpr float limit = 0.125f; // a power of two, so times are exact
  for (int moved = 236; moved < 276; ++moved)
  {
    const Scene scene({ length, 1, 1 }, limit);
    Simulation simulation = simulate(scene, { 4, 2, 2 });
    simulation.setPropagationTimes(true);
    Probe probe;
    probe.position = scene.place(0, 0, 0);
    probe.displacement = { 0.0, limit * (moved - 0.5), 0.0 };
    simulation.pull({ probe });
    std::vector<float> times(length);
    std::vector<int> fronts(length);
    simulation.propagationTimes(times.data());
    simulation.wavefronts(fronts.data());
    for (int i = 0; i < length; ++i)
    {
      const bool isReached = i <= moved; // the last element did not move but is linked to a moved one
      ASSERT_EQ(times[i], isReached ? limit * static_cast<float>(i) : -1.0f) << moved << " moved, element " << i;
      ASSERT_EQ(fronts[i], isReached ? 1 : 0) << moved << " moved, element " << i;
    }
  }
}

}
