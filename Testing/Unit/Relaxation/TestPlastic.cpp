// Elastoplastic tissue: strain up to (1 - r) of a link's limit has no energy. Against the certified optimum of the
// convex problem, and curves of loading and unloading.

#include "Inclusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{

using namespace chainmail;

Simulation plastic(const Scene& scene, double recovery, const Index3& brick = { 0, 0, 0 })
{
  Simulation simulation = simulate(scene, brick);
  simulation.setRelaxation(RelaxationMethod::Projected, recovery);
  return simulation;
}

oracle::Block plasticBlock(const Scene& scene, double recovery)
{
  oracle::Block block = scene.block();
  block.slack = 1.0 - recovery;
  return block;
}

/// Engine and oracle on the same block after the same pull. The optimal state is not unique, its energy is.
void expectOptimum(const Scene& scene, double recovery, const Vector3& shares, const char* what)
{
  SCOPED_TRACE(what);
  SCOPED_TRACE(recovery);
  const oracle::Block block = plasticBlock(scene, recovery);
  const Probe probe = pullBy(scene, shares);
  Simulation simulation = plastic(scene, recovery);
  simulation.pull({ probe });
  const std::vector<oracle::Vector3> pulled = state(simulation);
  std::vector<char> held = block.anchored;
  const std::size_t grabbed = handles(block, { probe })[0].elements[0];
  held[grabbed] = 1;
  const oracle::Optimum best = oracle::minimise(block, held, pulled);
  ASSERT_LT(best.gap(), 1e-5) << "the oracle has no proof";
  ASSERT_GT(best.gap(), -1e-6) << "the oracle has a wrong proof";
  ASSERT_GT(oracle::energy(block, pulled), 1.5 * best.energy) << "nothing to relax: a poor test";
  EXPECT_NEAR(simulation.measure().energy, oracle::energy(block, pulled), 1e-4 * oracle::energy(block, pulled));

  simulation.relax(3000, 0.0);
  const std::vector<oracle::Vector3> relaxed = state(simulation);
  const double energy = oracle::energy(block, relaxed);
  // At most 0.1 % above the optimum. Below the proven bound only by the float32 excess of links.
  EXPECT_LT(energy, 1.001 * best.energy);
  EXPECT_GT(energy, 0.9999 * best.bound);
  EXPECT_NEAR(simulation.measure().energy, energy, 1e-4 * energy);
  EXPECT_LE(oracle::maxLinkExcess(block, relaxed), 1e-5);
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_EQ(relaxed[grabbed][a], pulled[grabbed][a]); // held
  }
}

TEST(Plastic, ReachesTheConstrainedOptimum)
{
  const Scene scene = cornerScene(14, 1, 111);
  expectOptimum(scene, 0.95, { 0.9, 0.7, -0.5 }, "large pull");
  expectOptimum(scene, 0.8, { 0.4, -0.5, 0.6 }, "small pull");
  expectOptimum(scene, 0.8, { 0.9, 0.7, -0.5 }, "large pull");
  expectOptimum(scene, 0.5, { 0.9, 0.7, -0.6 }, "large pull");
  expectOptimum(scene, 0.2, { 0.95, 0.9, -0.9 }, "large pull");
}

TEST(Plastic, ReachesTheOptimumOfAnisotropicTissueAndSpacing)
{
  Scene scene = cornerScene(12, 3, 12);
  scene.grid.spacing = { 0.6, 1.0, 2.5 };
  expectOptimum(scene, 0.8, { 0.5, -0.6, 0.9 }, "pull");
}

// Chains of links at their limits, which only move together, in tissue where most other links have no energy.
TEST(Plastic, ReachesTheOptimumWhereChainsOfLinksAreAtTheirLimits)
{
  for (const int seed : { 1000, 1004 })
  {
    SCOPED_TRACE(seed);
    const Scene scene = cornerScene(12, 1, seed);
    expectOptimum(scene, 0.8, { 0.95, -0.9, 0.99 }, "near the limit");
  }
}

TEST(Plastic, EnergyNeverRisesAndEverySweepIsFeasible)
{
  for (const double recovery : { 0.9, 0.4, 0.0 })
  {
    for (const int axes : { 1, 3 })
    {
      SCOPED_TRACE(recovery);
      const Scene scene = cornerScene(14, axes, 20 + axes);
      const oracle::Block block = plasticBlock(scene, recovery);
      Simulation simulation = plastic(scene, recovery);
      for (const Vector3& shares : { Vector3{ 0.3, 0.2, -0.2 }, Vector3{ 0.97, -0.9, 0.99 }, Vector3{} })
      {
        simulation.pull({ pullBy(scene, shares) });
        double before = oracle::energy(block, state(simulation));
        // Single sweeps, then longer calls, within which omega rises and blocked groups are solved.
        for (int call = 0; call < 40; ++call)
        {
          simulation.relax(call < 30 ? 1 : 20, 0.0);
          const std::vector<oracle::Vector3> now = state(simulation);
          const double energy = oracle::energy(block, now);
          // Rounding of a sum of thousands of links, and of the strain of links near the edge of the slack, whose
          // energy is the square of 1e-7.
          ASSERT_LE(energy, before * (1.0 + 1e-6) + 1e-9) << "call " << call;
          ASSERT_LE(oracle::maxLinkExcess(block, now), 1e-5) << "call " << call;
          before = energy;
        }
      }
    }
  }
}

// r = 1 is the elastic tissue of all other tests, and the default. Slack so small that it rounds to 0 uses the other
// path of the kernels and gives the same bits.
TEST(Plastic, FullRecoveryIsElasticToTheBit)
{
  const Scene scene = cornerScene(13, 1, 31);
  const auto relaxed = [&](double recovery)
  {
    Simulation simulation = simulate(scene);
    if (recovery >= 0.0)
    {
      simulation.setRelaxation(RelaxationMethod::Projected, recovery);
    }
    simulation.pull({ pullBy(scene, { 0.9, -0.8, 0.5 }) });
    simulation.relax(60, 1e-4);
    return displacements(simulation);
  };
  const std::vector<float> elastic = relaxed(-1.0);
  EXPECT_TRUE(sameBits(relaxed(1.0), elastic));
  const std::vector<float> nearly = relaxed(1.0 - std::numeric_limits<double>::epsilon());
  for (std::size_t n = 0; n < elastic.size(); ++n)
  {
    ASSERT_NEAR(nearly[n], elastic[n], 1e-6f);
  }
}

// r = 0: within the limits there are no forces. The state after the wave remains, to the bit.
TEST(Plastic, WithoutRecoveryTissueStaysWhereItIs)
{
  const Scene scene = cornerScene(14, 1, 32);
  Simulation simulation = plastic(scene, 0.0);
  simulation.pull({ pullBy(scene, { 0.9, -0.5, 0.7 }) });
  const std::vector<float> pulled = displacements(simulation);
  EXPECT_LT(simulation.measure().energy, 1e-9);
  const ProbeResult probe = simulation.probes().front();
  for (const double force : probe.force)
  {
    EXPECT_LT(std::abs(force), 1e-4); // rounding of links at their limits; the force of elastic tissue is about 5
  }
  for (const bool released : { false, true })
  {
    const RelaxResult result = simulation.relax(50, 1e-3);
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.iterations, 1);
    EXPECT_TRUE(sameBits(displacements(simulation), pulled));
    if (!released)
    {
      simulation.pull({});
    }
  }
}

TEST(Plastic, BitsDoNotDependOnBricks)
{
  for (const int axes : { 1, 3 })
  {
    const Scene scene = cornerScene(21, axes, 50 + axes);
    std::vector<float> first;
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = plastic(scene, 0.8, brick);
      simulation.pull({ corner(scene, { 1.9, -2.3, 1.1 }) });
      simulation.relax(7, 0.0);
      simulation.relax(40, 1e-4);
      const std::vector<float> u = displacements(simulation);
      first = first.empty() ? u : first;
      EXPECT_TRUE(sameBits(u, first)) << axes << " axes, brick " << brick[0] << ' ' << brick[1] << ' ' << brick[2];
    }
  }
}

// By the envelope theorem the force is the derivative of the optimum's energy; here of the oracle's optimum.
TEST(Plastic, ForceIsTheGradientOfTheRelaxedEnergy)
{
  Scene scene = cornerScene(8, 1, 80);
  scene.grid.spacing = { 1.0, 0.5, 2.0 };
  const oracle::Block block = plasticBlock(scene, 0.8);
  std::vector<char> held = block.anchored;
  const std::size_t grabbed = handles(block, { corner(scene, {}) })[0].elements[0];
  held[grabbed] = 1;
  // So short that the relaxed tissue reaches no limit.
  const Vector3 reach = reachOfCorner(scene);
  const oracle::Vector3 place{ 0.35 * reach[0], -0.4 * reach[1], 0.45 * reach[2] };
  const auto energyAt = [&](int axis, double factor)
  {
    std::vector<oracle::Vector3> start(block.count());
    start[grabbed] = place;
    start[grabbed][axis] *= factor;
    const oracle::Optimum best = oracle::minimise(block, held, start, 1e-9);
    EXPECT_LT(best.gap(), 1e-7);
    return best.energy;
  };
  Simulation simulation = plastic(scene, 0.8);
  Vector3 displacement;
  for (int a = 0; a < 3; ++a)
  {
    displacement[a] = place[a] * scene.grid.spacing[a];
  }
  simulation.pull({ corner(scene, displacement) });
  simulation.relax(6000, 0.0);
  const Vector3 force = simulation.probes()[0].force;
  for (int a = 0; a < 3; ++a)
  {
    const double slope = (energyAt(a, 1.02) - energyAt(a, 0.98)) / (0.04 * displacement[a]);
    // 1 % for the third derivative at the edge of the slack, and for the error of sweeps in float32.
    EXPECT_NEAR(force[a], slope, 0.01 * std::abs(slope)) << a;
    EXPECT_GT(std::abs(slope), 0.05) << "no force: a poor test";
    EXPECT_GT(force[a] * place[a], 0.0) << "the handle pulls outwards";
  }
}

/// A bar of uneven tissue, anchored at its left end, with a handle around its right end.
struct Bar
{
  static constexpr int length = 12;
  Scene scene{ { length, 5, 5 } };
  double reach = 0.0; ///< largest displacement of the right end along x: the shortest path of limits from the anchored
                      ///< end to any of its elements
  double distance = 0.0; ///< the shortest path to the middle of it

  Bar()
  {
    Random random(90);
    for (float& c : this->scene.constraint)
    {
      c = static_cast<float>(random(0.15, 0.35));
    }
    this->scene.anchors.faces[0] = true;
    const oracle::Block block = this->scene.block();
    const oracle::Handle handle = handles(block, { this->grip(0.0) })[0];
    EXPECT_EQ(handle.elements.size(), 25u) << "the handle holds the whole end";
    std::vector<std::pair<std::size_t, double>> anchored;
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (block.anchored[v])
      {
        anchored.push_back({ v, 0.0 });
      }
    }
    const std::vector<double> distances = oracle::shortest(block, 0, anchored);
    this->distance = distances[this->end()];
    this->reach = this->distance;
    for (const std::size_t v : handle.elements)
    {
      this->reach = std::min(this->reach, distances[v]);
    }
  }

  /// The same handle with a share of its largest displacement along x.
  Probe grip(double share) const
  {
    // A ball that contains the corners of the end but not the middle of the layer before it.
    Probe probe = probeAt(this->scene, { length + 5, 2, 2 }, { share * this->reach, 0.0, 0.0 });
    probe.radius = std::sqrt(6.0 * 6.0 + 2.0 * 2.0 + 2.0 * 2.0) + 1e-3;
    return probe;
  }

  std::size_t end() const { return this->scene.grid.at(length - 1, 2, 2); }
  double displacementOfEnd(const Simulation& simulation) const { return state(simulation)[this->end()][0]; }
};

/// Force at the handle along x after relaxation, for a sequence of displacements given as shares of the largest one.
std::vector<double> forces(Simulation& simulation, const Bar& bar, const std::vector<double>& shares)
{
  std::vector<double> result;
  for (const double share : shares)
  {
    simulation.pull({ bar.grip(share) });
    simulation.relax(2500, 0.0);
    result.push_back(simulation.probes()[0].force[0]);
  }
  return result;
}

const std::vector<double> loading{ 0.0, 0.06, 0.12, 0.18, 0.3, 0.45, 0.6, 0.75 };

// The relaxed energy is the minimum of a convex problem, so it depends on the handle's place alone. So does its
// derivative, the force. Loading and unloading give the same curve for every recovery, elastic or not. The curves
// differ in their start: while some state keeps every link within its slack there is no force. By the Lipschitz
// extension there is such a state exactly up to slack times the largest displacement.
TEST(Plastic, LoadingAndUnloadingAreOneCurveThatBeginsAtTheSlack)
{
  const Bar bar;
  std::vector<double> elastic;
  for (const double recovery : { 1.0, 0.8 })
  {
    SCOPED_TRACE(recovery);
    Simulation simulation = plastic(bar.scene, recovery);
    const std::vector<double> up = forces(simulation, bar, loading);
    std::vector<double> down = forces(simulation, bar, std::vector<double>(loading.rbegin(), loading.rend()));
    std::reverse(down.begin(), down.end());
    const double largest = up.back();
    ASSERT_GT(largest, 1.0);
    for (std::size_t n = 0; n < loading.size(); ++n)
    {
      // The error after 2500 sweeps.
      EXPECT_NEAR(up[n], down[n], 2e-3 * largest) << loading[n];
      if (n > 0)
      {
        EXPECT_GT(up[n], up[n - 1] - 1e-3 * largest) << loading[n];
        EXPECT_GT(down[n], down[n - 1] - 1e-3 * largest) << loading[n];
      }
      if (loading[n] < 1.0 - recovery)
      {
        EXPECT_NEAR(up[n], 0.0, 1e-3 * largest) << loading[n];
        EXPECT_NEAR(down[n], 0.0, 1e-3 * largest) << loading[n];
      }
      else if (loading[n] > 1.0 - recovery)
      {
        EXPECT_GT(up[n], up[n - 1] + 0.03 * largest) << loading[n];
        EXPECT_GT(down[n], 0.03 * largest) << loading[n];
      }
      // The force of elastic tissue with the same limits is always larger.
      if (recovery < 1.0 && loading[n] > 0.0)
      {
        EXPECT_LT(down[n], elastic[n]) << loading[n];
      }
    }
    elastic = up;
  }
}

// The tissue has a memory. Released elastic tissue returns to rest; at 80 % recovery each link keeps up to a fifth of
// its limit. A further pull from there has a force at once, unlike in tissue that was never pulled.
TEST(Plastic, ReleasedTissueKeepsItsShareOfStrain)
{
  const Bar bar;
  for (const double recovery : { 1.0, 0.8, 0.5 })
  {
    SCOPED_TRACE(recovery);
    const double slack = 1.0 - recovery;
    Simulation simulation = plastic(bar.scene, recovery);
    const double largest = forces(simulation, bar, { 0.3, 0.75 }).back();
    simulation.pull({});
    simulation.relax(6000, 0.0);
    const double kept = bar.displacementOfEnd(simulation);
    const std::vector<oracle::Vector3> u = state(simulation);
    const oracle::Block block = bar.scene.block();
    double widest = 0.0; // strain along x as a share of its limit
    for (const oracle::Link& link : oracle::links(block))
    {
      widest = std::max(widest, std::abs(u[link.from][0] - u[link.to][0]) / oracle::limit(block, link, 0));
    }
    EXPECT_LT(widest, slack + 2e-3);
    EXPECT_GT(widest, slack - 1e-3);
    // The end stays at the distance of the shortest path from the anchor.
    EXPECT_LT(kept, slack * bar.distance + 1e-3);
    EXPECT_GT(kept, 0.9 * slack * bar.distance - 1e-3);
    EXPECT_LT(simulation.measure().energy, 1e-4);

    if (recovery < 1.0)
    {
      Simulation fresh = plastic(bar.scene, recovery);
      const double again = forces(simulation, bar, { 0.1 }).back();
      EXPECT_NEAR(bar.displacementOfEnd(simulation), kept + 0.1 * bar.reach, 1e-5) << "from where it was grabbed";
      const double first = forces(fresh, bar, { 0.1 }).back();
      EXPECT_NEAR(first, 0.0, 1e-3 * largest);
      EXPECT_GT(again, 0.05 * largest);
    }
  }
}

TEST(Plastic, RecoveryMustBeAShare)
{
  const Scene scene = cornerScene(10, 1, 33);
  Simulation simulation = plastic(scene, 0.8);
  simulation.pull({ pullBy(scene, { 0.9, -0.5, 0.7 }) });
  const double energy = simulation.measure().energy;
  for (const double wrong : { -0.01, 1.01, std::numeric_limits<double>::quiet_NaN() })
  {
    const std::string message =
      messageOf<InputError>([&] { simulation.setRelaxation(RelaxationMethod::Paper, wrong); });
    EXPECT_TRUE(contains(message, "recovery")) << message;
    EXPECT_EQ(simulation.measure().energy, energy);
  }
  simulation.setRelaxation(RelaxationMethod::Projected, 1.0);
  EXPECT_GT(simulation.measure().energy, energy);
}

}
