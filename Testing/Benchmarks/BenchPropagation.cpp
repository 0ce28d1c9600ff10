// B8: propagation alone, one probe, from rest to the end, against the serial queues of Gibson (homogeneous tissue) and
// Schill (heterogeneous tissue), which stop where nothing is violated.

#include "Baselines/SerialChainMail.h"
#include "Blocks.h"
#include "Session.h"

#include <cmath>
#include <stdexcept>

namespace
{

using namespace chainmail;

/// Both must have moved the same tissue by the same, to the rounding of a path of additions.
void requireAgreement(const Simulation& simulation, const baseline::State& state)
{
  std::vector<float> u(3 * simulation.model().grid().voxels());
  simulation.displacements(u.data());
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    if (!(std::fabs(u[n] - state[n % 3][n / 3]) < 1e-3f))
    {
      throw std::runtime_error("engine and serial queue disagree at voxel " + std::to_string(n / 3) + ": " +
                               std::to_string(u[n]) + " and " + std::to_string(state[n % 3][n / 3]));
    }
  }
}

/// A pull at the middle of the block that moves what is within so many links of mean constraint.
void compare(bench::Session& session, const bench::Block& block, bool homogeneous, double links)
{
  const int n = block.grid.size[0];
  const Index3 middle{ n / 2, n / 2, n / 2 };
  const Vector3 displacement{ 0.25 * links, -0.2 * links, 0.15 * links };
  Simulation simulation = session.simulate(block.model());
  baseline::SerialChainMail serial(block.grid.size, block.constraints());

  int iterations = 0;
  bench::Task engine;
  engine.prepare = [&]
  {
    simulation.reset();
    simulation.hold({ bench::probeAt(middle, displacement) });
  };
  engine.run = [&] { iterations = simulation.propagate().iterations; };
  engine.check = [&] { bench::requireSound(simulation); };

  std::size_t moved = 0;
  bench::Task queue;
  queue.prepare = [&] { serial.reset(); };
  queue.run = [&]
  {
    moved = homogeneous
              ? serial.pullFirstMovedFirst(block.grid.at(middle[0], middle[1], middle[2]), displacement)
              : serial.pullLargestViolationFirst(block.grid.at(middle[0], middle[1], middle[2]), displacement);
  };
  queue.check = [&] { requireAgreement(simulation, serial.state()); };

  const auto milliseconds = session.time({ engine, queue });
  const std::string scene = block.text() + ", " + (homogeneous ? "homogeneous" : "heterogeneous");
  session.report({ scene, "engine, envelopes", milliseconds[0],
    { { "elements moved", double(simulation.measure().displaced) }, { "iterations", double(iterations) },
      { "times the serial queue", bench::median(milliseconds[1]) / bench::median(milliseconds[0]) } } });
  session.report({ scene, homogeneous ? "serial queue (Gibson)" : "serial priority queue (Schill)", milliseconds[1],
    { { "elements moved", double(moved) } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B8", "propagation of one probe, against serial queues",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 128, 256 }))
      {
        // Half a block's width of links: 2.8 M elements of 256^3.
        compare(session, bench::Block({ n, n, n }), true, 0.5 * n);
        // Stiff patches pass a pull on much further.
        compare(session, bench::heterogeneousBlock({ n, n, n }), false, 0.2 * n);
      }
    });
}
