#include "Settling.h"

#include "Baselines/DenseSweep.h"

#include <algorithm>
#include <cmath>
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

constexpr int sweepsTimed = 20;

/// A block of which all tissue is in motion.
class DenseTissue
{
public:
  DenseTissue(Session& session, const Block& block, bool rotations)
    : block_(loose(block))
    , simulation_(session.simulate(this->block_.model(), settings(rotations)))
  {
  }

  Task sweeps()
  {
    Task task;
    task.prepare = [this]
    {
      const int n = this->block_.grid.size[0];
      this->simulation_.reset();
      this->simulation_.pull(lattice(n, 0.99));
      this->simulation_.relax(n / 4, 0.0);     // what is far from a handle has to hear of it first
      this->simulation_.pull(lattice(n, 1.0)); // sweeps count from here: blocked groups have no turn among so few
    };
    task.run = [this] { this->largestMove_ = this->simulation_.relax(sweepsTimed, 0.0).largestMove; };
    task.check = [this]
    {
      requireSound(this->simulation_);
      const double share = shareInMotion(this->simulation_);
      if (share < 0.95 || this->largestMove_ < 1e-3)
      {
        throw std::runtime_error("these were no dense sweeps: " + std::to_string(share) + " of the tissue moves, by " +
                                 std::to_string(this->largestMove_) + " at most");
      }
    };
    return task;
  }

private:
  /// What is anchored does not move.
  static Block loose(Block block)
  {
    block.anchors.faces.fill(false);
    return block;
  }

  static Settings settings(bool rotations)
  {
    Settings settings;
    settings.rotations = rotations;
    return settings;
  }

  Block block_; // which the simulation's model reads
  Simulation simulation_;
  double largestMove_ = 0.0;
};

/// Milliseconds of one of the sweeps that each of two tasks times.
std::array<std::vector<double>, 2> timeOfOne(Session& session, const std::vector<Task>& tasks)
{
  const std::vector<std::vector<double>> times = session.time(tasks);
  std::array<std::vector<double>, 2> milliseconds;
  for (std::size_t task = 0; task < times.size(); ++task)
  {
    for (const double value : times[task])
    {
      milliseconds[task].push_back(value / sweepsTimed);
    }
  }
  return milliseconds;
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
  return denseSweeps(session, block)[0];
}

std::array<std::vector<double>, 2> denseSweeps(Session& session, const Block& block)
{
  DenseTissue tissue(session, block, false);
  std::vector<Task> tasks{ tissue.sweeps() };

  // Its time does not depend on what moves.
  baseline::DenseSweep plain(block.grid.size, block.constraints());
  Task yardstick;
  yardstick.prepare = [&]
  {
    Random random(3);
    std::array<std::vector<float>, 3> state;
    for (std::vector<float>& axis : state)
    {
      axis.resize(block.grid.voxels());
      std::generate(axis.begin(), axis.end(), [&] { return static_cast<float>(random(-0.02, 0.02)); });
    }
    plain.start(state, std::vector<char>(block.grid.voxels(), 0));
  };
  yardstick.run = [&]
  {
    for (int sweep = 0; sweep < sweepsTimed; ++sweep)
    {
      plain.sweep(1.5f);
    }
  };
  yardstick.check = [&]
  {
    const auto state = plain.state();
    if (!std::all_of(state[0].begin(), state[0].end(), [](float u) { return std::fabs(u) <= 1.0f; }))
    {
      throw std::runtime_error("the plain sweep left its limits");
    }
  };
  if (baseline::DenseSweep::runsHere())
  {
    tasks.push_back(yardstick);
  }
  return timeOfOne(session, tasks);
}

std::array<std::vector<double>, 2> turningSweeps(Session& session, const Block& block)
{
  DenseTissue turning(session, block, true);
  DenseTissue still(session, block, false);
  return timeOfOne(session, { turning.sweeps(), still.sweeps() });
}

}
