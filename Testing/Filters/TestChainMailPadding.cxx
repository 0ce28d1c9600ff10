// SPDX-License-Identifier: BSD-3-Clause
// OutputPadding that makes an image of more voxels than can be handled, and memory that the system does not give: each
// is one error that says what to do, before anything is allocated, and the next update works.

#include "FilterTest.h"

#include "vtkInformation.h"
#include "vtkSMPTools.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <fstream>
#include <limits>
#include <sys/resource.h>
#include <unistd.h>

using namespace FilterTest;

namespace
{

/// While it lives the process gets no more than so much more address space.
class MemoryLimit
{
public:
  explicit MemoryLimit(rlim_t more)
  {
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    getrlimit(RLIMIT_AS, &this->Before);
    rlimit limit = this->Before;
    limit.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more;
    setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &this->Before); }
  MemoryLimit(const MemoryLimit&) = delete;
  void operator=(const MemoryLimit&) = delete;

private:
  rlimit Before;
};

const rlim_t mega = 1 << 20;

void Prepare(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputData(image);
  filter->SetTissueThreshold(10.0);
  filter->SetMaterialFunction(ConstantMaterial(0.3));
  filter->SetInputDataObject(1, MakeProbes({ { { { 5.0, 5.0, 5.0 } }, { { 1.0, 0.0, 0.0 } }, 2.0 } }));
}

vtkSmartPointer<vtkImageData> MakeScan(int size, int type)
{
  auto image = MakeImage({ { 0, size - 1, 0, size - 1, 0, size - 1 } }, type);
  image->GetPointData()->GetScalars()->Fill(50.0);
  return image;
}

/// Voxels of the whole extent that output 0 announces.
double Announced(vtkChainMailDeformation* filter)
{
  filter->UpdateInformation();
  int extent[6];
  filter->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
  double voxels = 1.0;
  for (int a = 0; a < 3; ++a)
  {
    voxels *= static_cast<double>(extent[2 * a + 1]) - extent[2 * a] + 1.0;
  }
  return voxels;
}

}

int TestChainMailPadding(int, char*[])
{
  Checks check;
  const double limit = 274877906944.0; // 2^38
  const int size = 30;

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);

  {
    auto image = MakeScan(size, VTK_SHORT);
    Prepare(filter, image);
    filter->SetTissueThreshold(std::nan("")); // fitted to the range
    filter->SetOutputPadding(4096);
    check.That(Announced(filter) <= limit, "no more is announced than can be asked for");
    filter->Update();
    const std::string error = log.TakeErrors();
    check.Contains(error, "OutputPadding", "what is wrong");
    check.Contains(error, "4096", "the padding");
    check.Contains(error, "8222 x 8222 x 8222", "the padded size");
    check.Contains(error, "274877906944", "the limit");
    // 6500^3 is less than 2^38, 6502^3 is more.
    check.Contains(error, "3235", "what would fit");
    check.That(SameImage(filter->GetOutput(), image), "the image as it is");
  }
  {
    auto image = MakeScan(size, VTK_SHORT);
    Prepare(filter, image);
    filter->SetOutputPadding(3236);
    filter->Update();
    check.Contains(log.TakeErrors(), "3235", "one more than fits");
    filter->SetOutputPadding(3235);
    check.Equal(Announced(filter), 6500.0 * 6500.0 * 6500.0, "what fits is announced");
    filter->Update();
    const std::string memory = log.TakeErrors(); // 549 GB
    check.Contains(memory, "OutputPadding of 3235", "more than the memory");
    check.Contains(memory, "GB of main memory are free", "more than the memory");
    check.Equal(
      filter->GetOutput()->GetNumberOfPoints(), size * size * size, "more than the memory: the image as it is");
    filter->SetOutputPadding(3);
    check.Equal(Announced(filter), 36.0 * 36.0 * 36.0, "a few");
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "a few are no error");
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), 36 * 36 * 36, "a few");
  }

  // Axes with a single voxel are not padded: what is left is small.
  {
    auto line = MakeImage({ { 0, 9, 0, 0, 0, 0 } });
    line->GetPointData()->GetScalars()->Fill(50.0);
    Prepare(filter, line);
    filter->SetInputDataObject(1, nullptr);
    filter->SetOutputPadding(4096);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "a line");
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), 10 + 2 * 4096, "a line");
  }

  // Extents near the end of what integers count.
  {
    const int most = std::numeric_limits<int>::max();
    for (const bool high : { true, false })
    {
      const int first = high ? most - 12 : -most + 1;
      auto far = MakeImage({ { first, first + 9, 0, 9, 5, 14 } });
      far->GetPointData()->GetScalars()->Fill(50.0);
      vtkNew<vtkChainMailDeformation> there;
      EventLog said(there);
      there->SetInputData(far);
      there->SetTissueThreshold(10.0);
      there->SetOutputPadding(4);
      there->Update();
      const std::string error = said.TakeErrors();
      check.Contains(error, "OutputPadding of 4", "far away: what is wrong");
      check.Contains(error, "2147483646", "far away: the limit");
      check.Contains(error, high ? "Lower OutputPadding to 2 or less" : "Lower OutputPadding to 1 or less",
        "far away: what would fit");
      check.Equal(there->GetOutput()->GetNumberOfPoints(), 1000, "far away: the image as it is");
      there->SetOutputPadding(high ? 2 : 1);
      there->Update();
      check.Equal(said.TakeErrors(), std::string(), "far away: what fits is no error");
      int extent[6];
      there->GetOutput()->GetExtent(extent);
      check.Equal(extent[0], first - (high ? 2 : 1), "far away: first");
      check.Equal(extent[1], first + 9 + (high ? 2 : 1), "far away: last");
    }
  }

  // Memory that cannot be had. Where VTK is not built for release, its own allocation ends the process.
  vtkSMPTools::SetBackend("Sequential"); // no threads, which want memory of their own
  {
    auto image = MakeScan(size, VTK_DOUBLE);
    vtkNew<vtkChainMailDeformation> poor;
    EventLog poorLog(poor);
    Prepare(poor, image);
    poor->Update();
    check.Equal(poorLog.TakeErrors(), std::string(), "without padding");
    {
      const MemoryLimit few(256 * mega);
      poor->SetOutputPadding(200); // 430^3 doubles: 636 MB
      poor->Update();
      check.Contains(poorLog.TakeErrors(), "not enough main memory", "an output that finds no memory");
      check.Equal(poor->GetOutput()->GetNumberOfPoints(), size * size * size, "the last good volume");
      poor->SetOutputPadding(2);
      poor->Update();
      check.Equal(poorLog.TakeErrors(), std::string(), "a smaller one does");
      check.Equal(poor->GetOutput()->GetNumberOfPoints(), 34 * 34 * 34, "a smaller one");
    }
  }
  // The arrays of the model at rest.
  {
    // PoCL's compiler does not survive where it finds no memory, so all kernels are compiled before.
    auto small = MakeScan(size, VTK_UNSIGNED_CHAR);
    vtkNew<vtkChainMailDeformation> first;
    Prepare(first, small);
    first->SetPropagationTimes(true);
    first->Update();
    auto image = MakeScan(320, VTK_UNSIGNED_CHAR);
    vtkNew<vtkChainMailDeformation> poor;
    EventLog poorLog(poor);
    Prepare(poor, image);
    poor->SetPropagationTimes(false);
    poor->Update();
    check.Equal(poorLog.TakeErrors(), std::string(), "without times of propagation");
    const auto times = [&] { return poor->GetModelOutput()->GetPointData()->HasArray("PropagationTime") != 0; };
    {
      const MemoryLimit few(100 * mega);
      poor->SetPropagationTimes(true); // 320^3 floats: 131 MB
      poor->Update();
      check.Contains(poorLog.TakeErrors(), "not enough main memory", "a model that finds no memory");
    }
    poor->Modified();
    poor->Update();
    check.Equal(poorLog.TakeErrors(), std::string(), "with memory it does");
    check.That(times(), "with memory it does");
  }
  return check.Finish();
}
