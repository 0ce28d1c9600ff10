// Random pulls in scans, with the materials of the filter's presets. After 20 sweeps on the finest grid, the energy
// with coarser grids is at most that without. After 40 sweeps short pulls have nearly converged either way, and the
// fine grid alone may be better: in 3 of 166 pulls, by at most 1.2 %.
//
// CHAINMAIL_PULLS is the number of pulls in each scan, instead of a few.

#include "Scans.h"
#include "Scene.h"

#include <cmath>
#include <iostream>
#include <limits>

namespace
{

using namespace chainmail;

using Nodes = std::vector<std::array<double, 2>>; // scalar, constraint

double constraintAt(const Nodes& nodes, double scalar)
{
  for (std::size_t n = 0; n < nodes.size(); ++n)
  {
    if (scalar <= nodes[n][0])
    {
      const double share = n == 0 ? 1.0 : (scalar - nodes[n - 1][0]) / (nodes[n][0] - nodes[n - 1][0]);
      return n == 0 ? nodes[0][1] : nodes[n - 1][1] + share * (nodes[n][1] - nodes[n - 1][1]);
    }
  }
  return nodes.back()[1];
}

/// A handle with a radius of some millimetres and a displacement of some millimetres to centimetres. Many reach the
/// limit of the tissue.
Probe randomPull(const Scan& scan, double threshold, Random& random)
{
  Probe probe;
  double scalar = threshold - 1.0;
  while (scalar < threshold)
  {
    Index3 at{};
    for (int a = 0; a < 3; ++a)
    {
      at[a] = 4 + random.below(scan.grid.size[a] - 8);
      probe.position[a] = at[a] * scan.grid.spacing[a];
    }
    scalar = scan.scalar[scan.grid.at(at[0], at[1], at[2])];
  }
  probe.radius = random(2.0, 9.0);
  const double reach = std::exp(random(std::log(4.0), std::log(60.0)));
  double square = 0.0;
  for (double& x : probe.displacement)
  {
    x = random(-1.0, 1.0);
    square += x * x;
  }
  for (double& x : probe.displacement)
  {
    x *= reach / std::sqrt(square);
  }
  return probe;
}

void pullAtRandom(const std::string& name, double threshold, const Nodes& nodes)
{
  const Scan scan = readScan(name);
  if (scan.scalar.empty())
  {
    GTEST_SKIP() << "the scan " << name << " is not there; name its folder in CHAINMAIL_VOLUMES";
  }
  ArrayView scalars;
  scalars.data = scan.scalar.data();
  scalars.type = ArrayView::Type::Float32;
  Material material;
  material.tissueThreshold = threshold;
  material.constraint = [&](double scalar) { return constraintAt(nodes, scalar); };
  Settings settings;
  settings.device = testDevice();
  Simulation simulation(std::make_shared<Model>(scan.grid, scalars, material, Anchors()), settings);
  const char* many = std::getenv("CHAINMAIL_PULLS");
  const int pulls = many ? std::atoi(many) : 2;
  double highest = 0.0;
  for (int pull = 0; pull < pulls; ++pull)
  {
    Random random(5000 + pull);
    std::vector<Probe> probes(pull % 3 == 2 ? 2 : 1);
    for (Probe& probe : probes)
    {
      probe = randomPull(scan, threshold, random);
    }
    std::array<std::array<double, 2>, 2> energy{}; // [without or with coarser grids][after 20 or 40 sweeps]
    for (const int coarse : { 0, 1 })
    {
      simulation.setCoarseToFine(coarse == 1);
      simulation.reset();
      simulation.pull(probes);
      for (const int half : { 0, 1 })
      {
        const RelaxResult result = simulation.relax(20, 1e-5);
        energy[coarse][half] = simulation.measure().energy;
        if (coarse == 1 && half == 0 && energy[0][0] > 0.0)
        {
          ASSERT_TRUE(result.coarseStep);
          EXPECT_EQ(*result.coarseStep, 1.0) << name << ", pull " << pull;
        }
      }
      EXPECT_LE(simulation.measure().maxLinkExcess, 1e-4);
    }
    for (const int half : { 0, 1 })
    {
      const double most = half == 0 ? 1 + 1e-6 : 1.05;
      EXPECT_LE(energy[1][half], energy[0][half] * most) << name << ", pull " << pull << ", half " << half;
      highest = std::max(highest, energy[0][half] > 0.0 ? energy[1][half] / energy[0][half] : 0.0);
    }
  }
  std::cout << name << ": energy at most " << highest << " times that without coarser grids\n";
}

const Nodes ct{ { -300.0, 0.3 }, { -100.0, 0.35 }, { 0.0, 0.25 }, { 50.0, 0.2 }, { 150.0, 0.15 }, { 300.0, 0.08 },
  { 600.0, 0.0 } };

}

TEST(CoarseToFineScans, HeartCta)
{
  pullAtRandom("heart_cta", -300.0, ct);
}

TEST(CoarseToFineScans, AbdomenCt)
{
  pullAtRandom("abdomen_ct", -300.0, ct);
}

TEST(CoarseToFineScans, HeadMr)
{
  pullAtRandom("head_mr", 25.5, { { 25.5, 0.15 }, { 76.5, 0.2 }, { 153.0, 0.3 }, { 255.0, 0.35 } });
}
