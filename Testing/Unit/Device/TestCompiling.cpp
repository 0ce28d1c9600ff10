#include "Scene.h"

namespace
{

using namespace chainmail;

TEST(Compiling, AWaitCanBeStopped)
{
  Scene scene({ 12, 12, 12 }, 0.2f);
  Simulation simulation =
    simulate(scene, { 4, 2, 16 }); // no other test has these bricks, so nothing is in the cache at first
  Probe probe;
  probe.position = scene.place(6, 6, 6);
  probe.displacement = { 0.5, 0.0, 0.0 };
  bool stops = false;
  simulation.setCompiling(
    [&]
    {
      stops = true;
      return false;
    });
  try
  {
    simulation.pull({ probe });
    EXPECT_FALSE(stops) << "the wait went on";
  }
  catch (const Aborted&)
  {
    EXPECT_TRUE(stops);
  }
  simulation.setCompiling(nullptr);
  simulation.pull({ probe });
  EXPECT_GT(simulation.measure().displaced, 0u);
}

}
