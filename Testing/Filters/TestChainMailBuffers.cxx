// SPDX-License-Identifier: BSD-3-Clause
// The deformed volume and the array Displacement lie in memory that is used again, and only what changed is written.
// Nobody may notice: every update shows what a new filter shows, and arrays that somebody still has stay as they were.

#include "FilterTest.h"

#include "vtkFloatArray.h"
#include "vtkShortArray.h"

#include <algorithm>
#include <functional>
#include <set>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

using namespace FilterTest;

namespace
{

vtkSmartPointer<vtkImageData> MakeScan()
{
  auto image = MakeImage({ { 0, 39, 0, 19, 0, 15 } });
  Noise noise(7);
  vtkNew<vtkShortArray> scan;
  scan->SetName("Scan");
  scan->SetNumberOfTuples(image->GetNumberOfPoints());
  Fill(scan, image, [&](int, int, int) { return noise.Next() % 8 == 0 ? 0 : 20 + noise.Next() % 60; });
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("Vectors");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(image->GetNumberOfPoints());
  Fill(vectors, image, [&](int i, int j, int k) { return 0.1 * i - 0.3 * j + 0.7 * k; });
  image->GetPointData()->SetScalars(scan);
  image->GetPointData()->AddArray(vectors);
  return image;
}

void SetUp(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputData(image);
  filter->SetTissueThreshold(10.0);
  filter->SetMaterialFunction(ConstantMaterial(0.3));
  filter->SetRelaxationIterations(3);
  filter->SetBrickSize(8, 4, 4);
}

const Probe left{ { { 8.0, 9.0, 7.0 } }, { { 2.0, 0.6, 0.0 } }, 1.2 };
const Probe right{ { { 31.0, 9.0, 7.0 } }, { { -1.3, 0.0, 0.8 } }, 1.2 };

vtkDataArray* Scan(vtkImageData* image)
{
  return image->GetPointData()->GetArray("Scan");
}

vtkDataArray* Displacement(vtkChainMailDeformation* filter)
{
  return filter->GetModelOutput()->GetPointData()->GetArray("Displacement");
}

/// Whether both of its outputs are those of a filter that begins.
bool IsAsFresh(vtkChainMailDeformation* filter, vtkChainMailDeformation* fresh)
{
  fresh->Update();
  return SameImage(filter->GetOutput(), fresh->GetOutput()) &&
         SameImage(filter->GetModelOutput(), fresh->GetModelOutput());
}

using Change = std::function<void(vtkChainMailDeformation*)>;

/// What is set before each update, for the filter that goes on and for one that begins.
std::vector<std::pair<std::string, Change>> Changes()
{
  const auto probes = [](const std::vector<Probe>& list)
  { return [list](vtkChainMailDeformation* filter) { filter->SetInputDataObject(1, MakeProbes(list)); }; };
  Probe further = right;
  further.Displacement = { { -2.2, 0.5, 0.8 } };
  return { { "a probe", probes({ left }) }, { "another", probes({ left, right }) },
    { "the second goes on", probes({ left, further }) }, { "the first lets go", probes({ further }) },
    { "nothing else", [](vtkChainMailDeformation* filter) { filter->Modified(); } }, { "none is left", probes({}) },
    { "both again", probes({ left, right }) },
    { "padding", [](vtkChainMailDeformation* filter) { filter->SetOutputPadding(3); } },
    { "a probe with padding", probes({ further }) },
    { "a background", [](vtkChainMailDeformation* filter) { filter->SetBackgroundValue(-5.0); } },
    { "nearest", [](vtkChainMailDeformation* filter) { filter->SetInterpolationToNearest(); } },
    { "no padding", [](vtkChainMailDeformation* filter) { filter->SetOutputPadding(0); } },
    { "the other probe", probes({ left }) } };
}

void TestGoingOn(Checks& check, bool keepOutputs)
{
  const auto image = MakeScan();
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  SetUp(filter, image);
  std::vector<std::pair<vtkSmartPointer<vtkImageData>, vtkSmartPointer<vtkImageData>>> outputs;
  const auto changes = Changes();
  for (std::size_t n = 0; n < changes.size(); ++n)
  {
    changes[n].second(filter);
    filter->Update();
    vtkNew<vtkChainMailDeformation> fresh;
    SetUp(fresh, image);
    for (std::size_t m = 0; m <= n; ++m)
    {
      changes[m].second(fresh);
    }
    check.That(IsAsFresh(filter, fresh), changes[n].first);
    for (vtkImageData* output : { filter->GetOutput(), filter->GetModelOutput() })
    {
      if (keepOutputs)
      {
        auto kept = vtkSmartPointer<vtkImageData>::New();
        auto copy = vtkSmartPointer<vtkImageData>::New();
        kept->ShallowCopy(output);
        copy->DeepCopy(output);
        outputs.emplace_back(kept, copy);
      }
    }
  }
  for (std::size_t n = 0; n < outputs.size(); ++n)
  {
    check.That(SameImage(outputs[n].first, outputs[n].second), changes[n / 2].first + ", an output that is kept");
  }
  check.Equal(log.TakeErrors(), std::string(), "no errors");
}

/// The memory of the volume after so many moves of a probe.
void TestReuse(Checks& check)
{
  const auto image = MakeScan();
  vtkSmartPointer<vtkDataArray> last;
  {
    vtkNew<vtkChainMailDeformation> filter;
    SetUp(filter, image);
    Probe probe = left;
    const auto move = [&](vtkChainMailDeformation* one) { one->SetInputDataObject(1, MakeProbes({ probe, right })); };
    const auto expectFresh = [&](const std::string& what)
    {
      vtkNew<vtkChainMailDeformation> fresh;
      SetUp(fresh, image);
      move(fresh);
      check.That(IsAsFresh(filter, fresh), what);
    };
    const auto step = [&]
    {
      probe.Displacement[0] -= 0.13;
      move(filter);
      filter->Update();
      return Scan(filter->GetOutput());
    };
    std::set<void*> memory;
    std::set<void*> displacements;
    for (int n = 0; n < 6; ++n)
    {
      memory.insert(step()->GetVoidPointer(0));
      displacements.insert(Displacement(filter)->GetVoidPointer(0));
    }
    check.Equal(memory.size(), std::size_t(2), "two buffers take turns");
    check.Equal(displacements.size(), std::size_t(2), "two buffers of Displacement take turns");
    expectFresh("six moves");

    // Who writes to an output changes that output alone, whether it is the one on show or not.
    for (int n = 0; n < 3; ++n)
    {
      for (vtkDataArray* array : { step(), Displacement(filter) })
      {
        std::memset(array->GetVoidPointer(0), 0x3a, array->GetNumberOfValues() * array->GetDataTypeSize() / (n + 1));
      }
    }
    step();
    expectFresh("outputs that were written to");

    // An array that shares the values of another has them as long as it lives.
    vtkNew<vtkShortArray> sharing;
    vtkNew<vtkShortArray> copy;
    sharing->ShallowCopy(step());
    copy->DeepCopy(sharing);
    vtkNew<vtkFloatArray> sharingDisplacement;
    vtkNew<vtkFloatArray> copiedDisplacement;
    sharingDisplacement->ShallowCopy(Displacement(filter));
    copiedDisplacement->DeepCopy(sharingDisplacement);
    for (int n = 0; n < 4; ++n)
    {
      step();
    }
    check.Equal(std::memcmp(sharingDisplacement->GetVoidPointer(0), copiedDisplacement->GetVoidPointer(0),
                  copiedDisplacement->GetNumberOfValues() * sizeof(float)),
      0, "displacements that an array of somebody else shares");
    check.Equal(std::memcmp(sharing->GetVoidPointer(0), copy->GetVoidPointer(0),
                  copy->GetNumberOfValues() * copy->GetDataTypeSize()),
      0, "values that an array of somebody else shares");
    last = step();
    copy->DeepCopy(last);
    check.Equal(last->GetNumberOfTuples(), image->GetNumberOfPoints(), "an array that outlives the filter");
  }
  double sum = 0.0;
  for (vtkIdType v = 0; v < last->GetNumberOfTuples(); ++v)
  {
    sum += last->GetTuple1(v);
  }
  check.That(sum > 0.0, "its values outlive the filter, too");
}

#ifdef __linux__
/// The pages of an array that take memory.
std::size_t PagesOf(vtkDataArray* array)
{
  const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t bytes = static_cast<std::size_t>(array->GetNumberOfValues() * array->GetDataTypeSize());
  std::vector<unsigned char> isThere((bytes + size - 1) / size);
  mincore(array->GetVoidPointer(0), bytes, isThere.data());
  return static_cast<std::size_t>(
    std::count_if(isThere.begin(), isThere.end(), [](unsigned char there) { return (there & 1) != 0; }));
}

/// Memory of displacements that are no more is kept for a while, and then goes back to the system.
void TestMemory(Checks& check)
{
  vtkNew<vtkChainMailDeformation> filter;
  SetUp(filter, MakeScan());
  const auto pagesAfter = [&](const std::vector<Probe>& probes)
  {
    filter->SetInputDataObject(1, MakeProbes(probes));
    filter->Modified();
    filter->Update();
    return PagesOf(Displacement(filter));
  };
  check.Equal(pagesAfter({}), std::size_t(0), "nothing has been displaced");
  const std::size_t pulled = pagesAfter({ left, right });
  check.That(pulled > 0, "displacements take memory");
  check.Equal(pagesAfter({ left, right }), pulled, "the other buffer takes as much");
  std::vector<std::size_t> after;
  for (int n = 0; n < 8; ++n)
  {
    after.push_back(pagesAfter({}));
  }
  const std::vector<std::size_t> expected{ pulled, pulled, pulled, pulled, pulled, pulled, 0, 0 };
  check.That(after == expected, "each of the two buffers keeps its pages three times");
}
#endif

}

int TestChainMailBuffers(int, char*[])
{
  Checks check;
  TestGoingOn(check, false);
  TestGoingOn(check, true);
  TestReuse(check);
#ifdef __linux__
  TestMemory(check);
#endif
  return check.Finish();
}
