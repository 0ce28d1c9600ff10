// B2: a frame on a real scan, chest_lidc_ct (12.1 M voxels), with 5 and with 30 % of the tissue displaced: a drag in
// the filter's Interactive mode with 10 + 10 iterations an update.

#include "Scans.h"
#include "Settling.h"

#include <cmath>

namespace
{

constexpr double threshold = -300.0;
constexpr double top = 600.0;
constexpr int iterations = 10;

/// Elements of the scan: its tissue.
double elementsOf(vtkImageData* scan)
{
  vtkDataArray* scalars = scan->GetPointData()->GetScalars();
  double count = 0.0;
  for (vtkIdType v = 0; v < scalars->GetNumberOfTuples(); ++v)
  {
    count += scalars->GetTuple1(v) >= threshold ? 1.0 : 0.0;
  }
  return count;
}

void frames(bench::Session& session, const std::string& name, vtkImageData* scan, double share, double denseNanoseconds)
{
  bench::Drag drag(session, scan, threshold, top);
  drag.grabAt({ 0.1, 0.0, 0.0 }, 8.0);
  vtkChainMailDeformation* filter = drag.filter();
  filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0); // all tissue may follow
  filter->SetRelaxationIterations(iterations);
  const double elements = elementsOf(scan);
  double far = 4.0;
  bench::Task frame;
  frame.prepare = [&]
  {
    drag.rest();
    filter->SetPropagationIterations(0);
    drag.to(0.97 * far);
    drag.requireSound(false);
    filter->SetPropagationIterations(iterations);
  };
  frame.run = [&] { drag.to(far); };
  std::array<std::vector<double>, 5> parts;
  double displaced = 0.0;
  frame.check = [&]
  {
    drag.requireSound(true);
    displaced = drag.field("DisplacedElements");
    for (int part = 0; part < 5; ++part)
    {
      parts[part].push_back(drag.field("Milliseconds", part));
    }
  };
  // How far the handle has to go for about that share of the tissue to be displaced; what comes nearest will do.
  double low = 0.0;
  double high = 0.0;
  for (int tries = 0; tries < 12 && std::fabs(displaced / elements - share) > 0.1 * share; ++tries)
  {
    if (tries > 0)
    {
      (displaced < share * elements ? low : high) = far;
      far = high == 0.0 ? 2.0 * far : 0.5 * (low + high);
    }
    session.once(frame);
  }
  if (displaced == 0.0)
  {
    throw std::runtime_error("no pull displaces any tissue");
  }

  for (std::vector<double>& part : parts)
  {
    part.clear();
  }
  const std::vector<double> whole = session.time(frame);
  const double relax = bench::median(parts[FilterTest::RELAX]);
  const double nanoseconds = 1e6 * relax / (displaced * iterations);
  session.report(
    { name + ", " + std::to_string(static_cast<int>(std::lround(100.0 * displaced / elements))) + " % displaced",
      "10 + 10 iterations", whole,
      { { "upload [ms]", bench::median(parts[FilterTest::UPLOAD]) },
        { "propagate [ms]", bench::median(parts[FilterTest::PROPAGATE]) }, { "relax [ms]", relax },
        { "resample [ms]", bench::median(parts[FilterTest::RESAMPLE]) },
        { "download [ms]", bench::median(parts[FilterTest::DOWNLOAD]) }, { "elements", elements },
        { "elements displaced", displaced }, { "ns per element-update", nanoseconds },
        { "times the dense rate", nanoseconds / denseNanoseconds } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B2", "a frame on a scan",
    [](bench::Session& session)
    {
      const std::string name = bench::scanName(session, "chest_lidc_ct");
      const auto scan = bench::readScan(name);
      const int n = session.small() ? 24 : 128;
      const bench::Block block = bench::heterogeneousBlock({ n, n, n });
      const double dense = 1e6 * bench::median(bench::denseSweep(session, block)) / double(block.grid.voxels());
      for (const double share : { 0.05, 0.3 })
      {
        frames(session, name, scan, share, dense);
      }
    });
}
