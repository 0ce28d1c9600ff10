// A program that has the kernels compiled which most scenes use, so that the first update need not wait for them. A
// small scene runs through the engine on the device that is taken where none is named, and what is compiled on the way
// stays in the caches of the user (Data/Install.md). It is a process of its own since a driver's compiler holds one
// lock for all threads of a process, and comes to harm in one that ends meanwhile.
//
// It ends at once where it ran before: with the same kernels, and with the same programs still in the cache.
//
// Then it tries the GPUs of drivers that are not known (Trial.h). Such a driver may end this process, or not come to an
// end; nobody waits for it.

#include "Device.h"
#include "Error.h"
#include "KernelSources.h"
#include "Model.h"
#include "ProgramCache.h"
#include "Simulation.h"
#include "Trial.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <vector>

#ifdef __unix__
#include <unistd.h>
#endif

namespace
{

using namespace chainmail;

/// A block of soft tissue, held at one face, with or without a bone in it.
std::shared_ptr<const Model> block(bool hasBone)
{
  Grid grid;
  grid.size = { 40, 40, 40 };
  return std::make_shared<const Model>(grid, 1,
    [grid, hasBone](std::size_t first, int count, float* constraints)
    {
      for (int n = 0; n < count; ++n)
      {
        const Index3 at = grid.indexOf(first + n);
        const bool bone = hasBone && at[0] > 8 && at[1] / 6 == 1 && at[2] / 6 == 1;
        const bool air = at[2] > 36;
        constraints[n] = air          ? -std::numeric_limits<float>::infinity()
                         : at[0] == 0 ? -0.2f
                         : bone       ? 0.0f
                         : at[1] > 20 ? 0.45f
                                      : 0.2f;
      }
    });
}

/// An incision from one side of the block to its middle.
Surface incision()
{
  Surface surface;
  surface.points = { { 20.5, -1.0, -1.0 }, { 20.5, 20.0, -1.0 }, { 20.5, 20.0, 41.0 }, { 20.5, -1.0, 41.0 } };
  surface.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  return surface;
}

void look(const Simulation& simulation)
{
  simulation.measure();
  simulation.resample(
    { 0, 0, 0 }, [](const std::vector<ResampledBox>&) {}, 0, CutSurfaces::Smooth);
}

/// Some more than the preset Balanced makes, and an estimate of what is left, so that all kernels are used which it
/// uses.
constexpr int iterations = 70;
constexpr double error = 1e-9;

/// What takes long to compile and is used last comes first: whoever updates at the same time begins with the rest.
void use(const Settings& settings)
{
  Probe probe;
  probe.position = { 30.0, 20.0, 20.0 };
  probe.displacement = { 6.0, -4.0, -3.0 };
  probe.radius = 3.0;
  Probe other = probe;
  other.position = { 30.0, 30.0, 30.0 };
  other.displacement = { -5.0, 4.0, 2.0 };

  // With bone that can move, corrections on coarser grids move it, too.
  for (const bool hasBone : { true, false })
  {
    Simulation simulation(block(hasBone), settings);
    simulation.setCoarseToFine(true);
    simulation.pull({ probe });
    look(simulation);
    simulation.relax(iterations, 0.0, error);
    simulation.cut(incision());
    simulation.pull({ probe, other });
    simulation.relax(iterations, 0.0, error);
    look(simulation);
  }
}

/// Pulls at the block on a device, and throws where what comes of it cannot be right.
void tryOn(const DeviceInfo& device)
{
  Settings settings;
  settings.device = device.name;
  use(settings);
  Probe probe;
  probe.position = { 30.0, 20.0, 20.0 };
  probe.displacement = { 6.0, -4.0, -3.0 };
  Simulation simulation(block(true), settings);
  const std::vector<ProbeResult> reached = simulation.pull({ probe });
  const Statistics statistics = simulation.measure();
  const bool isMoved = statistics.displaced > 0 && reached.front().reached == probe.displacement;
  if (!isMoved || !(statistics.maxLinkExcess < 1e-4) || !(statistics.energy > 0.0))
  {
    throw DeviceError("\"" + device.name + "\" gives results that differ from those of other devices.");
  }
}

/// This process goes on in the background: others come first, and nobody is to wait for a pipe or socket that it was
/// started with.
void stepBack()
{
#ifdef __unix__
  nice(10);
  const long most = sysconf(_SC_OPEN_MAX);
  for (int file = STDERR_FILENO + 1; file < std::min(most, 1L << 16); ++file)
  {
    close(file);
  }
#endif
}

}

int main()
{
  stepBack();
  try
  {
    const ProgramCache cache(ProgramCache::userFolder());
    const std::string done = std::string("compiled ahead: ") + detail::kernelsHash();
    if (cache.find(done).empty())
    {
      use(Settings());
      cache.keep(done, [] { return "done"; });
    }
    for (const DeviceInfo& device : listDevices())
    {
      if (device.gpu && !device.proven)
      {
        tryDevice(device, [&] { tryOn(device); });
      }
    }
    return EXIT_SUCCESS;
  }
  catch (const std::exception& error)
  {
    std::cerr << error.what() << '\n'; // the first update says it, too
    return EXIT_FAILURE;
  }
}
