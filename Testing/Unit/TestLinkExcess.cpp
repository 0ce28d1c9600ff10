// The excess of links over their limits, which grows with the displacement in float32: README and Numerics.md have its
// bounds.

#include "RotationScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

struct Life
{
  double excess = 0.0;  ///< largest over the life, in fractions of the spacing
  double largest = 0.0; ///< largest displacement [spacings]
};

/// Tissue with bones. Two probes pull it by `far` voxels, and from each other by `apart` voxels, in steps; then it
/// relaxes.
Life live(double far, double apart, bool rotations, std::uint64_t seed)
{
  Scene scene = randomScene({ 13, 11, 9 }, 1, seed, 0.05, 0.05);
  scene.give(2, 5, 4, 0.2f);
  scene.give(10, 5, 4, 0.2f);
  for (const Index3& at : { Index3{ 2, 5, 4 }, Index3{ 10, 5, 4 } })
  {
    scene.scalar[scene.grid.at(at[0], at[1], at[2])] = 1.0f;
  }
  Settings settings;
  settings.device = testDevice();
  settings.rotations = rotations;
  Simulation simulation(scene.model(), settings);
  Life life;
  for (int step = 1; step <= 4; ++step)
  {
    const double s = far * step / 4.0;
    std::vector<Probe> probes{ probeAt(scene, { 2, 5, 4 }, { s, -0.7 * s, 0.3 * s }),
      probeAt(scene, { 10, 5, 4 }, { s + apart, -0.7 * s, 0.3 * s - 0.3 * apart }) };
    simulation.pull(probes);
    life.excess = std::max(life.excess, simulation.measure().maxLinkExcess);
    simulation.relax(10, 0.0);
    life.excess = std::max(life.excess, simulation.measure().maxLinkExcess);
    if (!rotations)
    {
      life.excess = std::max(life.excess, oracle::maxLinkExcess(scene.block(), state(simulation)));
    }
  }
  for (const oracle::Vector3& u : state(simulation))
  {
    for (const double one : u)
    {
      life.largest = std::max(life.largest, std::fabs(one));
    }
  }
  return life;
}

TEST(LinkExcess, GrowsWithTheDisplacement)
{
  const double unit = std::pow(2.0, -23); // a unit in the last place of 1
  for (const bool rotations : { false, true })
  {
    for (const double apart : { 1.0, 30.0 })
    {
      const bool agree = apart == 1.0;
      double worst = 0.0;
      for (const double far : { 10.0, 49.0, 1000.0, 3e5 })
      {
        SCOPED_TRACE(testing::Message() << "rotations " << rotations << ", apart " << apart << ", far " << far);
        double most = 0.0; // largest excess relative to the largest displacement
        for (std::uint64_t seed = 1; seed <= 3; ++seed)
        {
          const Life life = live(far, apart, rotations, seed);
          ASSERT_TRUE(life.largest >= far && life.largest < far + 3.0) << life.largest;
          most = std::max(most, life.excess / life.largest);
        }
        // An element gets the rounded sum of its neighbour's displacement and the limit: an error of half a unit. With
        // rotations the rest offset is a third term, which is rounded, too.
        const double rounding = (rotations ? 1.5 : 0.5) * unit;
        // Handles count as compatible up to this strain of a link (Waves.cpp).
        const double tolerance = agree ? 0.0 : 2e-6;
        EXPECT_LE(most, rounding + tolerance);
        EXPECT_GE(most, 0.2 * unit) << "nothing is rounded: a poor test";
        worst = std::max(worst, most);
      }
      std::printf("NUMERICS: link excess, %s, rotations %s | %.2g of the displacement\n",
        agree ? "probes agree" : "probes contradict each other", rotations ? "on" : "off", worst);
      // Both parts of the bound are reached.
      EXPECT_GE(worst, (agree ? 0.3 : 1.6) * unit);
    }
  }
}

}
