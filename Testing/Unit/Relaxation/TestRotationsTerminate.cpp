// Updates of rotating tissue terminate. Their number of iterations does not depend on the stiffness of the tissue or on
// the pull. Rounding once made loops of links that raised each other without end.

#include "RotationScene.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

constexpr double pi = 3.14159265358979323846;

/// The cost of an update in calls of the progress callback, which are between launches.
struct Progress
{
  explicit Progress(Simulation& simulation)
  {
    simulation.setProgress(
      [this](double)
      {
        ++this->calls;
        return this->calls < most;
      });
  }

  static constexpr int most = 20000; ///< an update without end is stopped, and its test fails
  int calls = 0;
};

/// Expects finite numbers, and links within their limits up to rounding: probes count as compatible up to 2e-6 of the
/// largest displacement (Waves.cpp), and displacements are rounded to 1.2e-7 of it.
void expectInOrder(const Simulation& simulation)
{
  float largest = 1.0f;
  for (const float part : displacements(simulation))
  {
    ASSERT_TRUE(std::isfinite(part));
    largest = std::max(largest, std::fabs(part));
  }
  const Statistics now = simulation.measure();
  ASSERT_TRUE(std::isfinite(now.energy));
  EXPECT_LE(now.maxLinkExcess, 3e-6 * largest);
}

// Limits from 1e-7 of the spacing on, and a pull of a hundred spacings, whose rounding is larger than such a limit.
TEST(RotationsTerminate, LimitsBelowRounding)
{
  for (const std::uint64_t seed : { 1, 2, 3 })
  {
    SCOPED_TRACE(seed);
    Scene scene({ 8, 9, 10 });
    Random random(seed);
    scene.each(
      [&](int i, int j, int k) { scene.give(i, j, k, static_cast<float>(std::pow(10.0, random(-7.0, -0.01)))); });
    Simulation simulation = simulateRotations(scene);
    Progress progress(simulation);
    std::vector<Probe> probes;
    for (int n = 0; n < 3; ++n)
    {
      probes.push_back(probeAt(scene, { random.below(8), random.below(9), random.below(10) }, {}));
    }
    for (int update = 0; update < 4; ++update)
    {
      for (Probe& probe : probes)
      {
        probe.displacement = { random(-100.0, 100.0), random(-100.0, 100.0), random(-100.0, 100.0) };
      }
      progress.calls = 0;
      ASSERT_NO_THROW(simulation.pull(probes)) << update;
      ASSERT_NO_THROW(simulation.relax(40, 1e-3)) << update;
      EXPECT_LT(progress.calls, 5000) << update;
      expectInOrder(simulation);
    }
  }
}

// Soft tissue with rigid voxels, dragged in circles beyond its limits, coarse to fine.
TEST(RotationsTerminate, CirclesBeyondWhatTissueAllows)
{
  for (const std::uint64_t seed : { 1, 2, 3 })
  {
    SCOPED_TRACE(seed);
    Scene scene({ 12, 11, 10 });
    Random random(seed);
    scene.each([&](int i, int j, int k) { scene.give(i, j, k, static_cast<float>(random(0.02, 0.6))); });
    for (int n = 0; n < 47; ++n)
    {
      scene.give(random.below(12), random.below(11), random.below(10), 0.0f);
    }
    scene.anchors.faces[4] = true;
    Simulation simulation = simulateRotations(scene);
    simulation.setCoarseToFine(true);
    Progress progress(simulation);
    Probe probe = probeAt(scene, { 6, 5, 8 }, {}, 1.1);
    for (int step = 1; step <= 24; ++step)
    {
      const double angle = step * pi / 6.0;
      probe.displacement = { 6.0 * std::sin(angle), 6.0 * (1.0 - std::cos(angle)), 2.0 * std::sin(2.0 * angle) };
      progress.calls = 0;
      ASSERT_NO_THROW(simulation.pull({ probe })) << step;
      ASSERT_NO_THROW(simulation.relax(40, 1e-3)) << step;
      EXPECT_LT(progress.calls, 5000) << step;
      expectInOrder(simulation);
    }
  }
}

// Probes pull again and again at bones that other tissue holds. Each wave may strain links by rounding, and the next
// wave adds to this: it once grew by 2e-6 with each update.
TEST(RotationsTerminate, WhatRoundingLeavesDoesNotGrow)
{
  for (const std::uint64_t seed : { 1, 2, 3, 4, 5, 6 })
  {
    SCOPED_TRACE(seed);
    Scene scene = randomScene({ 7, 7, 7 }, 1, seed, 0.03, 0.3);
    scene.anchors.faces[static_cast<int>(seed % 6)] = true;
    Simulation simulation = simulateRotations(scene);
    Random random(seed);
    Probe probe = probeAt(scene, randomElement(scene, random), {});
    for (int update = 0; update < 15; ++update)
    {
      probe.displacement = { random(-2.0, 2.0), random(-2.0, 2.0), random(-2.0, 2.0) };
      simulation.pull({ probe });
      simulation.relax(10, 0.0);
    }
    EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
  }
}

}
