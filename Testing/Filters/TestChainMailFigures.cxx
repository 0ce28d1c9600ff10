// SPDX-License-Identifier: BSD-3-Clause
// Field data that comes with the image, say from another deformation, never passes for figures of this update.

#include "FilterTest.h"

#include "vtkStringArray.h"
#include "vtkUnsignedShortArray.h"

#include <set>

using namespace FilterTest;

namespace
{

std::set<std::string> Names(vtkFieldData* fields)
{
  std::set<std::string> names;
  for (int a = 0; a < fields->GetNumberOfArrays(); ++a)
  {
    names.insert(fields->GetArrayName(a));
  }
  return names;
}

}

int TestChainMailFigures(int, char*[])
{
  Checks check;
  const auto image = MakeImage({ { 0, 12, 0, 8, 0, 8 } });
  Fill(image->GetPointData()->GetScalars(), image, [](int i, int, int) { return i == 6 ? 700 : 50; });
  vtkNew<vtkUnsignedShortArray> labels;
  labels->SetName("Labels");
  labels->SetNumberOfTuples(image->GetNumberOfPoints());
  labels->Fill(3);
  image->GetPointData()->AddArray(labels);
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log{ filter };
  filter->SetInputData(image);
  filter->SetMaterialPresetToCT();
  const auto probes = MakeProbes({ { { { 3, 4, 4 } }, { { 0.25, 0, 0 } } } });
  filter->SetInputDataObject(1, probes);

  // All names that the filter ever writes.
  filter->SetBodyArray("Labels");
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "with bodies");
  std::set<std::string> own = Names(filter->GetOutput()->GetFieldData());
  check.That(own.count("BodyLabel") == 1 && own.count("ProbeForce") == 1, "figures");
  filter->SetBodyArray("");
  filter->Update();
  const std::set<std::string> withoutBodies = Names(filter->GetOutput()->GetFieldData());
  filter->SetInputDataObject(1, MakeProbes({ { { { 300, 4, 4 } }, { { 0.25, 0, 0 } } } }));
  filter->Update();
  check.That(!log.TakeErrors().empty(), "a probe that is nowhere");
  for (const std::string& name : Names(filter->GetOutput()->GetFieldData()))
  {
    own.insert(name);
  }
  check.That(own.count("Error") == 1, "Error is a figure, too");

  // An image that comes with all of them.
  vtkNew<vtkImageData> given;
  given->ShallowCopy(image);
  for (const std::string& name : own)
  {
    vtkNew<vtkStringArray> array;
    array->SetName(name.c_str());
    array->InsertNextValue("of the input");
    given->GetFieldData()->AddArray(array);
  }
  vtkNew<vtkStringArray> patient;
  patient->SetName("Patient");
  patient->InsertNextValue("unknown");
  given->GetFieldData()->AddArray(patient);
  const auto isClean = [&](vtkImageData* output, const std::string& where)
  {
    vtkFieldData* fields = output->GetFieldData();
    check.That(fields->HasArray("Patient") != 0, where + "other field data comes along");
    for (const std::string& name : own)
    {
      auto* text = vtkStringArray::SafeDownCast(fields->GetAbstractArray(name.c_str()));
      check.That(!text || text->GetValue(0) != "of the input", where + name + " of the input is gone");
    }
  };
  filter->SetInputDataObject(1, probes);
  filter->SetInputData(given);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "no error");
  for (vtkImageData* output : { filter->GetOutput(), filter->GetModelOutput() })
  {
    isClean(output, "good: ");
    std::set<std::string> names = Names(output->GetFieldData());
    names.erase("Patient");
    check.That(names == withoutBodies, "good: the figures of this update and no others");
  }

  // Where an update fails that has nothing to show but the image.
  vtkNew<vtkChainMailDeformation> failing;
  EventLog failures{ failing };
  failing->SetInputData(given);
  failing->SetTissueThreshold(1e300);
  failing->Update();
  const std::string error = failures.TakeErrors();
  check.Contains(error, "tissue threshold, 1e+300.", "a number as one writes it");
  isClean(failing->GetOutput(), "failed: ");
  check.Contains(ErrorOf(failing->GetOutput()), "all air", "failed: the error is the filter's own");
  std::set<std::string> names = Names(failing->GetOutput()->GetFieldData());
  check.That(names == std::set<std::string>({ "Error", "Patient" }), "failed: no figures");
  // And then succeeds.
  failing->SetTissueThreshold(0.0);
  failing->Update();
  check.Equal(failures.TakeErrors(), std::string(), "then it is good");
  check.That(!failing->GetOutput()->GetFieldData()->HasArray("Error"), "and the error is gone");

  // One deformation after the other.
  vtkNew<vtkChainMailDeformation> second;
  filter->SetBodyArray("Labels");
  second->SetInputConnection(filter->GetOutputPort());
  second->SetMaterialPresetToCT();
  second->Update();
  names = Names(second->GetOutput()->GetFieldData());
  names.erase("Patient");
  check.That(names == withoutBodies, "the bodies of the first are no bodies of the second");
  check.Equal(
    second->GetOutput()->GetFieldData()->GetArray("ProbeReached")->GetNumberOfTuples(), vtkIdType(0), "nor its probes");
  return check.Finish();
}
