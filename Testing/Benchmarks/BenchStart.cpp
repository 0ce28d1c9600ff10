// B7: what the start of a process costs: the time from asking for a simulation to the end of a first, tiny cut, pull,
// relaxation and resampling, less that of the same once more. Measured in child processes, with empty caches of
// compiled kernels and with full ones.

#include "../TemporaryFolder.h"
#include "Settling.h"

#include <chrono>
#include <climits>
#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <unistd.h>

namespace
{

using namespace chainmail;

double workOnce(const std::string& device)
{
  const auto begin = std::chrono::steady_clock::now();
  bench::Block block = bench::heterogeneousBlock({ 24, 24, 24 });
  bench::addRods(block);
  block.anchors.faces[0] = true;
  Settings settings;
  settings.device = device;
  Simulation simulation(block.model(), settings);
  simulation.setCoarseToFine(true);
  simulation.cut({ { { 12.5, -1.0, -1.0 }, { 12.5, 12.0, -1.0 }, { 12.5, 12.0, 30.0 }, { 12.5, -1.0, 30.0 } },
    { { { 0, 1, 2 } }, { { 0, 2, 3 } } } });
  simulation.pull({ bench::probeAt({ 18, 12, 12 }, { 1.0, 0.5, -0.5 }, 2.0) });
  simulation.relax(20, 1e-3);
  simulation.measure();
  simulation.resample({ 0, 0, 0 }, [](const std::vector<ResampledBox>&) {});
  bench::requireSound(simulation);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Milliseconds that a new process loses, as it says itself.
double startOf(const std::string& cache, const std::string& device)
{
  char self[PATH_MAX] = {};
  if (readlink("/proc/self/exe", self, sizeof(self) - 1) <= 0)
  {
    throw std::runtime_error("this program does not know where it is");
  }
  // The engine's cache, PoCL's and that of NVIDIA's driver.
  const std::string command = "CHAINMAIL_CACHE_DIR='" + cache + "/chainmail' POCL_CACHE_DIR='" + cache +
                              "' CUDA_CACHE_PATH='" + cache + "' '" + self + "' --child '--device=" + device + "'";
  FILE* pipe = popen(command.c_str(), "r");
  double lost = 0.0;
  const bool read = pipe && fscanf(pipe, "%lf", &lost) == 1;
  if (!pipe || pclose(pipe) != 0 || !read)
  {
    throw std::runtime_error("a child process failed");
  }
  return lost;
}

int child(const std::string& device)
{
  const double first = workOnce(device);
  const double again = std::min(workOnce(device), workOnce(device));
  std::cout << first - again << std::endl;
  return EXIT_SUCCESS;
}

}

int main(int argc, char** argv)
{
  if (argc == 3 && std::string(argv[1]) == "--child")
  {
    return child(std::string(argv[2]).substr(std::string("--device=").size()));
  }
  return bench::run(argc, argv, "B7", "the start of a process",
    [](bench::Session& session)
    {
      const TemporaryFolder folder;
      const std::string cache = folder.path.string();
      session.report(
        { "first update of a process", "kernels not compiled yet", { startOf(cache, session.device()) }, {} });
      std::vector<double> later;
      for (int n = 0; n < (session.small() ? 2 : 7); ++n)
      {
        later.push_back(startOf(cache, session.device()));
      }
      session.report({ "first update of a process", "kernels in the cache", later, {} });
    });
}
