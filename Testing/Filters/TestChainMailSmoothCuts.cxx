// SPDX-License-Identifier: BSD-3-Clause
// SmoothCuts: at a cut surface numbers mix with the background, each type within its range, and labels, nearest values
// and PullBack do not. The shares themselves are a test of the engine.

#include "FilterTest.h"

#include "vtkFloatArray.h"
#include "vtkTypeInt64Array.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <set>

using namespace FilterTest;

namespace
{

const int size = 24;
const vtkTypeInt64 large = (vtkTypeInt64(1) << 60) + 12345;

/// A rigid block of which an oblique blade cuts off a half, which a probe draws away.
struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 2, size + 1, 0, size - 1, -5, size - 6 } });
  vtkNew<vtkChainMailDeformation> Filter;
  EventLog Log{ Filter };

  Bench()
  {
    vtkPointData* arrays = this->Image->GetPointData();
    Fill(arrays->GetScalars(), this->Image, [](int, int, int) { return 100; });
    const auto add = [&](auto array, const char* name, double value, double atCorner)
    {
      array->SetName(name);
      array->SetNumberOfTuples(this->Image->GetNumberOfPoints());
      array->Fill(value);
      array->SetComponent(0, 0, atCorner); // the smallest value, which is the background's
      arrays->AddArray(array);
    };
    add(vtkSmartPointer<vtkUnsignedCharArray>::New(), "labels", 200, 3);
    add(vtkSmartPointer<vtkFloatArray>::New(), "float", 1.0, -1.0);
    const auto wide = vtkSmartPointer<vtkTypeInt64Array>::New();
    add(wide, "wide", 0, 0);
    for (vtkIdType n = 0; n < wide->GetNumberOfTuples(); ++n)
    {
      wide->SetValue(n, n == 0 ? large - 1000 : large);
    }
    this->Filter->SetInputData(this->Image);
    this->Filter->SetMaterialFunction(ConstantMaterial(0.0));
    this->Filter->SetTissueThreshold(0.0);
    this->Filter->SetBackgroundValue(-1000.0);
    this->Filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    this->Filter->SetRelaxationIterations(0);
    this->Filter->AddLabelArray("labels");
    this->Filter->PullBackOn();
    const auto at = [&](double i, double j, double k)
    {
      const double index[3] = { 2 + i, j, -5 + k };
      Vector place;
      this->Image->TransformContinuousIndexToPhysicalPoint(index, place.data());
      return place;
    };
    this->Filter->SetInputDataObject(
      2, MakeBlade({ at(8.3, -40, -40), at(15.2, 60, -40), at(16.9, 60, 60), at(10.0, -40, 60) }));
    const Vector end = at(size - 1, size - 1, size - 1), away = at(size + 3.4, size - 0.2, size - 1);
    this->Filter->SetInputDataObject(1,
      MakeProbes({ { end, { { away[0] - end[0], away[1] - end[1], away[2] - end[2] } } }, { at(0, 0, 0), Vector{} } }));
  }

  void Update(Checks& check)
  {
    this->Filter->Update();
    check.Equal(this->Log.TakeErrors(), std::string(), "no error");
  }

  std::set<double> Values(const char* name)
  {
    std::set<double> values;
    vtkDataArray* array = this->Filter->GetOutput()->GetPointData()->GetArray(name);
    for (vtkIdType n = 0; array && n < array->GetNumberOfTuples(); ++n)
    {
      values.insert(array->GetComponent(n, 0));
    }
    return values;
  }
};

/// Whether voxels of the background by their labels are those that come from nowhere.
void ExpectNowhere(Checks& check, vtkImageData* output, const std::string& where)
{
  vtkDataArray* labels = output->GetPointData()->GetArray("labels");
  vtkDataArray* back = output->GetPointData()->GetArray("PullBack");
  vtkIdType nowhere = 0;
  vtkIdType differ = 0;
  for (vtkIdType n = 1; n < output->GetNumberOfPoints(); ++n)
  {
    const bool isNowhere = std::isnan(back->GetComponent(n, 0));
    nowhere += isNowhere ? 1 : 0;
    differ += isNowhere != (labels->GetTuple1(n) == 3.0) ? 1 : 0;
  }
  check.That(nowhere > 500, where + ": the gap comes from nowhere");
  check.Equal(differ, vtkIdType(0), where + ": labels and PullBack agree on what is background");
}

}

int TestChainMailSmoothCuts(int, char*[])
{
  Checks check;
  {
    Bench bench;
    check.That(bench.Filter->GetSmoothCuts(), "on by default");
    bench.Update(check);
    const std::set<double> mixed = bench.Values("Scan");
    check.That(mixed.size() > 20, "shorts mix with the background");
    check.That(*mixed.begin() == -1000.0 && *mixed.rbegin() == 100.0, "between the background and tissue");
    check.That(bench.Values("labels") == std::set<double>{ 3.0, 200.0 }, "labels do not");
    const std::set<double> floats = bench.Values("float");
    check.That(floats.size() > 20 && *floats.begin() == -1.0 && *floats.rbegin() == 1.0, "floats mix");
    auto* wide = vtkTypeInt64Array::SafeDownCast(bench.Filter->GetOutput()->GetPointData()->GetArray("wide"));
    std::set<vtkTypeInt64> integers(wide->GetPointer(0), wide->GetPointer(0) + wide->GetNumberOfTuples());
    check.That(integers.size() > 20 && *integers.begin() == large - 1000 && *integers.rbegin() == large,
      "64 bits mix, and keep those that no double has");
    ExpectNowhere(check, bench.Filter->GetOutput(), "smooth");

    // One filter switched on and off gives what fresh ones give.
    Bench stepped;
    stepped.Filter->SmoothCutsOff();
    stepped.Update(check);
    check.That(stepped.Values("Scan") == std::set<double>{ -1000.0, 100.0 }, "off: tissue or none");
    ExpectNowhere(check, stepped.Filter->GetOutput(), "stepped");
    bench.Filter->SmoothCutsOff();
    bench.Update(check);
    check.That(
      SameImage(bench.Filter->GetOutput(), stepped.Filter->GetOutput()), "switched off: the bits of a fresh filter");
    Bench fresh;
    fresh.Update(check);
    bench.Filter->SmoothCutsOn();
    bench.Update(check);
    check.That(
      SameImage(bench.Filter->GetOutput(), fresh.Filter->GetOutput()), "switched on again: the bits of a fresh filter");

    bench.Filter->SetInterpolationToNearest();
    bench.Update(check);
    check.That(bench.Values("Scan") == std::set<double>{ -1000.0, 100.0 }, "nearest values do not mix");
  }
  {
    // Interactive: the probe goes back, and everything is as it was, to the bit.
    Bench bench;
    bench.Filter->SetModeToInteractive();
    bench.Update(check);
    check.That(bench.Values("Scan").size() > 20, "mixed");
    bench.Filter->Reset();
    bench.Update(check);
    check.That(
      SameBits(bench.Filter->GetOutput()->GetPointData()->GetScalars(), bench.Image->GetPointData()->GetScalars()),
      "reset: the input's bits");
  }
  return check.Finish();
}
