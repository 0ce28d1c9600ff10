// SPDX-License-Identifier: BSD-3-Clause
// Regions: balls in which tissue has another constraint. A soft one between two bones makes two bodies of one, a rigid
// one makes bone of muscle; places are in world axes; and the source that makes one.

#include "FilterTest.h"

#include "vtkChainMailRegionSource.h"
#include "vtkDataArraySelection.h"
#include "vtkDoubleArray.h"

using namespace FilterTest;

int TestChainMailRegions(int, char*[])
{
  Checks check;
  vtkNew<vtkChainMailRegionSource> source;
  check.Equal(source->GetRadius(), 0.5, "default Radius");
  check.Equal(source->GetConstraint(), 0.5, "default Constraint");
  source->SetRadius(-1.0);
  check.Equal(source->GetRadius(), 0.0, "Radius from 0");
  source->SetConstraint(1.0);
  check.Equal(source->GetConstraint(), 0.999, "Constraint to 0.999");
  source->SetConstraint(0.5);
  source->SetCenter(1.0, 2.0, 3.0);
  std::ostringstream text;
  source->PrintSelf(text, vtkIndent());
  for (const char* line : { "Center: 1 2 3", "Radius: 0", "Constraint: 0.5" })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }

  // A bone along x that a face holds, in muscle; the image is turned and its voxels are no cubes.
  const auto image = MakeImage({ { 5, 35, -3, 13, 0, 14 } });
  image->SetSpacing(0.5, 1.0, 2.0);
  image->SetOrigin(100.0, -20.0, 7.0);
  const double turn[9] = { 0, -1, 0, 1, 0, 0, 0, 0, 1 };
  image->SetDirectionMatrix(turn);
  Fill(image->GetPointData()->GetScalars(), image,
    [](int, int j, int k) { return std::abs(j - 8) <= 1 && std::abs(k - 7) <= 1 ? 1200 : 50; });
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log{ filter };
  filter->SetInputData(image);
  filter->SetMaterialPresetToCT();
  filter->SetAnchoredFaces(1, 0, 0, 0, 0, 0);
  filter->GetModelArraySelection()->EnableAllArrays();
  const auto placeOf = [&](int i, int j, int k)
  {
    Vector place;
    const int index[3] = { i, j, k };
    image->TransformIndexToPhysicalPoint(index, place.data());
    return place;
  };
  filter->SetInputDataObject(1, MakeProbes({ { placeOf(30, 5, 7), { { 0, 0, 0.3 } } } }));
  const auto reached = [&](const std::string& where)
  {
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), where);
    return Field(filter->GetOutput(), "ProbeReached", 2);
  };
  check.Equal(reached("no region"), 0.0, "the bone is held");

  const Vector middle = placeOf(20, 5, 7);
  source->SetCenter(middle.data());
  source->SetRadius(2.3); // 4 voxels along x, 2 along y and 1 along z
  filter->SetRegionsConnection(source->GetOutputPort());
  check.Near(reached("soft"), 0.3, 1e-6, "a soft region is a joint");
  auto* model = filter->GetModelOutput();
  vtkDataArray* constraints = model->GetPointData()->GetArray("Constraint");
  vtkDataArray* scan = image->GetPointData()->GetScalars();
  for (vtkIdType v = 0; v < image->GetNumberOfPoints(); ++v)
  {
    double place[3];
    image->GetPoint(v, place);
    const double distance = std::sqrt(
      std::pow(place[0] - middle[0], 2) + std::pow(place[1] - middle[1], 2) + std::pow(place[2] - middle[2], 2));
    const bool isBone = scan->GetTuple1(v) > 600;
    const double c = constraints->GetTuple1(v);
    check.That(distance <= 2.3 ? c == 0.5
               : isBone        ? c == 0.0
                               : std::fabs(c - 0.2) < 1e-6,
      "constraint of voxel " + std::to_string(v));
  }

  // A rigid one in the middle of it, connected later, wins; then the bone is one again.
  vtkNew<vtkChainMailRegionSource> bone;
  bone->SetCenter(middle.data());
  bone->SetRadius(2.4);
  bone->SetConstraint(0.0);
  filter->AddRegionsConnection(bone->GetOutputPort());
  check.Equal(reached("rigid"), 0.0, "a rigid region joins bone");
  bone->SetConstraint(0.4);
  check.Near(reached("changed"), 0.3, 1e-6, "a region that changes");
  filter->RemoveAllRegions();
  check.Equal(reached("removed"), 0.0, "without regions");

  // A constraint of -0 is 0: bone, which nobody holds.
  {
    const auto block = MakeImage({ { 0, 10, 0, 8, 0, 8 } });
    block->GetPointData()->GetScalars()->Fill(50.0);
    vtkNew<vtkDoubleArray> fractions;
    fractions->SetName("Fractions");
    fractions->SetNumberOfTuples(block->GetNumberOfPoints());
    vtkNew<vtkPolyData> places;
    vtkNew<vtkPoints> points;
    points->InsertNextPoint(5.0, 4.0, 4.0);
    places->SetPoints(points);
    for (const char* name : { "Radius", "Constraint" })
    {
      vtkNew<vtkDoubleArray> array;
      array->SetName(name);
      array->InsertNextValue(1.0);
      places->GetPointData()->AddArray(array);
    }
    for (const bool byRegion : { true, false })
    {
      for (const double zero : { 0.0, -0.0 })
      {
        vtkNew<vtkChainMailDeformation> free;
        EventLog said{ free };
        fractions->Fill(0.3);
        if (byRegion)
        {
          places->GetPointData()->GetArray("Constraint")->SetTuple1(0, zero);
          free->SetInputDataObject(4, places);
        }
        else
        {
          fractions->SetValue(block->vtkDataSet::FindPoint(5.0, 4.0, 4.0), zero);
          block->GetPointData()->AddArray(fractions);
          free->SetConstraintArray("Fractions");
        }
        free->SetInputData(block);
        free->SetMaterialPresetToCT();
        free->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
        free->SetInputDataObject(1, MakeProbes({ { { { 5, 4, 4 } }, { { 0.5, 0, 0 } } } }));
        free->Update();
        check.Equal(said.TakeErrors() + said.TakeWarnings(), std::string(), "-0");
        check.Equal(Field(free->GetOutput(), "ProbeReached", 0), 0.5, byRegion ? "a region of -0" : "an array with -0");
      }
    }
  }

  // Regions that hold no tissue are named, once.
  {
    filter->SetRegionsConnection(source->GetOutputPort());
    filter->AddRegionsConnection(bone->GetOutputPort());
    const auto warnings = [&](const std::string& where)
    {
      filter->Update();
      check.Equal(log.TakeErrors(), std::string(), where);
      return log.TakeWarnings();
    };
    log.TakeWarnings();
    filter->SetInputDataObject(1, nullptr);
    check.Equal(warnings("in tissue"), std::string(), "in tissue");
    bone->SetCenter(900.0, 0.0, 0.0);
    const std::string outside = warnings("outside");
    check.Contains(outside, "Regions input 1, point 0: no tissue is within the region's radius of 2.4 mm", "outside");
    bone->SetCenter(901.0, 0.0, 0.0);
    check.Equal(warnings("further outside"), std::string(), "once while it moves through air");
    bone->SetCenter(middle.data());
    check.Equal(warnings("back"), std::string(), "back in tissue");
    // Between voxels, which are 0.5 x 1 x 2 mm.
    bone->SetCenter(middle[0] + 0.5, middle[1] + 0.25, middle[2] + 1.0);
    bone->SetRadius(0.5);
    check.Contains(warnings("small"), "radius of 0.5 mm", "a region between voxels");
    filter->RemoveAllRegions();
    check.Equal(warnings("none"), std::string(), "without regions");
  }

  // What is wrong is said.
  vtkNew<vtkPolyData> bare;
  bare->DeepCopy(bone->GetOutput());
  bare->GetPointData()->RemoveArray("Constraint");
  filter->SetInputDataObject(4, bare);
  filter->Update();
  const std::string missing = log.TakeErrors();
  check.Contains(missing, "Regions input 0", "no constraint");
  check.Contains(missing, "\"Constraint\"", "no constraint");
  bare->DeepCopy(bone->GetOutput());
  bare->GetPointData()->GetArray("Constraint")->SetTuple1(0, 1.0);
  bare->Modified();
  filter->Update();
  check.Contains(log.TakeErrors(), "less than 1", "constraint of 1");
  bare->GetPointData()->GetArray("Constraint")->SetTuple1(0, 0.5);
  bare->GetPointData()->GetArray("Radius")->SetTuple1(0, std::nan(""));
  bare->GetPointData()->GetArray("Constraint")->Modified();
  bare->GetPointData()->GetArray("Radius")->Modified();
  bare->Modified();
  filter->Update();
  check.Contains(log.TakeErrors(), "radius", "no radius");
  filter->SetInputDataObject(4, image);
  filter->Update();
  check.That(!log.TakeErrors().empty(), "an image is no region");
  return check.Finish();
}
