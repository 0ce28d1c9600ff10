#include "Settling.h"

#include <stdexcept>
#include <string>

namespace bench
{

namespace
{

using namespace chainmail;

/// Handles on a lattice that go in all directions, so that no element is far from one. `share`: of how far they go.
std::vector<Probe> lattice(int n, double share)
{
  Random random(7);
  std::vector<Probe> probes;
  for (int k = n / 8; k < n; k += n / 4)
  {
    for (int j = n / 8; j < n; j += n / 4)
    {
      for (int i = n / 8; i < n; i += n / 4)
      {
        const double reach = share * 0.03 * n;
        probes.push_back(probeAt({ i, j, k }, { random(-reach, reach), random(-reach, reach), random(-reach, reach) }));
      }
    }
  }
  return probes;
}

/// Share of the elements that one more sweep moves.
double shareInMotion(Simulation& simulation)
{
  const std::size_t count = 3 * simulation.model().grid().voxels();
  std::vector<float> before(count);
  std::vector<float> after(count);
  simulation.displacements(before.data());
  simulation.relax(1, 0.0);
  simulation.displacements(after.data());
  std::size_t moved = 0;
  for (std::size_t n = 0; n < count; n += 3)
  {
    moved += before[n] != after[n] || before[n + 1] != after[n + 1] || before[n + 2] != after[n + 2] ? 1 : 0;
  }
  return double(moved) / double(count / 3);
}

}

double convergedEnergy(Simulation& simulation)
{
  constexpr int sweeps = 50;
  double energy = simulation.measure().energy;
  int still = 0;
  for (int rounds = 0; still < 2; ++rounds)
  {
    if (rounds == 100)
    {
      throw std::runtime_error("relaxation does not converge");
    }
    simulation.relax(sweeps, 0.0);
    const double now = simulation.measure().energy;
    still = energy - now < 0.01 * settledShare * now ? still + 1 : 0;
    energy = now;
  }
  return energy;
}

int sweepsToSettle(
  Simulation& simulation, const std::function<void()>& start, double optimum, int most, double tolerance)
{
  start();
  for (int sweeps = 1; sweeps <= most; ++sweeps)
  {
    simulation.relax(1, tolerance);
    if (simulation.measure().energy <= (1.0 + settledShare) * optimum)
    {
      return sweeps;
    }
  }
  throw std::runtime_error(std::to_string(most) + " sweeps end at " +
                           std::to_string(simulation.measure().energy / optimum) + " times the lowest energy");
}

std::vector<double> denseSweep(Session& session, const Block& block)
{
  constexpr int sweeps = 20;
  const int n = block.grid.size[0];
  Block loose = block; // what is anchored does not move
  loose.anchors.faces.fill(false);
  Simulation simulation = session.simulate(loose.model());
  Task task;
  task.prepare = [&]
  {
    simulation.reset();
    simulation.pull(lattice(n, 0.99));
    simulation.relax(n / 4, 0.0);     // what is far from a handle has to hear of it first
    simulation.pull(lattice(n, 1.0)); // sweeps count from here: blocked groups have no turn among so few
  };
  double largestMove = 0.0;
  task.run = [&] { largestMove = simulation.relax(sweeps, 0.0).largestMove; };
  task.check = [&]
  {
    requireSound(simulation);
    const double share = shareInMotion(simulation);
    if (share < 0.95 || largestMove < 1e-3)
    {
      throw std::runtime_error("these were no dense sweeps: " + std::to_string(share) + " of the tissue moves, by " +
                               std::to_string(largestMove) + " at most");
    }
  };
  std::vector<double> milliseconds = session.time(task);
  for (double& value : milliseconds)
  {
    value /= sweeps;
  }
  return milliseconds;
}

}
