// SPDX-License-Identifier: BSD-3-Clause
// What an update depends on is told by contents. Voxels that are written in place give new tissue, whoever says so;
// equal values in new arrays leave the tissue of Interactive mode as it is; and who writes to an output changes that
// output alone.

#include "FilterTest.h"

#include "vtkFloatArray.h"

using namespace FilterTest;

namespace
{

vtkDataArray* Model(vtkChainMailDeformation* filter, const char* name)
{
  return filter->GetModelOutput()->GetPointData()->GetArray(name);
}

void SetUp(vtkChainMailDeformation* filter, vtkImageData* image, vtkPolyData* probes)
{
  filter->SetInputData(image);
  filter->SetInputDataObject(1, probes);
  filter->SetTissueThreshold(5.0);
  filter->SetMaterialFunction(ConstantMaterial(0.3));
  filter->SetRelaxationIterations(3);
}

}

int TestChainMailContents(int, char*[])
{
  Checks check;
  Noise noise(3);
  auto image = MakeImage({ { 0, 15, 0, 11, 0, 9 } });
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  Fill(scalars, image, [&](int, int, int) { return 10 + noise.Next() % 50; });
  auto probes = MakeProbes({ { { { 8.0, 6.0, 5.0 } }, { { 1.0, 0.4, 0.0 } }, 1.2 } });

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  SetUp(filter, image, probes);
  filter->Update();
  const auto expectFresh = [&](const std::string& what)
  {
    vtkNew<vtkChainMailDeformation> fresh;
    vtkNew<vtkImageData> copy;
    copy->DeepCopy(image);
    SetUp(fresh, copy, probes);
    fresh->SetConstraintArray(filter->GetConstraintArray());
    fresh->Update();
    check.That(SameImage(filter->GetOutput(), fresh->GetOutput()), what + ": the volume");
    check.That(SameImage(filter->GetModelOutput(), fresh->GetModelOutput()), what + ": the model");
  };

  // A hole beside the probe, made in place. Told by the array, by the image alone, and by nobody but another change.
  const auto drill = [&](double x) { scalars->SetTuple1(image->vtkDataSet::FindPoint(x, 6.0, 7.0), 0.0); };
  drill(6.0);
  scalars->Modified();
  filter->Update();
  check.Equal(Model(filter, "Element")->GetTuple1(image->vtkDataSet::FindPoint(6.0, 6.0, 7.0)), 0.0, "a hole");
  expectFresh("the array says that it changed");
  drill(8.0);
  image->Modified();
  filter->Update();
  check.Equal(Model(filter, "Element")->GetTuple1(image->vtkDataSet::FindPoint(8.0, 6.0, 7.0)), 0.0, "another hole");
  expectFresh("the image says that it changed");
  vtkNew<vtkFloatArray> fractions;
  fractions->SetName("Fractions");
  fractions->SetNumberOfTuples(image->GetNumberOfPoints());
  fractions->Fill(0.25);
  image->GetPointData()->AddArray(fractions);
  filter->SetConstraintArray("Fractions");
  filter->Update();
  expectFresh("a constraint array");
  fractions->SetValue(image->vtkDataSet::FindPoint(9.0, 6.0, 5.0), 0.05f);
  image->Modified();
  filter->Update();
  expectFresh("constraints written in place");

  // Equal values in other arrays: the tissue goes on from where it was, step by step with a filter that keeps its
  // arrays.
  vtkNew<vtkChainMailDeformation> kept;
  vtkNew<vtkImageData> same;
  same->DeepCopy(image);
  SetUp(kept, same, probes);
  kept->SetConstraintArray("Fractions");
  for (vtkChainMailDeformation* one : { filter.Get(), kept.Get() })
  {
    one->SetModeToInteractive();
    one->Update();
  }
  for (int step = 0; step < 4; ++step)
  {
    vtkNew<vtkImageData> again;
    again->DeepCopy(image);
    filter->SetInputData(again);
    probes->GetPointData()->GetArray("Displacement")->SetTuple3(0, 1.5 + step, -0.3, 0.2 * step);
    probes->Modified();
    filter->Update();
    kept->Update();
    check.That(SameImage(filter->GetModelOutput(), kept->GetModelOutput()), "step " + std::to_string(step));
    check.Equal(Field(filter->GetOutput(), "Milliseconds", UPLOAD), 0.0, "nothing is built anew");
  }
  // The same voxels in another type are other tissue, for all that can be told.
  vtkNew<vtkImageData> floats;
  floats->DeepCopy(image);
  vtkNew<vtkFloatArray> converted;
  converted->DeepCopy(scalars);
  floats->GetPointData()->SetScalars(converted);
  filter->SetInputData(floats);
  filter->Update();
  check.That(Field(filter->GetOutput(), "Milliseconds", UPLOAD) > 0.0, "another type is built anew");

  // Nothing changed at all, though the image says so: no step, so that all who ask see the same.
  const double energy = Field(kept->GetOutput(), "Energy");
  same->Modified();
  kept->Update();
  check.Equal(Field(kept->GetOutput(), "Energy"), energy, "the same contents are no step");
  kept->Modified();
  kept->Update();
  check.That(Field(kept->GetOutput(), "Energy") < energy, "who wants one says so to the filter");

  // Writing to the outputs.
  filter->SetModeToFromRest();
  filter->SetInputData(image);
  filter->Update();
  vtkPointData* model = filter->GetModelOutput()->GetPointData();
  for (int a = 0; a < model->GetNumberOfArrays(); ++a)
  {
    vtkDataArray* array = model->GetArray(a);
    std::memset(array->GetVoidPointer(0), 0x3a, array->GetNumberOfValues() * array->GetDataTypeSize());
  }
  filter->SetBackgroundValue(-7.0); // another picture of the same tissue
  filter->Update();
  filter->SetBackgroundValue(0.0);
  vtkNew<vtkChainMailDeformation> clean;
  SetUp(clean, image, probes);
  clean->SetConstraintArray("Fractions");
  clean->Update();
  check.That(SameImage(filter->GetModelOutput(), clean->GetModelOutput()), "the model after somebody wrote to it");
  check.Equal(log.TakeErrors(), std::string(), "no errors");
  return check.Finish();
}
