// B9: relaxation to within 1 % of the lowest energy that the constraints allow, starting on coarser grids, against the
// same sweeps on the fine grid alone. The work is counted in fine sweeps: what it took, over the time of a dense one.

#include "Settling.h"

namespace
{

using namespace chainmail;

constexpr double tolerance = 1e-4;

/// Tissue with two bones, a patch in hand and one face anchored.
void settle(bench::Session& session, int n)
{
  bench::Block block = bench::heterogeneousBlock({ n, n, n });
  bench::addRods(block);
  block.anchors.faces[0] = true;
  const std::vector<Probe> probes{ bench::probeAt(
    { 3 * n / 4, n / 2, n / 2 }, { 0.06 * n, 0.04 * n, -0.03 * n }, n / 16.0) };
  Simulation simulation = session.simulate(block.model());
  const auto start = [&](bool coarse)
  {
    simulation.setCoarseToFine(coarse);
    simulation.reset();
    simulation.pull(probes);
  };
  start(true);
  const double optimum = bench::convergedEnergy(simulation);
  bench::requireSound(simulation);

  const std::vector<double> sweep = bench::denseSweep(session, block);
  const std::string scene = block.text() + ", two bones, one hand";
  const auto timed = [&](bool coarse, int sweeps)
  {
    bench::Task task;
    task.prepare = [&simulation, start, coarse] { start(coarse); };
    task.run = [&simulation, sweeps] { simulation.relax(sweeps, tolerance); };
    task.check = [&simulation] { bench::requireSound(simulation); };
    return task;
  };
  const int coarseSweeps = bench::sweepsToSettle(
    simulation, [&] { start(true); }, optimum, 200, tolerance);
  std::vector<bench::Task> tasks{ timed(true, coarseSweeps) };
  // On the largest grid the single one would take minutes for a result that is known from the smaller.
  const bool single = n <= 128;
  const int singleSweeps = single ? bench::sweepsToSettle(
                                      simulation, [&] { start(false); }, optimum, 4000, tolerance)
                                  : 0;
  if (single)
  {
    tasks.push_back(timed(false, singleSweeps));
  }
  const auto milliseconds = session.time(tasks);
  const double inSweeps = bench::median(milliseconds[0]) / bench::median(sweep);
  session.report({ scene, "coarse to fine", milliseconds[0],
    { { "sweeps on the finest grid", double(coarseSweeps) }, { "work in fine sweeps", inSweeps },
      { "one dense sweep [ms]", bench::median(sweep) } } });
  if (single)
  {
    session.report({ scene, "finest grid alone", milliseconds[1],
      { { "sweeps on the finest grid", double(singleSweeps) },
        { "times coarse to fine", bench::median(milliseconds[1]) / bench::median(milliseconds[0]) } } });
  }
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B9", "relaxation to within 1 % of the optimum",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 64, 128, 256 }))
      {
        settle(session, n);
      }
    });
}
