// B1: the paper's figure 12. A homogeneous block of 126^3 elements, one corner held, the opposite one pulled so far
// that the wave moves all tissue between: propagation, then relaxation.

#include "Settling.h"

namespace
{

using namespace chainmail;

constexpr double tolerance = 1e-4;
constexpr double paperGpuMilliseconds = 458.0; // GTX 670, blocks of 16 x 4 x 4

std::string text(const Index3& size)
{
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
}

/// A corner in hand, the far one held. All links between them are stretched to nine tenths of their limits, so that all
/// tissue but the last corner moves with the wave, and relaxation has something left to do.
std::vector<Probe> hands(const bench::Block& block)
{
  const Index3& n = block.grid.size;
  const double reach = 0.9 * block.constraint(0) * (n[0] + n[1] + n[2] - 3);
  Probe held = bench::probeAt({ n[0] - 1, n[1] - 1, n[2] - 1 }, {});
  held.anchor = true;
  return { held, bench::probeAt({ 0, 0, 0 }, { -reach, -reach, -reach }) };
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B1", "the paper's figure 12: propagation and relaxation of a whole block",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 126 }))
      {
        const bench::Block block({ n, n, n });
        const std::vector<Probe> probes = hands(block);
        Simulation simulation = session.simulate(block.model());
        simulation.setCoarseToFine(true);
        const auto start = [&]
        {
          simulation.reset();
          simulation.pull(probes);
        };
        start();
        const double optimum = bench::convergedEnergy(simulation);
        bench::requireSound(simulation);
        const int sweeps = bench::sweepsToSettle(simulation, start, optimum, 500, tolerance);
        bench::Task task;
        task.prepare = [&] { simulation.reset(); };
        task.run = [&]
        {
          simulation.pull(probes);
          simulation.relax(sweeps, tolerance);
        };
        task.check = [&] { bench::requireSound(simulation); };
        const std::vector<double> ms = session.time(task);
        session.report({ block.text() + ", homogeneous, all affected",
          "engine, coarse to fine, bricks " + text(simulation.brickSize()), ms,
          { { "sweeps on the finest grid", double(sweeps) },
            { "times the paper's GPU", paperGpuMilliseconds / bench::median(ms) } } });
      }
    });
}
