// Which bricks have a state, and its memory.

#include "Scene.h"

namespace
{

using namespace chainmail;

TEST(States, MemoryFollowsTheTissueThatMoves)
{
  const Index3 size{ 160, 120, 120 };
  Grid grid;
  grid.size = size;
  const auto model = std::make_shared<const Model>(
    grid, 1, [](std::size_t, int count, float* out) { std::fill(out, out + count, 0.3f); });
  Settings settings;
  settings.brickSize = { 16, 8, 8 };
  Simulation simulation(model, settings);
  Probe probe;
  probe.position = { 80.0, 60.0, 60.0 };
  probe.displacement = { 12.0, 6.0, -3.0 };
  probe.radius = 3.0;
  simulation.pull({ probe });
  simulation.relax(20, 1e-3);
  const Statistics statistics = simulation.measure();
  EXPECT_GT(statistics.displaced, 250000u);
  // 12 bytes for each place of a brick with a state, 4 for each place of a brick with a slot. Pools have up to a
  // quarter more room to grow.
  EXPECT_LT(double(statistics.deviceBytes), 60.0 * double(statistics.displaced));
  EXPECT_GT(double(statistics.deviceBytes), 16.0 * double(statistics.displaced)) << "something is not counted";
}

}
