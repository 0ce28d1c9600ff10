// SPDX-License-Identifier: BSD-3-Clause
// OutputMagnification and OutputBounds. The oracle is an array of the input that holds the place of each voxel, which
// is linear in space: between voxels, too, what resampling shows of it is where it took its values from.

#include "FilterTest.h"

#include "vtkCellData.h"
#include "vtkFloatArray.h"
#include "vtkInformation.h"
#include "vtkIntArray.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace FilterTest;

namespace
{

/// An oblique image of odd spacing whose extent begins anywhere, with a block of tissue in air.
vtkSmartPointer<vtkImageData> MakeOblique(const std::array<int, 6>& extent = { { -3, 20, 5, 24, 2, 19 } })
{
  auto image = MakeImage(extent);
  PlaceObliquely(image);
  Fill(image->GetPointData()->GetScalars(), image,
    [](int i, int j, int) { return i > 2 && i < 21 && j > 2 && j < 17 ? 100 : 0; });
  vtkNew<vtkIntArray> number;
  number->SetName("Number");
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    number->InsertNextValue(static_cast<int>(p));
  }
  image->GetPointData()->AddArray(number);
  return image;
}

void Prepare(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputData(image);
  filter->SetMaterialFunction(ConstantMaterial(0.4));
  filter->SetTissueThreshold(10.0);
  filter->SetAnchoredFaces(0, 0, 0, 0, 0, 1);
  filter->AddLabelArray("Number");
  filter->PullBackOn();
}

void Pull(vtkChainMailDeformation* filter, vtkImageData* image, double far)
{
  filter->SetInputDataObject(1, MakeProbes({ { PlaceOfVoxel(image, 9, 5, 8), { { -far, -2.0, 0.5 } }, 2.0 },
                                  { PlaceOfVoxel(image, 14, 5, 8), { { far, 2.0, 0.5 } }, 2.0 } }));
}

void Cut(vtkChainMailDeformation* filter, vtkImageData* image)
{
  filter->SetInputDataObject(2, MakeBlade({ { PlaceOfVoxel(image, 11.5, -1, -1), PlaceOfVoxel(image, 11.5, 11, -1),
                                  PlaceOfVoxel(image, 11.5, 11, 30), PlaceOfVoxel(image, 11.5, -1, 30) } }));
}

struct Counts
{
  int Moved = 0;
  int Rests = 0;
  int Nowhere = 0;
};

/// Compares all arrays with where PullBack says that they come from.
Counts Compare(Checks& check, vtkImageData* input, vtkImageData* output, bool mixes, const std::string& where)
{
  Counts counts;
  vtkDataArray* back = output->GetPointData()->GetArray("PullBack");
  vtkDataArray* place = output->GetPointData()->GetArray("Place");
  vtkDataArray* number = output->GetPointData()->GetArray("Number");
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    double here[3], way[3], from[3], index[3];
    output->GetPoint(p, here);
    back->GetTuple(p, way);
    place->GetTuple(p, from);
    if (std::isnan(way[0]))
    {
      ++counts.Nowhere;
      check.That(mixes || from[0] <= -40.0, where + ": background where there is NaN");
      continue;
    }
    ++(way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0 ? counts.Rests : counts.Moved);
    for (int a = 0; a < 3; ++a)
    {
      way[a] += here[a];
      check.That(mixes || std::abs(way[a] - from[a]) < 2e-5, where + ": source of voxel " + std::to_string(p));
    }
    input->TransformPhysicalPointToContinuousIndex(way, index);
    int nearest[3];
    bool isTie = false;
    for (int a = 0; a < 3; ++a)
    {
      nearest[a] = static_cast<int>(std::floor(index[a] + 0.5));
      isTie = isTie || std::abs(index[a] + 0.5 - std::floor(index[a] + 0.5)) < 1e-4 ||
              std::abs(index[a] + 0.5 - std::ceil(index[a] + 0.5)) < 1e-4;
    }
    if (!isTie)
    {
      check.Equal(static_cast<vtkIdType>(number->GetComponent(p, 0)), input->ComputePointId(nearest),
        where + ": the label of the nearest voxel");
    }
  }
  return counts;
}

/// What a new filter with the same properties makes of the same inputs.
void CompareWithNew(Checks& check, vtkChainMailDeformation* filter, const std::string& where)
{
  vtkNew<vtkChainMailDeformation> fresh;
  Prepare(fresh, vtkImageData::SafeDownCast(filter->GetInputDataObject(0, 0)));
  TakeInputsAndOutput(fresh, filter);
  fresh->Update();
  for (int a = 0; a < fresh->GetOutput()->GetPointData()->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* expected = fresh->GetOutput()->GetPointData()->GetAbstractArray(a);
    check.That(SameBits(filter->GetOutput()->GetPointData()->GetAbstractArray(expected->GetName()), expected),
      where + ": " + expected->GetName() + " is that of a new filter");
  }
}

/// The part of `whole` that has the extent of `part` has the same values.
void ComparePart(Checks& check, vtkImageData* part, vtkImageData* whole, const std::string& where)
{
  vtkNew<vtkImageData> cut;
  cut->DeepCopy(whole);
  cut->Crop(part->GetExtent());
  for (int a = 0; a < part->GetPointData()->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = part->GetPointData()->GetAbstractArray(a);
    check.That(SameBits(array, cut->GetPointData()->GetAbstractArray(array->GetName())),
      where + ": " + array->GetName() + " is that of the whole");
  }
}

void TestFiner(Checks& check)
{
  auto image = MakeOblique();
  for (int finer : { 2, 3 })
  {
    const std::string times = std::to_string(finer) + " times as fine, ";
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    Prepare(filter, image);
    filter->SmoothCutsOff(); // the places that the oracle shows are not to be mixed
    filter->SetOutputMagnification(finer);
    const auto update = [&](const std::string& what)
    {
      filter->Update();
      check.Equal(log.TakeErrors(), std::string(), times + what + ": no error");
      return Compare(check, image, filter->GetOutput(), filter->GetSmoothCuts(), times + what);
    };
    const int voxels = (23 * finer + 1) * (19 * finer + 1) * (17 * finer + 1);
    const Counts atRest = update("at rest");
    check.Equal(atRest.Rests, voxels, times + "at rest: all of the image");
    check.Equal(atRest.Moved + atRest.Nowhere, 0, times + "at rest: and nothing else");
    double bounds[6], expected[6];
    filter->GetOutput()->GetBounds(bounds);
    image->GetBounds(expected);
    for (int n = 0; n < 6; ++n)
    {
      check.Near(bounds[n], expected[n], 1e-9, times + "the output lies where the input does");
    }

    filter->SetOutputPadding(4);
    Pull(filter, image, 4.0);
    const Counts pulled = update("pulled");
    check.That(pulled.Moved > 1000 * finer * finer * finer, times + "pulled: tissue moved");
    check.That(pulled.Rests > 100 * finer * finer * finer, times + "pulled: some air is untouched");
    Cut(filter, image);
    const Counts cut = update("cut");
    check.That(cut.Nowhere > pulled.Nowhere, times + "cut: there is a gap");
    for (double far : { 3.0, 5.5, 5.0 })
    {
      Pull(filter, image, far);
      update("dragged");
      CompareWithNew(check, filter, times + "dragged");
    }
    filter->SmoothCutsOn();
    update("with smooth cuts");
    CompareWithNew(check, filter, times + "with smooth cuts");

    // Voxels that both have show the same.
    filter->SmoothCutsOff();
    filter->Update();
    vtkNew<vtkImageData> fine;
    fine->DeepCopy(filter->GetOutput());
    filter->SetOutputMagnification(1);
    filter->Update();
    vtkImageData* coarse = filter->GetOutput();
    vtkIdType others = 0;
    for (vtkIdType p = 0; p < coarse->GetNumberOfPoints(); ++p)
    {
      double place[3];
      coarse->GetPoint(p, place);
      const vtkIdType there = fine->FindPoint(place);
      for (const char* name : { "Place", "Number", "PullBack" })
      {
        vtkDataArray* a = coarse->GetPointData()->GetArray(name);
        vtkDataArray* b = fine->GetPointData()->GetArray(name);
        for (int c = 0; c < a->GetNumberOfComponents(); ++c)
        {
          const double x = a->GetComponent(p, c), y = b->GetComponent(there, c);
          others += x == y || (std::isnan(x) && std::isnan(y)) ? 0 : 1;
        }
      }
    }
    check.Equal(others, vtkIdType(0), times + "the voxels of the image show what they show anyway");
  }
}

/// Every type of number interpolates at rest as it does where tissue moves, and padding of scanners stays.
void TestValues(Checks& check)
{
  auto image = MakeImage({ { 0, 9, 0, 7, 0, 0 } }); // one slice stays one
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  Fill(scalars, image, [](int i, int j, int) { return i == 0 ? -3024.0 : 10.0 * i + 7.0 * j; });
  vtkNew<vtkUnsignedCharArray> blank;
  blank->SetName(vtkDataSetAttributes::GhostArrayName());
  blank->SetNumberOfTuples(7 * 9);
  for (vtkIdType cell = 0; cell < 7 * 9; ++cell)
  {
    blank->SetValue(cell, cell == 9 * 3 + 4 ? vtkDataSetAttributes::HIDDENCELL : 0);
  }
  image->GetCellData()->AddArray(blank);
  vtkNew<vtkChainMailDeformation> filter;
  filter->SetInputData(image);
  filter->SetOutputMagnification(2);
  filter->Update();
  vtkImageData* output = filter->GetOutput();
  int dimensions[3];
  output->GetDimensions(dimensions);
  check.That(dimensions[0] == 19 && dimensions[1] == 15 && dimensions[2] == 1, "a slice: 19 x 15 x 1");
  for (int j = 0; j < 15; ++j)
  {
    check.Equal(output->GetScalarComponentAsDouble(0, j, 0, 0), -3024.0, "padding stays");
    for (int i = 3; i < 19; ++i)
    {
      const double expected = std::floor(5.0 * i + 3.5 * j + 0.5);
      check.Equal(output->GetScalarComponentAsDouble(i, j, 0, 0), expected, "between voxels, rounded");
    }
  }
  vtkDataArray* cells = output->GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName());
  check.That(cells && cells->GetNumberOfTuples() == 18 * 14, "the cells, too, are finer");
  for (int j = 0; cells && j < 14; ++j)
  {
    for (int i = 0; i < 18; ++i)
    {
      const bool isBlank = i / 2 == 4 && j / 2 == 3;
      check.Equal(cells->GetComponent(i + 18 * j, 0) != 0.0, isBlank, "a blank cell is four blank cells");
    }
  }
}

void TestBounds(Checks& check)
{
  auto image = MakeOblique();
  for (int finer : { 1, 2 })
  {
    const std::string times = std::to_string(finer) + " times, ";
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    Prepare(filter, image);
    filter->SetOutputPadding(3);
    filter->SetOutputMagnification(finer);
    Cut(filter, image);
    Pull(filter, image, 4.0);
    filter->Update();
    vtkNew<vtkImageData> whole;
    whole->DeepCopy(filter->GetOutput());
    const Vector centre = PlaceOfVoxel(image, 11.2, 6.1, 7.3);
    const auto around = [&](double far)
    {
      filter->SetOutputBounds(
        centre[0] - far, centre[0] + far, centre[1] - far, centre[1] + far, centre[2] - far, centre[2] + far);
    };
    filter->UseOutputBoundsOn();
    for (double far : { 4.0, 0.0, 7.0 })
    {
      around(far);
      filter->Update();
      check.Equal(log.TakeErrors(), std::string(), times + "a box: no error");
      vtkImageData* part = filter->GetOutput();
      check.That(part->GetNumberOfPoints() < whole->GetNumberOfPoints(), times + "a box is a part");
      ComparePart(check, part, whole, times + "a box");
      double bounds[6];
      part->GetBounds(bounds); // of an oblique box, which holds the one that was asked for
      for (int a = 0; a < 3; ++a)
      {
        check.That(bounds[2 * a] <= centre[a] - far + 1e-9 && bounds[2 * a + 1] >= centre[a] + far - 1e-9,
          times + "all of the box is there");
      }
      CompareWithNew(check, filter, times + "a box");
    }
    Pull(filter, image, 5.0);
    filter->Update();
    CompareWithNew(check, filter, times + "a box while tissue is dragged");

    around(1e6);
    filter->Update();
    check.Equal(
      filter->GetOutput()->GetNumberOfPoints(), whole->GetNumberOfPoints(), times + "a huge box is the whole");

    // Pieces.
    around(7.0);
    filter->Update();
    whole->DeepCopy(filter->GetOutput());
    vtkIdType cells = 0;
    for (int piece = 0; piece < 3; ++piece)
    {
      filter->UpdatePiece(piece, 3, 0);
      ComparePart(check, filter->GetOutput(), whole, times + "a piece");
      cells += filter->GetOutput()->GetNumberOfCells();
    }
    check.Equal(cells, whole->GetNumberOfCells(), times + "the pieces are the whole");
  }
}

void TestErrors(Checks& check)
{
  auto image = MakeOblique();
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  Prepare(filter, image);
  Pull(filter, image, 4.0);
  filter->SetOutputMagnification(2);
  filter->UseOutputBoundsOn();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::array<double, 6>& bounds : { std::array<double, 6>{ { 0, 1, 0, 1, 900, 901 } },
         std::array<double, 6>{ { 0, -1, 0, 1, 0, 1 } }, std::array<double, 6>{ { nan, 1, 0, 1, 0, 1 } } })
  {
    // What was shown last stays, and readers are told where it is.
    filter->UseOutputBoundsOff();
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "before");
    vtkNew<vtkImageData> before;
    before->DeepCopy(filter->GetOutput());
    filter->UseOutputBoundsOn();
    filter->SetOutputBounds(bounds.data());
    filter->Update();
    check.Contains(log.TakeErrors(), "OutputBounds", "bounds that are none, or elsewhere");
    check.That(SameImage(filter->GetOutput(), before), "what was shown last");
    int announced[6];
    filter->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), announced);
    check.That(std::equal(announced, announced + 6, before->GetExtent()), "where that is");
    filter->UpdatePiece(1, 2, 0);
    log.TakeErrors();
    ComparePart(check, filter->GetOutput(), before, "a piece of what was shown last");
  }
  // Of another fineness it would be somewhere else than readers think.
  filter->UseOutputBoundsOff();
  filter->SetOutputMagnification(3);
  filter->SetInputDataObject(1, MakeProbes({ { { { 1e6, 0.0, 0.0 } }, { { 1.0, 0.0, 0.0 } }, 2.0 } }));
  filter->Update();
  check.That(!log.TakeErrors().empty(), "a probe in no tissue");
  check.That(SameImage(filter->GetOutput(), image), "the image as it is");
  filter->SetOutputMagnification(2);
  Pull(filter, image, 4.0);
  filter->UseOutputBoundsOff();
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "switched off again");
  check.Equal(filter->GetOutput()->GetNumberOfPoints(), vtkIdType(47) * 39 * 35, "switched off again");

  auto far = MakeImage({ { 600000000, 600000009, 0, 9, 0, 9 } }, VTK_UNSIGNED_CHAR);
  vtkNew<vtkChainMailDeformation> much;
  EventLog muchLog(much);
  much->SetInputData(far);
  much->SetOutputMagnification(4);
  much->Update();
  const std::string error = muchLog.TakeErrors();
  check.Contains(error, "OutputMagnification of 4", "indices that are too large");
  check.Contains(error, "37 x 37 x 37", "how many voxels these would be");
  check.Contains(error, "indices up to 2147483646", "what is possible");
  check.Contains(error, "UseOutputBounds", "what helps");

  // Some terabytes: the error says how much.
  auto wide = MakeImage({ { 0, 299, 0, 299, 0, 299 } }, VTK_UNSIGNED_CHAR);
  vtkNew<vtkDoubleArray> many;
  many->SetName("Many");
  many->SetNumberOfComponents(60);
  many->SetNumberOfTuples(wide->GetNumberOfPoints());
  wide->GetPointData()->AddArray(many);
  much->SetInputData(wide);
  much->Update();
  const std::string memory = muchLog.TakeErrors();
  check.Contains(memory, "GB of main memory are free", "what is there");
  check.Contains(memory, "1197 x 1197 x 1197 voxels, which take", "what it would need");
  check.That(SameImage(much->GetOutput(), wide), "the image as it is");
}

}

int TestChainMailMagnification(int, char*[])
{
  Checks check;
  TestFiner(check);
  TestValues(check);
  TestBounds(check);
  TestErrors(check);
  return check.Finish();
}
