// B5: relaxation sweeps over tissue that is all in motion, against the bytes that memory can move: an element-update
// reads and writes 3 floats and reads a byte of constraint, 25 bytes in all.

#include "Blocks.h"
#include "Session.h"

#include <stdexcept>

namespace
{

using namespace chainmail;

constexpr int sweeps = 20;
constexpr double bytesPerUpdate = 25.0;

/// Hands on a lattice that go in all directions, so that no element is far from one.
std::vector<Probe> hands(int n)
{
  Random random(7);
  std::vector<Probe> probes;
  for (int k = n / 8; k < n; k += n / 4)
  {
    for (int j = n / 8; j < n; j += n / 4)
    {
      for (int i = n / 8; i < n; i += n / 4)
      {
        const double reach = 0.03 * n;
        probes.push_back(
          bench::probeAt({ i, j, k }, { random(-reach, reach), random(-reach, reach), random(-reach, reach) }));
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

void dense(bench::Session& session, const bench::Block& block, const std::string& name)
{
  const int n = block.grid.size[0];
  Simulation simulation = session.simulate(block.model());
  bench::Task task;
  task.prepare = [&]
  {
    simulation.reset();
    simulation.pull(hands(n));
    simulation.relax(n / 4, 0.0); // what is far from a hand has to hear of it first
  };
  double largestMove = 0.0;
  task.run = [&] { largestMove = simulation.relax(sweeps, 0.0).largestMove; };
  task.check = [&]
  {
    bench::requireSound(simulation);
    const double share = shareInMotion(simulation);
    if (share < 0.95 || largestMove < 1e-3)
    {
      throw std::runtime_error("these were no dense sweeps: " + std::to_string(share) + " of the tissue moves, by " +
                               std::to_string(largestMove) + " at most");
    }
  };
  const std::vector<double> milliseconds = session.time(task);

  const double updates = double(sweeps) * double(block.grid.voxels()) / (1e-3 * bench::median(milliseconds));
  const bench::Bandwidth bandwidth = session.machine().measure();
  session.report({ block.text() + ", " + name, std::to_string(sweeps) + " sweeps", milliseconds,
    { { "updates [M/s]", 1e-6 * updates },
      { "share of triad / 25 B", updates * bytesPerUpdate * 1e-9 / bandwidth.deviceTriad },
      { "share of copy / 25 B", updates * bytesPerUpdate * 1e-9 / bandwidth.deviceCopy } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B5", "dense relaxation sweeps",
    [](bench::Session& session)
    {
      const std::vector<int> sizes = session.small() ? std::vector<int>{ 24 } : std::vector<int>{ 64, 128, 192 };
      for (const int n : sizes)
      {
        dense(session, bench::heterogeneousBlock({ n, n, n }), "heterogeneous");
      }
      const int n = session.small() ? 24 : 128;
      dense(session, bench::Block({ n, n, n }), "homogeneous");
      bench::Block bone = bench::heterogeneousBlock({ n, n, n });
      bench::addRods(bone);
      dense(session, bone, "heterogeneous with bone");
    });
}
