// SPDX-License-Identifier: BSD-3-Clause
// The array PullBack says where the material of each voxel was at rest. The oracle is an array of the input that holds
// the place of each voxel: what resampling shows of it is where it took its values from.

#include "FilterTest.h"

#include "vtkFloatArray.h"
#include "vtkSphereSource.h"

using namespace FilterTest;

namespace
{

/// An oblique image of odd spacing whose extent begins anywhere, with a block of tissue in air.
vtkSmartPointer<vtkImageData> MakeOblique()
{
  auto image = MakeImage({ { -3, 20, 5, 24, 2, 19 } });
  PlaceObliquely(image);
  Fill(image->GetPointData()->GetScalars(), image,
    [](int i, int j, int k) { return i > 2 && i < 21 && j > 2 && j < 17 && k > 1 ? 100 : 0; });
  return image;
}

/// The voxel of the input, in air that stays at rest, that has the background's value for a place.
const int marked = 0;

struct Counts
{
  int Moved = 0;
  int Rests = 0;
  int Nowhere = 0;
  int Marked = 0;
};

/// Compares PullBack with Place, voxel by voxel.
Counts Compare(Checks& check, vtkImageData* output, const std::string& where)
{
  Counts counts;
  auto* back = vtkFloatArray::SafeDownCast(output->GetPointData()->GetArray("PullBack"));
  vtkDataArray* place = output->GetPointData()->GetArray("Place");
  check.That(back && back->GetNumberOfComponents() == 3, where + ": three floats");
  for (vtkIdType p = 0; back && p < output->GetNumberOfPoints(); ++p)
  {
    double here[3], way[3], from[3];
    output->GetPoint(p, here);
    back->GetTuple(p, way);
    place->GetTuple(p, from);
    if (std::isnan(way[0]))
    {
      ++counts.Nowhere;
      check.That(std::isnan(way[1]) && std::isnan(way[2]), where + ": NaN is NaN along all axes");
      check.That(from[0] < -1e6, where + ": background where there is NaN");
      continue;
    }
    const bool rests = way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0;
    if (rests && from[0] == -1e9)
    {
      ++counts.Marked;
      continue;
    }
    ++(rests ? counts.Rests : counts.Moved);
    for (int a = 0; a < 3; ++a)
    {
      // Offsets are float32, of up to some 20 voxels in coordinates of some 50 mm.
      check.Near(here[a] + way[a], from[a], 2e-5, where + ": source of voxel " + std::to_string(p));
    }
  }
  return counts;
}

void TestMode(Checks& check, int mode)
{
  auto image = MakeOblique();
  image->GetPointData()->GetArray("Place")->SetTuple3(marked, -1e9, -1e9, -1e9);
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  filter->SetMode(mode);
  filter->SetInputData(image);
  filter->SetMaterialFunction(ConstantMaterial(0.4));
  filter->SmoothCutsOff(); // the places that the oracle shows are not to be mixed
  filter->SetTissueThreshold(10.0);
  filter->SetAnchoredFaces(0, 0, 0, 0, 0, 1);
  filter->SetOutputPadding(4);
  const auto update = [&](const std::string& where)
  {
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), where + ": no error");
    return Compare(check, filter->GetOutput(), where);
  };
  const int voxels = 24 * 20 * 18;
  const int padding = 32 * 28 * 26 - voxels;

  filter->Update();
  check.That(!filter->GetOutput()->GetPointData()->HasArray("PullBack"), "only where it is asked for");
  filter->PullBackOn();
  const Counts atRest = update("at rest");
  check.Equal(atRest.Moved, 0, "at rest: nothing moved");
  check.Equal(atRest.Rests, voxels - 1, "at rest: all of the image");
  check.Equal(atRest.Marked, 1, "at rest: the marked voxel");
  check.Equal(atRest.Nowhere, padding, "at rest: the padding");

  // A pull out of the image, which leaves room behind.
  filter->SetInputDataObject(1, MakeProbes({ { PlaceOfVoxel(image, 12, 10, 3), { { -6.0, 3.0, -9.0 } }, 3.0 } }));
  const Counts pulled = update("pulled");
  check.That(pulled.Moved > 2000, "pulled: tissue moved");
  check.That(pulled.Rests > 1000, "pulled: some air is untouched");
  check.That(pulled.Nowhere != padding, "pulled: some came into the padding, or left the image");

  // Both sides of a cut go their ways, and a ball is drilled out.
  filter->SetInputDataObject(2, MakeBlade({ { PlaceOfVoxel(image, 11.5, -1, -1), PlaceOfVoxel(image, 11.5, 11, -1),
                                  PlaceOfVoxel(image, 11.5, 11, 30), PlaceOfVoxel(image, 11.5, -1, 30) } }));
  vtkNew<vtkSphereSource> ball;
  const Vector centre = PlaceOfVoxel(image, 6, 12, 10);
  ball->SetCenter(centre[0], centre[1], centre[2]);
  ball->SetRadius(3.0);
  ball->Update();
  filter->SetInputDataObject(3, ball->GetOutput());
  filter->SetInputDataObject(1, MakeProbes({ { PlaceOfVoxel(image, 9, 5, 8), { { -5.0, -2.0, 0.5 } }, 2.0 },
                                  { PlaceOfVoxel(image, 14, 5, 8), { { 5.0, 2.0, 0.5 } }, 2.0 } }));
  const Counts cut = update("cut");
  check.That(cut.Nowhere > padding, "cut: there is a gap and a hole");

  // It goes on from what it wrote before, twice, as nobody reads that, and anew where somebody does.
  for (double pull : { 4.0, 3.0, 5.5 })
  {
    filter->SetInputDataObject(1, MakeProbes({ { PlaceOfVoxel(image, 9, 5, 8), { { -pull, -2.0, 0.5 } }, 2.0 } }));
    update("dragged");
    vtkNew<vtkChainMailDeformation> fresh;
    fresh->SetInputData(image);
    fresh->SetMaterialFunction(ConstantMaterial(0.4));
    fresh->SmoothCutsOff();
    fresh->SetTissueThreshold(10.0);
    fresh->SetAnchoredFaces(0, 0, 0, 0, 0, 1);
    fresh->SetOutputPadding(4);
    fresh->PullBackOn();
    fresh->SetInputDataObject(1, filter->GetInputDataObject(1, 0));
    fresh->SetInputDataObject(2, filter->GetInputDataObject(2, 0));
    fresh->SetInputDataObject(3, filter->GetInputDataObject(3, 0));
    fresh->Update();
    check.That(mode == vtkChainMailDeformation::MODE_INTERACTIVE ||
                 SameBits(filter->GetOutput()->GetPointData()->GetArray("PullBack"),
                   fresh->GetOutput()->GetPointData()->GetArray("PullBack")),
      "dragged: as a new filter has it");
  }

  // Through a second filter the first one's array goes as any other, or makes room for its own.
  vtkNew<vtkChainMailDeformation> second;
  second->SetInputConnection(filter->GetOutputPort());
  second->SetMaterialFunction(ConstantMaterial(0.4));
  second->SetTissueThreshold(10.0);
  second->PullBackOn();
  second->Update();
  int backs = 0;
  for (int a = 0; a < second->GetOutput()->GetPointData()->GetNumberOfArrays(); ++a)
  {
    backs += std::string(second->GetOutput()->GetPointData()->GetArrayName(a)) == "PullBack" ? 1 : 0;
  }
  check.Equal(backs, 1, "one array of that name");
  check.Equal(
    second->GetOutput()->GetPointData()->GetArray("PullBack")->GetComponent(5000, 0), 0.0, "the second's own");
}

}

int TestChainMailPullBack(int, char*[])
{
  Checks check;
  TestMode(check, vtkChainMailDeformation::MODE_FROM_REST);
  TestMode(check, vtkChainMailDeformation::MODE_INTERACTIVE);
  return check.Finish();
}
