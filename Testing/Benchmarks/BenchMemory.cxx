// B3: memory of the engine on chest_lidc_ct (12.1 M voxels): what a voxel costs before anything reaches it, and an
// element that a pull has reached; and the peak of an update of the filter, there and on head_vhf_ct (8.9 M). On a
// processor the device's memory is the process's own, so that its size says it all.

#include "Blocks.h"
#include "Scans.h"

#include <malloc.h>
#include <unistd.h>

namespace
{

/// Bytes of this process in memory, without those that it has freed.
double resident()
{
  malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  double present = 0.0;
  file >> pages >> present;
  return present * double(sysconf(_SC_PAGESIZE));
}

/// The most that it was since the last call.
double peak()
{
  double kilobytes = 0.0;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
  {
    if (word == "VmHWM:")
    {
      status >> kilobytes;
    }
  }
  std::ofstream("/proc/self/clear_refs") << 5;
  return 1024.0 * kilobytes;
}

/// The engine's: what a voxel costs before anything reaches it, and an element that a pull has reached.
void ofEngine(bench::Session& session, const std::string& name, vtkImageData* scan)
{
  const auto function = bench::softMaterial(-300.0, 600.0);
  chainmail::Grid grid;
  scan->GetDimensions(grid.size.data());
  scan->GetSpacing(grid.spacing.data());
  chainmail::ArrayView scalars;
  scalars.data = scan->GetPointData()->GetScalars()->GetVoidPointer(0);
  scalars.type = chainmail::ArrayView::Type::Int16;
  chainmail::Material material;
  material.tissueThreshold = -300.0;
  material.constraint = [&](double scalar) { return function->GetValue(scalar); };
  chainmail::Probe probe;
  for (int a = 0; a < 3; ++a)
  {
    probe.position[a] = 0.5 * grid.size[a] * grid.spacing[a];
  }
  probe.displacement = { 40.0, 20.0, -10.0 };
  probe.radius = 8.0;
  {
    // The first simulation of a process also loads and compiles what later ones share.
    const bench::Block block({ 32, 32, 32 });
    chainmail::Simulation simulation = session.simulate(block.model());
    simulation.pull({ bench::probeAt({ 16, 16, 16 }, { 2.0, 1.0, -1.0 }, 2.0) });
    simulation.relax(20, 1e-3);
    bench::requireSound(simulation);
  }
  const double before = resident();
  auto model = std::make_shared<const chainmail::Model>(grid, scalars, material, chainmail::Anchors());
  chainmail::Simulation simulation = session.simulate(model);
  const double atRest = resident();
  simulation.pull({ probe });
  simulation.relax(20, 1e-3);
  const double deformed = resident();
  bench::requireSound(simulation);
  const chainmail::Statistics statistics = simulation.measure();
  const double reached = double(statistics.displaced);
  session.report({ name, "engine", {},
    { { "elements", double(model->elements()) }, { "elements reached", reached },
      { "element places held", double(statistics.allocated) },
      { "device bytes per place held", double(statistics.deviceBytes) / double(statistics.allocated) },
      { "bytes per voxel not reached", (atRest - before) / double(grid.voxels()) },
      { "device bytes per element reached", double(statistics.deviceBytes) / reached },
      { "bytes of the process per element reached", (deformed - atRest) / reached } } });
}

/// The filter's own: its outputs, which hold every voxel, what it keeps beside them, and what it takes on the way.
void ofFilter(bench::Session& session, const std::string& name, vtkImageData* scan)
{
  bench::Drag drag(session, scan, -300.0, 600.0);
  drag.grabAt({ 0.0, 0.0, 0.0 }, 8.0);
  const double before = resident();
  peak();
  drag.to(40.0);
  const double most = peak() - before;
  drag.requireSound(false);
  const double voxels = double(scan->GetNumberOfPoints());
  const double outputs = 1024.0 * double(drag.filter()->GetOutput()->GetActualMemorySize() +
                                         drag.filter()->GetModelOutput()->GetActualMemorySize());
  session.report({ name, "filter", {},
    { { "bytes of outputs per voxel", outputs / voxels },
      { "peak of an update, device [MB]", drag.field("PeakDeviceMemory") },
      { "bytes of the process per voxel", (resident() - before) / voxels },
      { "peak of an update, device and host [MB]", 1e-6 * most }, { "peak [MB per million voxels]", most / voxels },
      { "elements reached", drag.field("DisplacedElements") } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B3", "memory",
    [](bench::Session& session)
    {
      const std::string name = bench::scanName(session, "chest_lidc_ct");
      const auto scan = bench::readScan(name);
      ofEngine(session, name, scan);
      ofFilter(session, name, scan);
      const std::string head = bench::scanName(session, "head_vhf_ct");
      ofFilter(session, head, bench::readScan(head));
    });
}
