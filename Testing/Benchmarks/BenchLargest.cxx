// B12: an image of 1024^3 bytes in the filter, of whose tissue a pull displaces about 1 %: the most memory that the
// process takes, and what a second update costs, against the same in 256^3.

#include "../Filters/FilterTest.h"
#include "Session.h"

#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>

namespace
{

/// The most memory of this process so far [bytes].
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
  return 1024.0 * kilobytes;
}

vtkSmartPointer<vtkImageData> tissue(int n)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(n, n, n);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  auto* values = static_cast<unsigned char*>(image->GetScalarPointer());
  for (vtkIdType v = 0; v < image->GetNumberOfPoints(); ++v)
  {
    values[v] = static_cast<unsigned char>(40 + v * 2654435761u % 16);
  }
  return image;
}

/// Milliseconds to copy the output once.
double copyTime(vtkImageData* image)
{
  vtkDataArray* from = image->GetPointData()->GetScalars();
  std::vector<char> to(from->GetNumberOfValues() * from->GetDataTypeSize());
  const auto begin = std::chrono::steady_clock::now();
  std::memcpy(to.data(), from->GetVoidPointer(0), to.size());
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void update(bench::Session& session, int n, double far)
{
  const auto image = tissue(n);
  vtkNew<vtkChainMailDeformation> filter;
  filter->SetInputData(image);
  filter->SetDevice(session.device().c_str());
  filter->SetModeToInteractive();
  filter->SetTissueThreshold(10.0);
  filter->SetMaterialFunction(FilterTest::ConstantMaterial(0.25));
  filter->SetRelaxationIterations(2);
  FilterTest::Probe probe;
  probe.Position.fill(n / 2);
  const auto to = [&](double distance)
  {
    probe.Displacement = { distance, 0.5 * far, -0.3 * far };
    filter->SetInputDataObject(1, FilterTest::MakeProbes({ probe }));
    filter->Update();
  };
  to(far);
  // The memory that outputs take turns in is there after the second one.
  to(1.004 * far);
  bench::Task next;
  int step = 1;
  next.run = [&] { to((1.0 + 0.004 * ++step) * far); };
  next.check = [&]
  {
    if (!std::isfinite(FilterTest::Field(filter->GetOutput(), "Energy")))
    {
      throw std::runtime_error("the update failed: " + FilterTest::ErrorOf(filter->GetOutput()));
    }
  };
  std::vector<double> milliseconds(5);
  std::generate(milliseconds.begin(), milliseconds.end(), [&] { return session.once(next); });
  const double most = peak(); // before this program copies the output, which is not the filter's memory
  const double displaced = FilterTest::Field(filter->GetOutput(), "DisplacedElements");
  const std::string size = std::to_string(n);
  session.report({ size + " x " + size + " x " + size, "filter, a later update", milliseconds,
    { { "elements displaced", displaced }, { "share of the elements", displaced / std::pow(n, 3.0) },
      { "copy of the output [ms]", copyTime(filter->GetOutput()) },
      { "ns per element displaced", 1e6 * bench::median(milliseconds) / displaced },
      { "peak of the process [MB]", 1e-6 * most } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B12", "the largest image",
    [](bench::Session& session)
    {
      // The smaller one comes first, since the peak is that of the whole process.
      update(session, session.small() ? 48 : 256, session.small() ? 4.0 : 24.0);
      update(session, session.small() ? 96 : 1024, session.small() ? 6.0 : 46.0);
    });
}
