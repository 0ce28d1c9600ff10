// SPDX-License-Identifier: BSD-3-Clause
// What the filter says in words of its last update.

#include "FilterTest.h"

#include "vtkSphereSource.h"

using namespace FilterTest;

int TestChainMailReport(int, char*[])
{
  Checks check;
  const auto image = MakeImage({ { 0, 16, 0, 16, 0, 16 } });
  Fill(image->GetPointData()->GetScalars(), image, [](int, int, int) { return 100; });
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log{ filter };
  filter->SetInputData(image);
  filter->SetMaterialFunction(ConstantMaterial(0.25));
  filter->SetTissueThreshold(10.0);
  const auto report = [&](const std::vector<FilterTest::Probe>& probes)
  {
    filter->SetInputDataObject(1, MakeProbes(probes));
    filter->Update();
    const std::string text = filter->GetReport();
    check.Equal(std::string(filter->GetReport()), text, "asked twice");
    return text;
  };
  check.Equal(std::string(filter->GetReport()), std::string(), "nothing to say before the first update");

  std::string text = report({});
  check.Contains(text, "Nothing moved; settled", "without probes");

  // Eight links of 0.25 mm lead to the nearest faces.
  text = report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 }, { { { 8, 8, 10 } }, { { -10, 0, 0 } }, 0.0 } });
  check.Contains(text, "Probe 1 reached 1 of 1 mm.\n", "a probe that reached its target");
  check.Contains(text, "Probe 2 reached ", "the second probe");
  check.Contains(text, " of 10 mm: held by Probe 1.\n", "what holds a probe");
  check.Contains(text, " voxels moved; ", "how much moved");
  check.Contains(text, " MB on ", "the memory");
  text = report({ { { { 8, 8, 8 } }, { { 10, 0, 0 } }, 0.0 } });
  check.Contains(text, "Probe 1 reached 2 of 10 mm: held by the face ", "a probe that a face holds");
  check.Contains(text, " of the scan.\n", "a probe that a face holds");

  filter->SetRelaxationIterations(0);
  check.Contains(report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } }), "moved; not relaxed; ", "without relaxation");
  filter->SetRelaxationIterations(1);
  check.Contains(report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } }), "moved; not quite settled after 1 iterations; ",
    "one iteration");
  filter->SetModelReduction(2);
  check.Contains(
    report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } }), " elements of 2 voxels a side moved; ", "a reduced model");
  filter->SetModelReduction(1);

  filter->SetModeToInteractive();
  check.Contains(report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } }), "moved; settling; ", "step by step");
  filter->Reset();
  check.Contains(report({ { { { 8, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } }), "Probe 1 was released by Reset.\n", "Reset");
  check.Equal(log.TakeErrors(), std::string(), "no error so far");

  // Surfaces that remove nothing, by their numbers, as long as they do.
  {
    vtkNew<vtkChainMailDeformation> other;
    EventLog said{ other };
    other->SetInputData(image);
    other->SetMaterialFunction(ConstantMaterial(0.25));
    other->SetTissueThreshold(10.0);
    const auto blade = [](double x)
    {
      return MakeBlade(
        { { { { x, -1.0, -1.0 } }, { { x, 20.0, -1.0 } }, { { x, 20.0, 20.0 } }, { { x, -1.0, 20.0 } } } });
    };
    other->AddInputDataObject(2, blade(4.5));
    other->AddInputDataObject(2, blade(30.0));
    other->AddInputDataObject(2, blade(40.0));
    vtkNew<vtkSphereSource> ball;
    ball->SetCenter(-9.0, 8.0, 8.0);
    ball->Update();
    other->AddInputDataObject(3, ball->GetOutput());
    for (const char* when : { "at first", "again" })
    {
      other->Modified();
      other->Update();
      text = other->GetReport();
      const std::string warnings = said.TakeWarnings();
      check.That(text.find("Cuts input 0 met") == std::string::npos, "a blade in tissue");
      for (const char* name : { "Cuts input 1", "Cuts input 2", "Carves input 0" })
      {
        check.Contains(text, std::string(name) + " met no tissue, or only what was cut before.\n", when);
        check.Equal(warnings.find(name) != std::string::npos, std::string(when) == "at first", when);
      }
    }
    other->RemoveInputConnection(2, 2);
    other->RemoveInputConnection(2, 1);
    other->RemoveAllCarves();
    other->Update();
    check.That(std::string(other->GetReport()).find("met no tissue") == std::string::npos, "without them");
  }

  text = report({ { { { 80, 8, 8 } }, { { 1, 0, 0 } }, 0.0 } });
  check.Contains(log.TakeErrors(), text, "the error");
  check.Contains(text, "holds no tissue", "the error");
  return check.Finish();
}
