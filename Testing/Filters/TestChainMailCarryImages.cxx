// SPDX-License-Identifier: BSD-3-Clause
// Images go along with a deformation and back: on another grid held against a trilinear interpolation of a model made
// by hand, on the scan's own against what the deformation itself shows of it, with a cut and a carve.

#include "CarryModel.h"

#include "vtkChainMailCarry.h"

#include "vtkDataArraySelection.h"
#include "vtkShortArray.h"
#include "vtkSphereSource.h"

#include <set>

using namespace FilterTest;

namespace
{

/// An image on another grid shows at each voxel the place that the oracle's map takes there.
void TestOtherGrid(Checks& check)
{
  const Model model = RandomBlock(11);
  Space other;
  other.Spacing = { { 0.9, 1.1, 1.3 } };
  other.Direction = { { 0, 0, 1, 1, 0, 0, 0, 1, 0 } };
  other.First = { { -4, -6, -8 } };
  other.Size = { { 30, 28, 26 } };
  const Vector ours = other.World({ { 15, 14, 13 } }), theirs = model.S.World({ { 6, 7, 5 } });
  for (int a = 0; a < 3; ++a)
  {
    other.Origin[a] += theirs[a] - ours[a];
  }
  auto image = other.Image();
  AddPlaces(image);
  vtkNew<vtkFloatArray> field; // a linear one
  field->SetName("Field");
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    const double* x = image->GetPoint(p);
    field->InsertNextValue(static_cast<float>(x[0] + 2 * x[1] - x[2]));
  }
  image->GetPointData()->SetScalars(field);
  auto deformation = model.Image();
  vtkNew<vtkChainMailCarry> carry;
  carry->SetInputData(image);
  carry->SetInputDataObject(1, deformation);
  carry->FitBackgroundOff();
  carry->SetBackgroundValue(-1e6);
  carry->Update();
  auto* now = vtkImageData::SafeDownCast(carry->GetOutputDataObject(0));
  vtkDataArray* place = now->GetPointData()->GetArray("Place");
  vtkDataArray* shown = now->GetPointData()->GetScalars();
  std::vector<Vector> from, to;
  int same = 0, nothing = 0;
  for (vtkIdType p = 0; p < now->GetNumberOfPoints(); ++p)
  {
    double x[3], y[3];
    place->GetTuple(p, x);
    now->GetPoint(p, y);
    if (shown->GetTuple1(p) < -1e5)
    {
      ++nothing;
    }
    else if (x[0] == y[0] && x[1] == y[1] && x[2] == y[2])
    {
      ++same;
    }
    else
    {
      check.Near(shown->GetTuple1(p), x[0] + 2 * x[1] - x[2], 1e-3, "the field at the place");
      from.push_back({ { x[0], x[1], x[2] } });
      to.push_back({ { y[0], y[1], y[2] } });
    }
  }
  check.That(from.size() > 1000 && same > 5000 && nothing > 100, "some moved, some stayed, some is left empty");
  // The oracle, in voxels of the model.
  double worst = 0.0;
  for (std::size_t n = 0; n < from.size(); ++n)
  {
    Vector voxel[2];
    for (int s = 0; s < 2; ++s)
    {
      const Vector& world = s == 0 ? from[n] : to[n];
      for (int b = 0; b < 3; ++b)
      {
        double along = 0.0;
        for (int a = 0; a < 3; ++a)
        {
          along += model.S.Direction[3 * a + b] * (world[a] - model.S.Origin[a]);
        }
        voxel[s][b] = along / model.S.Spacing[b] - model.S.First[b];
      }
    }
    const Vector expected = model.Forward(voxel[0]);
    for (int a = 0; a < 3; ++a)
    {
      worst = std::max(worst, std::fabs(expected[a] - voxel[1][a]));
    }
  }
  check.That(worst < 1e-4, "each voxel shows where its material was"); // SLACK of resample.clh

  // Pieces are those of the whole.
  for (int piece = 0; piece < 3; ++piece)
  {
    vtkNew<vtkChainMailCarry> streamed;
    streamed->SetInputData(image);
    streamed->SetInputDataObject(1, deformation);
    streamed->FitBackgroundOff();
    streamed->SetBackgroundValue(-1e6);
    streamed->UpdatePiece(piece, 3, 0);
    auto* part = vtkImageData::SafeDownCast(streamed->GetOutputDataObject(0));
    check.That(part->GetNumberOfPoints() > 0 && part->GetNumberOfPoints() < now->GetNumberOfPoints(), "a piece");
    vtkNew<vtkImageData> cut;
    cut->DeepCopy(now);
    cut->Crop(part->GetExtent());
    for (const char* name : { "Place", "Field" })
    {
      check.That(SameBits(part->GetPointData()->GetArray(name), cut->GetPointData()->GetArray(name)), "piece: bits");
    }
  }
}

/// On the scan's own grid an image shows what the deformation shows of it, cuts, carves and all.
void TestOwnGrid(Checks& check)
{
  Space space;
  space.Size = { { 24, 20, 18 } };
  auto image = space.Image();
  const auto isTissue = [](int i, int j, int k) { return i > 2 && i < 21 && j > 2 && j < 17 && k > 1; };
  vtkNew<vtkShortArray> scan;
  scan->SetName("Scan");
  vtkNew<vtkUnsignedCharArray> labels;
  labels->SetName("Labels");
  Noise noise(5);
  space.Each(
    [&](int i, int j, int k)
    {
      scan->InsertNextValue(isTissue(i, j, k) ? static_cast<short>(100 + noise.Next() % 100) : 0);
      labels->InsertNextValue(static_cast<unsigned char>((i / 4 + j / 4 + k / 4) % 5));
    });
  image->GetPointData()->SetScalars(scan);
  image->GetPointData()->AddArray(labels);
  AddPlaces(image);
  vtkNew<vtkSphereSource> ball;
  const Vector centre = space.World({ { 6, 12, 10 } });
  ball->SetCenter(centre.data());
  ball->SetRadius(3.0);
  ball->Update();

  vtkNew<vtkChainMailDeformation> deformation;
  EventLog log(deformation);
  deformation->SetInputData(image);
  deformation->SetMaterialFunction(ConstantMaterial(0.4));
  deformation->SmoothCutsOff(); // which is how images are carried
  deformation->SetTissueThreshold(10.0);
  deformation->SetAnchoredFaces(0, 0, 0, 0, 0, 1);
  deformation->AddLabelArray("Labels");
  deformation->PullBackOn();
  deformation->SetInputDataObject(1, MakeProbes({ { space.World({ { 9, 5, 8 } }), { { -5.0, -2.0, 0.5 } }, 2.0 },
                                       { space.World({ { 14, 5, 8 } }), { { 5.0, 2.0, 0.5 } }, 2.0 } }));
  deformation->Update();
  check.That(!deformation->GetModelOutput()->GetPointData()->HasArray("Links"), "no links where nothing is cut");
  deformation->SetInputDataObject(2, MakeBlade({ space.World({ { 11.5, -1, -1 } }), space.World({ { 11.5, 11.5, -1 } }),
                                       space.World({ { 11.5, 11.5, 30 } }), space.World({ { 11.5, -1, 30 } }) }));
  deformation->SetInputDataObject(3, ball->GetOutput());
  deformation->Update();
  check.Equal(log.TakeErrors(), std::string(), "no error");

  // The array that tells of the cut.
  vtkImageData* model = deformation->GetModelOutput();
  vtkDataArray* links = model->GetPointData()->GetArray("Links");
  vtkDataArray* element = model->GetPointData()->GetArray("Element");
  check.That(links && links->GetDataType() == VTK_UNSIGNED_CHAR, "Links");
  int carved = 0, cut = 0, wrong = 0;
  space.Each(
    [&](int i, int j, int k)
    {
      const vtkIdType v = space.Id(i, j, k);
      const auto bits = static_cast<int>(links->GetTuple1(v));
      const bool isElement = element->GetTuple1(v) != 0.0;
      carved += bits == 64;
      wrong += (bits == 64) != (isTissue(i, j, k) && !isElement);
      const bool next = i + 1 < 24 && isElement && element->GetTuple1(space.Id(i + 1, j, k)) != 0.0;
      const bool isCut = i == 11 && j <= 11;
      cut += next && isCut;
      wrong += isElement && ((bits & 2) != 0) != (next && !isCut);
    });
  check.Equal(wrong, 0, "links and carved tissue");
  check.That(carved > 20 && cut > 50, "some carved, some cut");

  vtkNew<vtkChainMailCarry> carry;
  EventLog carryLog(carry);
  carry->SetInputData(image);
  carry->SetDeformationConnection(deformation->GetOutputPort(1));
  carry->AddLabelArray("Labels");
  carry->Update();
  check.Equal(carryLog.TakeErrors() + carryLog.TakeWarnings(), std::string(), "carry: no error");
  auto* carried = vtkImageData::SafeDownCast(carry->GetOutputDataObject(0));
  vtkImageData* own = deformation->GetOutput();
  vtkDataArray* back = own->GetPointData()->GetArray("PullBack");
  vtkDataArray* places[2] = { own->GetPointData()->GetArray("Place"), carried->GetPointData()->GetArray("Place") };
  int moved = 0, different = 0, labelsDiffer = 0, emptied = 0, emptyDiffers = 0;
  space.Each(
    [&](int i, int j, int k)
    {
      const vtkIdType v = space.Id(i, j, k);
      double way[3];
      back->GetTuple(v, way);
      const auto labelOf = [v](vtkImageData* data) { return data->GetPointData()->GetArray("Labels")->GetTuple1(v); };
      const bool isEmpty = std::isnan(way[0]);
      double apart = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        apart = std::max(apart, std::fabs(places[0]->GetComponent(v, a) - places[1]->GetComponent(v, a)));
      }
      // At the border of tissue, where a voxel may follow one or another of its neighbours, some of the air is seen.
      const bool isBorder = own->GetPointData()->GetScalars()->GetTuple1(v) < 100.0;
      emptied += isEmpty;
      emptyDiffers += isEmpty && apart > 0.0;
      moved += !isEmpty && !isBorder && (way[0] != 0.0 || way[1] != 0.0 || way[2] != 0.0);
      different += !isEmpty && !isBorder && apart > 1e-4;
      labelsDiffer += !isEmpty && !isBorder && labelOf(own) != labelOf(carried);
    });
  check.That(moved > 1500 && emptied > 30, "much moved");
  check.Equal(different, 0, "the same places");
  check.Equal(labelsDiffer, 0, "the same labels");
  check.That(emptyDiffers * 50 <= emptied, "the same gaps");
  std::set<double> labelsBefore, labelsAfter;
  for (vtkIdType v = 0; v < image->GetNumberOfPoints(); ++v)
  {
    labelsAfter.insert(carried->GetPointData()->GetArray("Labels")->GetTuple1(v));
    labelsBefore.insert(labels->GetTuple1(v));
  }
  check.That(labelsAfter == labelsBefore, "no label is invented");
  check.That(carried->GetPointData()->GetScalars()->GetDataType() == VTK_SHORT, "each in its own type");

  // Back to rest: what is in tissue is as it was, and what was carved is not.
  vtkNew<vtkChainMailCarry> toRest;
  toRest->SetInputConnection(carry->GetOutputPort());
  toRest->SetDeformationConnection(deformation->GetOutputPort(1));
  toRest->SetDirectionToBackward();
  toRest->Update();
  vtkDataArray* rest = vtkImageData::SafeDownCast(toRest->GetOutputDataObject(0))->GetPointData()->GetArray("Place");
  vtkDataArray* u = model->GetPointData()->GetArray("Displacement");
  int returned = 0, all = 0, hole = 0;
  space.Each(
    [&](int i, int j, int k)
    {
      const vtkIdType v = space.Id(i, j, k);
      double apart = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        apart = std::max(apart, std::fabs(rest->GetComponent(v, a) - image->GetPoint(v)[a]));
      }
      const bool far = std::fabs(u->GetComponent(v, 0)) > 0.05;
      all += element->GetTuple1(v) != 0.0 && far;
      returned += element->GetTuple1(v) != 0.0 && far && apart < 0.3;
      hole += links->GetTuple1(v) == 64 && apart < 0.3;
    });
  check.That(all > 1000 && returned > 0.9 * all, "an image there and back");
  check.Equal(hole, 0, "carved tissue does not come back");

  // Points beside the cut go where their elements go.
  std::vector<Vector> at;
  std::vector<vtkIdType> of;
  space.Each(
    [&](int i, int j, int k)
    {
      if ((i == 11 || i == 12) && element->GetTuple1(space.Id(i, j, k)) != 0.0)
      {
        at.push_back(space.World({ { i + (i == 11 ? 1e-6 : -1e-6), 1.0 * j, 1.0 * k } }));
        of.push_back(space.Id(i, j, k));
      }
    });
  carry->SetInputData(MakePoints(at));
  carry->Update();
  auto* lips = vtkPolyData::SafeDownCast(carry->GetOutputDataObject(0));
  double widest = 0.0;
  for (std::size_t n = 0; n < at.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      check.Near(lips->GetPoint(static_cast<vtkIdType>(n))[a], at[n][a] + u->GetComponent(of[n], a), 2e-5, "a lip");
    }
    widest = std::max(widest, std::fabs(u->GetComponent(of[n], 0)));
  }
  check.That(widest > 1.0, "the cut opens");

  // It goes with the displacements, and where all is mended.
  vtkSmartPointer<vtkDataArray> before = links;
  deformation->GetModelArraySelection()->DisableArray("Displacement");
  deformation->Update();
  check.That(!deformation->GetModelOutput()->GetPointData()->HasArray("Links"), "not without displacements");
  deformation->GetModelArraySelection()->EnableArray("Displacement");
  deformation->Update();
  check.That(SameBits(deformation->GetModelOutput()->GetPointData()->GetArray("Links"), before), "and with them again");
  deformation->SetInputDataObject(2, nullptr);
  deformation->SetInputDataObject(3, nullptr);
  deformation->Update();
  check.That(!deformation->GetModelOutput()->GetPointData()->HasArray("Links"), "nothing is cut any more");
}

}

int TestChainMailCarryImages(int, char*[])
{
  Checks check;
  TestOtherGrid(check);
  TestOwnGrid(check);
  return check.Finish();
}
