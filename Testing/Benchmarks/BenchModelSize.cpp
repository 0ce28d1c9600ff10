// B4: the same pull in ever larger models of the same tissue. A frame, that is a step of a drag with 10 + 10
// iterations, must cost what the pull touches, not what the model holds. (Coarse to fine is not for that: it settles
// all tissue that hangs together.)

#include "Settling.h"

#include <stdexcept>

namespace
{

using namespace chainmail;

struct Scan
{
  Scan(bench::Session& session, int n)
    : block({ n, n, n })
    , simulation(session.simulate(block.model()))
    , middle{ n / 2, n / 2, n / 2 }
  {
  }

  void hold(double far) { this->simulation.hold({ bench::probeAt(this->middle, { far, 0.5 * far, 0.0 }, 4.0) }); }

  bench::Block block;
  Simulation simulation;
  Index3 middle;
};

void drag(bench::Session& session, std::vector<std::unique_ptr<Scan>>& scans)
{
  std::vector<bench::Task> tasks;
  for (const std::unique_ptr<Scan>& scan : scans)
  {
    Simulation& simulation = scan->simulation;
    bench::Task task;
    task.prepare = [&]
    {
      simulation.reset();
      scan->hold(3.0);
      simulation.propagate();
      simulation.relax(10, 1e-3);
      scan->hold(4.0);
    };
    task.run = [&]
    {
      simulation.propagate(10);
      simulation.relax(10, 1e-3);
    };
    tasks.push_back(task);
  }
  const auto milliseconds = session.time(tasks);
  for (std::size_t m = 0; m < scans.size(); ++m)
  {
    Scan& scan = *scans[m];
    scan.simulation.propagate();
    bench::requireSound(scan.simulation);
    const Statistics statistics = scan.simulation.measure();
    session.report({ scan.block.text(), "10 + 10 iterations", milliseconds[m],
      { { "elements displaced", double(statistics.displaced) },
        { "device memory [MB]", 1e-6 * double(statistics.deviceBytes) },
        { "times the smallest model", bench::median(milliseconds[m]) / bench::median(milliseconds[0]) } } });
  }
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B4", "a frame of the same pull in larger models",
    [](bench::Session& session)
    {
      // 2, 16, 54 and 128 M voxels.
      std::vector<std::unique_ptr<Scan>> scans;
      std::vector<int> sizes = session.sizes({ 126, 252, 378, 504 });
      if (session.small())
      {
        sizes = { 48, 64 };
      }
      for (const int n : sizes)
      {
        scans.push_back(std::make_unique<Scan>(session, n));
      }
      drag(session, scans);
    });
}
