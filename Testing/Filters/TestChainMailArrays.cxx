// SPDX-License-Identifier: BSD-3-Clause
// The deformed volume has the point arrays that the input has now: the same names, types and components in the same
// order, the same ones active, and nothing of earlier updates, whatever of the input came, went or changed in between.

#include "FilterTest.h"

#include "vtkDataArraySelection.h"

#include "vtkDataSetAttributes.h"
#include "vtkSignedCharArray.h"

using namespace FilterTest;

namespace
{

/// Numbers for every voxel of the image, of this type.
vtkSmartPointer<vtkDataArray> MakeArray(vtkImageData* image, const char* name, int type, int components = 1)
{
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(image->GetNumberOfPoints());
  Fill(array, image, [](int i, int j, int k) { return 20 + (3 * i + 5 * j + 7 * k) % 60; });
  return array;
}

/// The place of an attribute's active array, -1 where none is active.
int ActiveIndex(vtkPointData* arrays, int attribute)
{
  int indices[vtkDataSetAttributes::NUM_ATTRIBUTES];
  arrays->GetAttributeIndices(indices);
  return indices[attribute];
}

void TestMode(Checks& check, int mode)
{
  auto image = MakeImage({ { 0, 11, 0, 9, 0, 7 } });
  vtkPointData* in = image->GetPointData();
  in->Initialize();
  in->SetScalars(MakeArray(image, "Scan", VTK_SHORT));

  vtkNew<vtkChainMailDeformation> filter;
  filter->GetModelArraySelection()->EnableAllArrays();
  EventLog log(filter);
  filter->SetMode(mode);
  filter->PropagationTimesOn();
  filter->SetInputData(image);
  filter->SetInputDataObject(1, MakeProbes({ { { { 5.0, 4.0, 3.0 } }, { { 1.3, 0.4, 0.0 } } } }));
  filter->SetMaterialFunction(ConstantMaterial(0.3));
  filter->SetTissueThreshold(10.0);

  const auto expectArrays = [&](const std::string& what)
  {
    const std::string where =
      (mode == vtkChainMailDeformation::MODE_FROM_REST ? "from rest, " : "interactive, ") + what;
    vtkPointData* out = filter->GetOutput()->GetPointData();
    check.Equal(log.TakeErrors(), std::string(), where + ": no error");
    check.Equal(out->GetNumberOfArrays(), in->GetNumberOfArrays(), where + ": number of arrays");
    for (int a = 0; a < std::min(in->GetNumberOfArrays(), out->GetNumberOfArrays()); ++a)
    {
      vtkAbstractArray* before = in->GetAbstractArray(a);
      vtkAbstractArray* after = out->GetAbstractArray(a);
      check.Equal(std::string(after->GetName()), before->GetName(), where + ": name");
      check.Equal(after->GetDataType(), before->GetDataType(), where + ": type of " + before->GetName());
      check.Equal(after->GetNumberOfComponents(), before->GetNumberOfComponents(),
        where + ": components of " + before->GetName());
      check.Equal(after->GetNumberOfTuples(), filter->GetOutput()->GetNumberOfPoints(),
        where + ": tuples of " + before->GetName());
    }
    for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
    {
      check.Equal(ActiveIndex(out, attribute), ActiveIndex(in, attribute),
        where + ": active " + vtkDataSetAttributes::GetAttributeTypeAsString(attribute));
    }
    const std::vector<std::string> ofModel{ "Element", "Constraint", "Cluster", "Displacement", "PropagationTime",
      "Wavefront" };
    vtkPointData* model = filter->GetModelOutput()->GetPointData();
    check.Equal(
      model->GetNumberOfArrays(), static_cast<int>(ofModel.size()), where + ": number of arrays of the model at rest");
    for (const std::string& name : ofModel)
    {
      check.That(model->HasArray(name.c_str()), where + ": the model at rest has " + name);
    }
    check.Equal(std::string(model->GetScalars() ? model->GetScalars()->GetName() : "none"), std::string("Displacement"),
      where + ": scalars of the model at rest");
  };
  const auto update = [&](const std::string& what)
  {
    in->Modified();
    image->Modified();
    filter->Update();
    expectArrays(what);
  };

  update("one array");
  in->AddArray(MakeArray(image, "Labels", VTK_UNSIGNED_CHAR));
  update("another comes");
  in->AddArray(MakeArray(image, "Vectors", VTK_DOUBLE, 3));
  in->SetActiveVectors("Vectors");
  update("active vectors come");
  in->RemoveArray("Labels");
  update("the second of three goes");
  in->GetScalars()->SetName("Renamed");
  update("the active one gets another name");
  in->SetScalars(MakeArray(image, "Renamed", VTK_FLOAT));
  update("the active one gets another type");
  in->AddArray(MakeArray(image, "Other", VTK_INT));
  in->SetActiveScalars("Other");
  update("another one becomes active");
  in->RemoveArray("Other");
  in->SetActiveScalars("Renamed");
  update("the active one goes, the first takes its place");
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Renamed");
  in->SetActiveScalars(nullptr);
  update("none is active any more");
  in->AddArray(MakeArray(image, "Scan", VTK_SHORT));
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Scan");
  update("the material reads another one, none is active");
  in->RemoveArray("Renamed");
  update("what was active once is gone");
  in->SetActiveVectors(nullptr);
  in->RemoveArray("Vectors");
  in->AddArray(MakeArray(image, "Vectors", VTK_FLOAT, 2));
  update("an array gets other components");

  // An image of another size with one array of another name.
  auto smaller = MakeImage({ { 2, 9, 0, 7, 0, 7 } });
  smaller->GetPointData()->Initialize();
  smaller->GetPointData()->SetScalars(MakeArray(smaller, "Small", VTK_SIGNED_CHAR));
  image = smaller;
  in = image->GetPointData();
  filter->SetInputData(image);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
  update("another image");

  // An update that fails leaves nothing to the next one, either.
  filter->SetConstraintArray("nowhere");
  filter->Update();
  check.That(!log.TakeErrors().empty(), "an unknown array is an error");
  check.Contains(ErrorOf(filter->GetOutput()), "nowhere", "a failed update says so");
  filter->SetConstraintArray("");
  in->GetScalars()->SetName("Again");
  update("after an error");
}

}

int TestChainMailArrays(int, char*[])
{
  Checks check;
  TestMode(check, vtkChainMailDeformation::MODE_FROM_REST);
  TestMode(check, vtkChainMailDeformation::MODE_INTERACTIVE);
  return check.Finish();
}
