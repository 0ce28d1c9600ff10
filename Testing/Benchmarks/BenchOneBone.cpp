// B18: relaxation around a single bone, coarse to fine against the fine grid alone, each to within 1 % of the lowest
// energy that the constraints allow. Where all faces hold, little is left to settle far away, and coarser grids can
// cost more than they save; where one face does, they have much to do.

#include "Settling.h"

namespace
{

using namespace chainmail;

constexpr double tolerance = 1e-4;

void settle(bench::Session& session, int n, bool held)
{
  bench::Block block = bench::heterogeneousBlock({ n, n, n });
  bench::addRod(block);
  block.anchors.faces.fill(held);
  block.anchors.faces[0] = true;
  const Probe handle = bench::probeAt({ 3 * n / 4, n / 2, n / 2 }, { 0.06 * n, 0.04 * n, -0.03 * n }, n / 16.0);
  Simulation simulation = session.simulate(block.model());
  const auto start = [&](bool coarse)
  {
    simulation.setCoarseToFine(coarse);
    simulation.reset();
    simulation.pull({ handle });
  };
  start(true);
  const double optimum = bench::convergedEnergy(simulation);
  std::vector<bench::Task> tasks;
  std::vector<double> sweeps;
  for (const bool coarse : { true, false })
  {
    const int count = bench::sweepsToSettle(
      simulation, [&] { start(coarse); }, optimum, 10000, tolerance);
    bench::Task task;
    task.prepare = [&start, coarse] { start(coarse); };
    task.run = [&simulation, count] { simulation.relax(count, tolerance); };
    task.check = [&simulation] { bench::requireSound(simulation); };
    tasks.push_back(task);
    sweeps.push_back(count);
  }
  const auto milliseconds = session.time(tasks);
  const std::string scene = block.text() + ", one bone, " + (held ? "all faces" : "one face") + " anchored";
  session.report({ scene, "coarse to fine", milliseconds[0], { { "sweeps on the finest grid", sweeps[0] } } });
  session.report({ scene, "finest grid alone", milliseconds[1],
    { { "sweeps on the finest grid", sweeps[1] },
      { "times coarse to fine", bench::median(milliseconds[1]) / bench::median(milliseconds[0]) } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B18", "relaxation around one bone",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 96, 128 }))
      {
        settle(session, n, true);
        settle(session, n, false);
      }
    });
}
