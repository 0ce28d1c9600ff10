// SPDX-License-Identifier: BSD-3-Clause
// Rays meet tissue where it is, in images of any place, spacing and direction, and end where the opacity says so.

#include "FilterTest.h"

#include "vtkChainMailTissuePicker.h"

#include "vtkFloatArray.h"
#include "vtkMath.h"

#include <cmath>
#include <limits>

using namespace FilterTest;

namespace
{

/// The world's place of a continuous index.
Vector PlaceOf(vtkImageData* image, double i, double j, double k)
{
  Vector place;
  image->TransformContinuousIndexToPhysicalPoint(i, j, k, place.data());
  return place;
}

/// Where along the first axis, in voxels from the first, a ray from index -8 to 42 meets tissue; -1 where it does not.
double IndexHit(vtkChainMailTissuePicker* picker, vtkImageData* image, double j, double k)
{
  const double share = picker->Pick(image, PlaceOf(image, -8, j, k).data(), PlaceOf(image, 42, j, k).data());
  return share < 0.0 ? -1.0 : -10.0 + 50.0 * share;
}

}

int TestChainMailTissuePicker(int, char*[])
{
  Checks check;
  // Counted from the first voxel: air, from 10 on skin of 3 voxels, from 20 on bone; one voxel that is not finite.
  const auto image = MakeImage({ { 2, 31, -3, 12, 4, 20 } });
  vtkNew<vtkFloatArray> values;
  values->SetName("CT");
  values->SetNumberOfTuples(image->GetNumberOfPoints());
  Fill(values, image, [](int i, int, int) { return i < 10 ? -1000.0 : (i < 13 ? 0.0 : (i < 20 ? 50.0 : 1000.0)); });
  int at[3] = { 5, 0, 10 };
  values->SetValue(image->ComputePointId(at), std::numeric_limits<float>::infinity());
  image->GetPointData()->SetScalars(values);

  vtkNew<vtkChainMailTissuePicker> picker;
  check.That(std::isnan(picker->GetTissueThreshold()), "default TissueThreshold");
  check.Equal(std::string(picker->GetScalars()), std::string(), "default Scalars");
  check.That(picker->GetOpacity() == nullptr, "default Opacity");
  check.Equal(picker->GetOpacityUnitDistance(), 1.0, "default OpacityUnitDistance");

  const double turn = std::sqrt(0.5);
  const double directions[2][9] = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { turn, -turn, 0, 0, 0, -1, turn, turn, 0 } };
  for (const auto& direction : directions)
  {
    image->SetOrigin(5.0, -7.0, 100.0);
    image->SetSpacing(0.5, 2.0, 3.0);
    image->SetDirectionMatrix(direction[0], direction[1], direction[2], direction[3], direction[4], direction[5],
      direction[6], direction[7], direction[8]);
    picker->SetTissueThreshold(vtkMath::Nan());
    picker->SetOpacity(nullptr);
    // The ray is sampled every half voxel, at the nearest voxel: that of index 10 begins at 9.5.
    check.Near(IndexHit(picker, image, 0, 10), 9.75, 0.3, "the threshold of CT is found");
    check.Near(IndexHit(picker, image, -3.4, 20.4), 9.75, 0.3, "within the outermost voxels");
    check.Equal(IndexHit(picker, image, -4, 10), -1.0, "a miss");
    picker->SetTissueThreshold(500.0);
    check.Near(IndexHit(picker, image, 0, 11), 19.75, 0.3, "another threshold");
    picker->SetTissueThreshold(2000.0);
    check.Equal(IndexHit(picker, image, 0, 10), -1.0, "no tissue");

    // Skin of 3 voxels that lets a half pass in 20 voxels; what is below it is invisible, and bone is opaque. Air is as
    // opaque, and counts for nothing.
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(-1000.0, 1.0);
    opacity->AddPoint(-100.0, 1.0 - std::pow(0.5, 0.05));
    opacity->AddPoint(20.0, 1.0 - std::pow(0.5, 0.05));
    opacity->AddPoint(21.0, 0.0);
    opacity->AddPoint(500.0, 0.0);
    opacity->AddPoint(900.0, 1.0);
    picker->SetTissueThreshold(-300.0);
    picker->SetOpacity(opacity);
    picker->SetOpacityUnitDistance(0.5);
    check.Near(IndexHit(picker, image, 0, 10), 19.75, 0.3, "through thin skin to the bone");
    picker->SetOpacityUnitDistance(0.05);
    check.Near(IndexHit(picker, image, 0, 10), 11.5, 0.8, "ten times as opaque");
    opacity->AddPoint(900.0, 0.0);
    opacity->AddPoint(1000.0, 0.0);
    picker->SetOpacityUnitDistance(0.5);
    check.Near(IndexHit(picker, image, 0, 10), 9.75, 0.3, "the first that is seen where nothing is opaque");
  }

  picker->SetOpacity(nullptr);
  picker->SetScalars("nothing of this name");
  check.Equal(IndexHit(picker, image, 0, 10), -1.0, "without scalars");
  picker->SetScalars("CT");
  check.Near(IndexHit(picker, image, 0, 10), 9.75, 0.3, "scalars by name");
  const Vector inside = PlaceOf(image, 15, 0, 10);
  check.That(picker->Pick(image, inside.data(), inside.data()) >= 0.0, "a ray of no length within tissue");
  check.Equal(picker->Pick(nullptr, inside.data(), inside.data()), -1.0, "no image");
  return check.Finish();
}
