// SPDX-License-Identifier: BSD-3-Clause
// ScalarSmoothing, against the sum over all voxels around one; and, to the bit, against a new filter.

#include "FilterTest.h"

#include "vtkFloatArray.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace FilterTest;

namespace
{

/// An image of odd spacing with a block of tissue in air, whose values vary from voxel to voxel.
vtkSmartPointer<vtkImageData> MakeScan(int type)
{
  auto image = MakeImage({ { -3, 76, 5, 54, 2, 41 } }, type);
  image->SetSpacing(1.5, 0.75, 2.0);
  Noise random(7);
  Fill(image->GetPointData()->GetScalars(), image,
    [&](int i, int j, int)
    {
      const bool isTissue = i > 4 && i < 75 && j > 3 && j < 46;
      return std::floor(isTissue ? 60.0 + 140.0 * random.Uniform() : 10.0 * random.Uniform());
    });
  return image;
}

void Prepare(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputData(image);
  filter->SetMaterialFunction(ConstantMaterial(0.3)); // so that a pull reaches a part of the image
  filter->SetTissueThreshold(30.0);
  filter->SetBackgroundValue(0.0);
  filter->SetScalarSmoothing(0.75);
}

void Pull(vtkChainMailDeformation* filter, vtkImageData* image, double far, const Vector& voxel = { { 12, 6, 8 } })
{
  filter->SetInputDataObject(
    1, MakeProbes({ { PlaceOfVoxel(image, voxel[0], voxel[1], voxel[2]), { { -far, -far / 2, 0.5 } }, 2.0 } }));
}

vtkDataArray* Smoothed(vtkChainMailDeformation* filter)
{
  return filter->GetOutput()->GetPointData()->GetArray("Scan smooth");
}

/// The mean over the voxels around each, weighted by a Gaussian of some output voxels.
void Compare(Checks& check, vtkChainMailDeformation* filter, double deviation, double padding, const std::string& where)
{
  vtkImageData* output = filter->GetOutput();
  vtkDataArray* scalars = output->GetPointData()->GetScalars();
  vtkDataArray* smooth = Smoothed(filter);
  check.That(smooth && smooth->GetDataType() == VTK_FLOAT, where + ": there are smoothed scalars");
  check.Equal(std::string(scalars->GetName()), std::string("Scan"), where + ": the active scalars");
  int size[3];
  output->GetDimensions(size);
  const int radius = static_cast<int>(3.0 * deviation);
  std::vector<double> gauss; // by the square of the distance
  for (int far = 0; far <= 3 * radius * radius; ++far)
  {
    gauss.push_back(std::exp(-0.5 * far / (deviation * deviation)));
  }
  const auto isKnown = [&](double value) { return std::isfinite(value) && value != padding; };
  const auto at = [&](int i, int j, int k) { return i + size[0] * (j + size[1] * static_cast<vtkIdType>(k)); };
  std::vector<double> values;
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    values.push_back(scalars->GetComponent(p, 0));
  }
  double worst = 0.0;
  vtkIdType others = 0;
  for (int k = 0; k < size[2] && smooth; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      for (int i = 0; i < size[0]; ++i)
      {
        const double itself = values[at(i, j, k)];
        const double found = smooth->GetComponent(at(i, j, k), 0);
        if (!isKnown(itself))
        {
          others += found == itself || (std::isnan(found) && std::isnan(itself)) ? 0 : 1;
          continue;
        }
        double sum = 0.0;
        double weights = 0.0;
        for (int z = std::max(k - radius, 0); z <= std::min(k + radius, size[2] - 1); ++z)
        {
          for (int y = std::max(j - radius, 0); y <= std::min(j + radius, size[1] - 1); ++y)
          {
            for (int x = std::max(i - radius, 0); x <= std::min(i + radius, size[0] - 1); ++x)
            {
              const double value = values[at(x, y, z)];
              if (isKnown(value))
              {
                const int far = (x - i) * (x - i) + (y - j) * (y - j) + (z - k) * (z - k);
                const double weight = gauss[static_cast<std::size_t>(far)];
                sum += weight * value;
                weights += weight;
              }
            }
          }
        }
        worst = std::max(worst, std::isfinite(found) ? std::fabs(found - sum / weights) : 1e9);
      }
    }
  }
  check.Near(worst, 0.0, 2e-4, where + ": the smoothed values"); // three sums of floats of up to 200
  check.Equal(others, vtkIdType(0), where + ": what is not known stays");
}

/// What a new filter with the same properties makes of the same inputs.
void CompareWithNew(Checks& check, vtkChainMailDeformation* filter, const std::string& where)
{
  vtkNew<vtkChainMailDeformation> fresh;
  Prepare(fresh, vtkImageData::SafeDownCast(filter->GetInputDataObject(0, 0)));
  TakeInputsAndOutput(fresh, filter);
  fresh->Update();
  check.That(SameBits(Smoothed(filter), Smoothed(fresh)), where + ": as a new filter makes them");
}

/// Updates that change a part smooth that part, and no update is seen in the one before.
void TestUpdates(Checks& check)
{
  const auto image = MakeScan(VTK_SHORT);
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  Prepare(filter, image);
  const auto update = [&](const std::string& what)
  {
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), what + ": no error");
    Compare(check, filter, 0.75 * filter->GetOutputMagnification(), -1e9, what);
    CompareWithNew(check, filter, what);
  };
  update("at rest");
  vtkSmartPointer<vtkDataArray> atRest = Smoothed(filter);
  vtkNew<vtkFloatArray> kept;
  kept->DeepCopy(atRest);
  for (const double far : { 4.0, 6.0, -3.0, 0.0, 5.0 })
  {
    Pull(filter, image, far);
    update("pulled by " + std::to_string(far));
  }
  // Where what changes ends beside a tile of those that are done anew, and elsewhere.
  Noise random(3);
  for (int n = 0; n < 12; ++n)
  {
    const auto within = [&](double low, double high) { return std::floor(low + (high - low) * random.Uniform()); };
    Pull(filter, image, 2.0, { { within(6, 74), within(5, 45), within(1, 39) } });
    filter->Update();
    CompareWithNew(check, filter, "pulled elsewhere");
  }
  check.That(SameBits(atRest, kept), "who keeps an array keeps its values");
  filter->SetInputDataObject(2, MakeBlade({ PlaceOfVoxel(image, 20.5, -1, -1), PlaceOfVoxel(image, 21.5, 18, -1),
                                  PlaceOfVoxel(image, 21.5, 18, 30), PlaceOfVoxel(image, 20.5, -1, 30) }));
  update("cut");
  // Somebody downstream writes to it.
  Smoothed(filter)->SetComponent(4000, 0, 1e6);
  Pull(filter, image, 5.5);
  update("written to");
  Pull(filter, image, 5.0);
  update("written to, the other array");
  image->GetPointData()->GetScalars()->SetComponent(5000, 0, 99);
  image->GetPointData()->GetScalars()->Modified();
  image->Modified();
  update("an edited scan");
  filter->SetOutputPadding(3);
  update("padded");
  filter->SetOutputMagnification(2);
  update("twice as fine");
  const Vector middle = PlaceOfVoxel(image, 15, 9, 8);
  filter->SetOutputBounds(middle[0] - 9, middle[0] + 9, middle[1] - 5, middle[1] + 5, middle[2] - 7, middle[2] + 7);
  filter->UseOutputBoundsOn();
  update("a box of it");
  filter->SetScalarSmoothing(0.5);
  filter->Update();
  Compare(check, filter, 1.0, -1e9, "another deviation");
  CompareWithNew(check, filter, "another deviation");
}

/// All types; values that count for no other voxel.
void TestValues(Checks& check)
{
  for (const int type : { VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_FLOAT, VTK_DOUBLE, VTK_LONG_LONG })
  {
    const auto image = MakeScan(type);
    const bool isFloat = type == VTK_FLOAT || type == VTK_DOUBLE;
    vtkDataArray* scalars = image->GetPointData()->GetScalars();
    for (vtkIdType p = 3000; p < 3010 && isFloat; ++p)
    {
      scalars->SetComponent(p, 0, p % 2 ? std::numeric_limits<double>::quiet_NaN() : HUGE_VAL);
    }
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    Prepare(filter, image);
    const std::string name = scalars->GetDataTypeAsString();
    filter->Update();
    Compare(check, filter, 0.75, -1e9, name + " at rest");
    Pull(filter, image, 4.0);
    filter->Update();
    Compare(check, filter, 0.75, -1e9, name + " pulled");
    check.Equal(log.TakeErrors(), std::string(), name + ": no error");
  }
  // What a scanner writes outside its field of view.
  const auto image = MakeScan(VTK_SHORT);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    const bool isOutside = p % 80 < 3;
    scalars->SetComponent(p, 0, isOutside ? -3024.0 : scalars->GetComponent(p, 0) - 100.0);
  }
  vtkNew<vtkChainMailDeformation> filter;
  Prepare(filter, image);
  filter->SetTissueThreshold(-70.0);
  filter->SetBackgroundValue(-100.0);
  Pull(filter, image, 3.0);
  filter->Update();
  Compare(check, filter, 0.75, -3024.0, "padding of a scanner");
  check.That(Smoothed(filter)->GetRange()[0] == -3024.0, "the padding stays");
}

/// When there is such an array.
void TestWhen(Checks& check)
{
  const auto image = MakeScan(VTK_SHORT);
  vtkNew<vtkFloatArray> old;
  old->SetName("Scan smooth"); // of a deformation before this one
  old->SetNumberOfTuples(image->GetNumberOfPoints());
  old->Fill(-5.0);
  image->GetPointData()->AddArray(old);
  vtkNew<vtkChainMailDeformation> filter;
  Prepare(filter, image);
  filter->SetScalarSmoothing(0.0);
  filter->Update();
  check.Equal(Smoothed(filter)->GetComponent(0, 0), -5.0, "without: an array like others");
  filter->SetScalarSmoothing(0.75);
  filter->Update();
  check.Equal(filter->GetOutput()->GetPointData()->GetNumberOfArrays(), 2, "with: in its place");
  Compare(check, filter, 0.75, -1e9, "with");
  image->GetPointData()->RemoveArray("Scan smooth");
  const auto expectTheSame = [&](const std::string& what)
  {
    filter->Update();
    vtkDataArray* scalars = filter->GetOutput()->GetPointData()->GetScalars();
    bool same = Smoothed(filter) != nullptr;
    for (vtkIdType p = 0; same && p < scalars->GetNumberOfTuples(); ++p)
    {
      same = scalars->GetComponent(p, 0) == Smoothed(filter)->GetComponent(p, 0);
    }
    check.That(same, what + " are not smoothed");
  };
  filter->SetInterpolationToNearest();
  expectTheSame("nearest values");
  filter->SetInterpolationToLinear();
  filter->AddLabelArray("Scan");
  expectTheSame("labels");
  filter->ClearLabelArrays();
  filter->Update();
  Compare(check, filter, 0.75, -1e9, "no labels any more");
  filter->SetScalarSmoothing(0.1); // reaches no other voxel
  expectTheSame("values with a narrow Gaussian");
  filter->SetScalarSmoothing(99.0);
  check.Equal(filter->GetScalarSmoothing(), 2.0, "at most 2");
}

}

int TestChainMailSmoothScalars(int, char*[])
{
  Checks check;
  TestUpdates(check);
  TestValues(check);
  TestWhen(check);
  return check.Finish();
}
