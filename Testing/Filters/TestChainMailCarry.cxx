// SPDX-License-Identifier: BSD-3-Clause
// Meshes and points go along with a deformation and back. The oracles are maps that are known in closed form and a
// trilinear interpolation of its own, on models made by hand.

#include "CarryModel.h"

#include "vtkChainMailCarry.h"

#include "vtkCellData.h"
#include "vtkErrorCode.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkPlaneSource.h"
#include "vtkRectilinearGrid.h"
#include "vtkStructuredGrid.h"
#include "vtkUnstructuredGrid.h"

#include <random>

using namespace FilterTest;

namespace
{

/// Carries points, given in voxels of the model, and gives the result in voxels.
std::vector<Vector> Carry(Checks& check, const Model& model, const std::vector<Vector>& voxels, bool backward = false)
{
  std::vector<Vector> places;
  for (const Vector& voxel : voxels)
  {
    places.push_back(model.S.World(voxel));
  }
  vtkNew<vtkChainMailCarry> carry;
  EventLog log(carry);
  carry->SetInputData(MakePoints(places));
  auto image = model.Image();
  carry->SetInputDataObject(1, image);
  carry->SetDirection(backward ? vtkChainMailCarry::DIRECTION_BACKWARD : vtkChainMailCarry::DIRECTION_FORWARD);
  carry->Update();
  check.Equal(log.TakeErrors(), std::string(), "no error");
  vtkPolyData* output = vtkPolyData::SafeDownCast(carry->GetOutputDataObject(0));
  std::vector<Vector> result;
  for (vtkIdType n = 0; n < output->GetNumberOfPoints(); ++n)
  {
    // Back by the transposed direction, as the model's axes are at right angles.
    Vector at;
    double world[3];
    output->GetPoint(n, world);
    for (int b = 0; b < 3; ++b)
    {
      double along = 0.0;
      for (int a = 0; a < 3; ++a)
      {
        along += model.S.Direction[3 * a + b] * (world[a] - model.S.Origin[a]);
      }
      at[b] = along / model.S.Spacing[b] - model.S.First[b];
    }
    result.push_back(at);
  }
  check.Equal(result.size(), voxels.size(), "as many points");
  return result;
}

double Farthest(const std::vector<Vector>& a, const std::vector<Vector>& b)
{
  double most = 0.0;
  for (std::size_t n = 0; n < a.size() && n < b.size(); ++n)
  {
    for (int c = 0; c < 3; ++c)
    {
      most = std::isfinite(a[n][c]) ? std::max(most, std::fabs(a[n][c] - b[n][c])) : 1e9;
    }
  }
  return most;
}

std::vector<Vector> RandomVoxels(std::size_t count, const Vector& low, const Vector& high, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Vector> voxels(count);
  for (Vector& voxel : voxels)
  {
    for (int a = 0; a < 3; ++a)
    {
      voxel[a] = low[a] + share(random) * (high[a] - low[a]);
    }
  }
  return voxels;
}

void TestInterpolation(Checks& check)
{
  const Model model = RandomBlock(1);
  const Vector end{ { model.S.Size[0] - 1.0, model.S.Size[1] - 1.0, model.S.Size[2] - 1.0 } };
  const std::vector<Vector> rest = RandomVoxels(100000, { { 0, 0, 0 } }, end, 2);
  std::vector<Vector> expected;
  for (const Vector& x : rest)
  {
    expected.push_back(model.Forward(x));
  }
  const std::vector<Vector> now = Carry(check, model, rest);
  // The model's displacements are float32, of up to 10 mm in voxels of 0.75 mm or more.
  check.That(Farthest(now, expected) < 3e-6, "trilinear between elements");
  check.That(Farthest(now, rest) > 3.0, "they moved");
  check.That(Farthest(Carry(check, model, now, true), rest) < 1e-8, "there and back");
  Model linked = model;
  linked.LinkAll();
  check.Equal(Farthest(Carry(check, linked, rest), now), 0.0, "links that are all there change nothing");
}

/// Two halves of a block part, and each takes its own side along.
void TestCut(Checks& check)
{
  Model model{ Space() };
  model.LinkAll();
  model.CutAcrossX(5);
  const Vector left{ { -2.0, 0.5, 0.25 } }, right{ { 3.0, 0.0, -0.5 } };
  model.S.Each([&](int i, int j, int k) { model.U[model.S.Id(i, j, k)] = i <= 5 ? left : right; });
  const std::vector<Vector> rest = RandomVoxels(20000, { { 4.0, 1.0, 1.0 } }, { { 7.0, 12.0, 8.0 } }, 3);
  std::vector<Vector> expected = rest;
  for (Vector& x : expected)
  {
    const Vector& u = x[0] <= 5.5 ? left : right;
    for (int a = 0; a < 3; ++a)
    {
      x[a] += u[a];
    }
  }
  const std::vector<Vector> now = Carry(check, model, rest);
  check.That(Farthest(now, expected) < 3e-6, "each side goes its own way, up to the cut");
  check.That(Farthest(Carry(check, model, now, true), rest) < 1e-6, "and back");
  // What lies in the gap, from 3.5 to 8.5, goes with the lip that is nearer: that is 5 + left or 6 + right.
  const std::vector<Vector> gap = { { { 4.2, 6.0, 5.0 } }, { { 8.0, 6.0, 5.0 } } };
  const std::vector<Vector> closed = Carry(check, model, gap, true);
  for (int a = 0; a < 3; ++a)
  {
    check.Near(closed[0][a], gap[0][a] - left[a], 1e-5, "the left of the gap");
    check.Near(closed[1][a], gap[1][a] - right[a], 1e-5, "the right of the gap");
  }
  // Where nobody says that there is a cut, tissue is stretched.
  model.Links.clear();
  const std::vector<Vector> stretched = Carry(check, model, { { { 5.5, 6.0, 5.0 } } });
  check.Near(stretched[0][0], 5.5 + 0.5 * (left[0] + right[0]), 1e-5, "without links a mean of both sides");
}

/// A partial cut: around its end tissue hangs together, and the map is continuous there.
void TestEndOfCut(Checks& check)
{
  Model model{ Space() };
  model.LinkAll();
  model.S.Each(
    [&](int i, int j, int k)
    {
      if (j < 7)
      {
        model.Links[model.S.Id(i, j, k)] &= i == 5 ? ~2 : i == 6 ? ~1 : ~0;
      }
      const double open = std::max(0.0, 0.25 * (7 - j));
      model.U[model.S.Id(i, j, k)] = { { i <= 5 ? -open : open, 0.0, 0.0 } };
    });
  std::vector<Vector> rest;
  for (const Vector& x : RandomVoxels(20000, { { 2.0, 1.0, 1.0 } }, { { 9.0, 12.0, 8.0 } }, 4))
  {
    if (std::fabs(x[0] - 5.5) > 0.01 || x[1] > 7.0)
    {
      rest.push_back(x);
    }
  }
  const std::vector<Vector> now = Carry(check, model, rest);
  bool parts = true;
  for (std::size_t n = 0; n < rest.size(); ++n)
  {
    if (rest[n][1] < 6.0)
    {
      parts = parts && (rest[n][0] < 5.5 ? now[n][0] <= rest[n][0] : now[n][0] >= rest[n][0]);
    }
  }
  check.That(parts, "no side is drawn to the other");
  check.That(Farthest(Carry(check, model, now, true), rest) < 1e-3, "there and back beside a cut that ends");
}

/// A lump in air that moves as a whole takes along what is around it.
void TestAir(Checks& check)
{
  Model model{ Space() };
  const Vector shift{ { 1.5, -2.25, 0.75 } };
  model.S.Each(
    [&](int i, int j, int k)
    {
      const bool isTissue = i > 3 && i < 8 && j > 4 && j < 9 && k > 2 && k < 6;
      model.Element[model.S.Id(i, j, k)] = isTissue;
      model.U[model.S.Id(i, j, k)] = isTissue ? shift : Vector{ { 0, 0, 0 } };
    });
  std::vector<Vector> rest = RandomVoxels(5000, { { -30, -30, -30 } }, { { 40, 40, 40 } }, 5);
  std::vector<Vector> expected = rest;
  for (Vector& x : expected)
  {
    for (int a = 0; a < 3; ++a)
    {
      x[a] += shift[a];
    }
  }
  check.That(Farthest(Carry(check, model, rest), expected) < 3e-6, "air goes along");
  check.That(Farthest(Carry(check, model, expected, true), rest) < 3e-6, "air goes back");

  // Without any tissue, and without any motion, nothing moves, not by a bit.
  Model none{ Space() };
  none.Element.assign(none.Element.size(), 0);
  Model still{ Space() };
  for (const Model* one : { &none, &still })
  {
    for (const bool backward : { false, true })
    {
      vtkNew<vtkChainMailCarry> carry;
      carry->SetInputData(MakePoints(rest, VTK_FLOAT));
      carry->SetInputDataObject(1, one->Image());
      carry->SetDirection(backward);
      carry->Update();
      vtkPolyData* output = vtkPolyData::SafeDownCast(carry->GetOutputDataObject(0));
      vtkDataArray* before = vtkPolyData::SafeDownCast(carry->GetInputDataObject(0, 0))->GetPoints()->GetData();
      check.That(SameBits(output->GetPoints()->GetData(), before), "nothing moves");
    }
  }
}

/// A single slice, in which tissue may also leave the plane.
void TestSlice(Checks& check)
{
  Space space;
  space.Size = { { 12, 14, 1 } };
  Model model{ space };
  Noise noise(7);
  for (Vector& u : model.U)
  {
    u = { { 2.0 + 0.3 * noise.Uniform(), -1.0 + 0.3 * noise.Uniform(), 0.5 } };
  }
  const std::vector<Vector> rest = RandomVoxels(1000, { { 0, 0, -0.4 } }, { { 11, 13, 0.4 } }, 8);
  const std::vector<Vector> now = Carry(check, model, rest);
  check.Near(now[0][2], rest[0][2] + 0.5, 1e-5, "out of the plane");
  check.That(Farthest(Carry(check, model, now, true), rest) < 1e-6, "a slice there and back");
}

/// Points keep their type, and datasets all that they have.
void TestDatasets(Checks& check)
{
  // u = (0.2 y, 0, 0), a shear along the grid's axes, in a world that is not turned.
  Space space;
  space.Direction = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };
  space.Spacing = { { 1, 1, 1 } };
  Model model{ space };
  model.S.Each([&](int i, int j, int k) { model.U[model.S.Id(i, j, k)] = { { 0.2 * j, 0.0, 0.0 } }; });
  auto image = model.Image();
  const Vector centre = space.World({ { 5, 6, 5 } });

  // A plane across x, of which the normal turns.
  vtkNew<vtkPlaneSource> source;
  source->SetOrigin(centre[0], centre[1] - 2, centre[2] - 2);
  source->SetPoint1(centre[0], centre[1] + 2, centre[2] - 2);
  source->SetPoint2(centre[0], centre[1] - 2, centre[2] + 2);
  source->SetResolution(3, 4);
  source->Update();
  vtkNew<vtkPolyData> plane;
  plane->DeepCopy(source->GetOutput());
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("Numbers");
  numbers->SetNumberOfTuples(plane->GetNumberOfCells());
  numbers->FillValue(3);
  plane->GetCellData()->AddArray(numbers);
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("Ids");
  for (vtkIdType n = 0; n < plane->GetNumberOfPoints(); ++n)
  {
    ids->InsertNextValue(n);
  }
  plane->GetPointData()->SetGlobalIds(ids);
  plane->GetFieldData()->AddArray(numbers);
  for (const bool backward : { false, true })
  {
    vtkNew<vtkChainMailCarry> carry;
    carry->SetInputData(plane);
    carry->SetInputDataObject(1, image);
    carry->SetDirection(backward);
    carry->Update();
    vtkPolyData* output = vtkPolyData::SafeDownCast(carry->GetOutputDataObject(0));
    check.Equal(output->GetNumberOfPolys(), plane->GetNumberOfPolys(), "all polygons");
    check.Equal(output->GetPoints()->GetDataType(), plane->GetPoints()->GetDataType(), "the points' type");
    check.That(output->GetPointData()->GetGlobalIds() == ids.Get(), "global ids");
    check.That(output->GetPointData()->GetTCoords() != nullptr, "texture coordinates");
    check.That(output->GetCellData()->GetArray("Numbers") == numbers.Get(), "cell arrays");
    check.That(output->GetFieldData()->GetArray("Numbers") == numbers.Get(), "field arrays");
    vtkDataArray* normals = output->GetPointData()->GetNormals();
    check.That(normals && normals->GetNumberOfTuples() == plane->GetNumberOfPoints(), "normals");
    // The plane x = c becomes x = c +- 0.2 y.
    const double sign = plane->GetPointData()->GetNormals()->GetComponent(0, 0);
    const double slope = backward ? 0.2 : -0.2, length = std::sqrt(1.0 + slope * slope);
    for (vtkIdType n = 0; normals && n < normals->GetNumberOfTuples(); ++n)
    {
      check.Near(normals->GetComponent(n, 0), sign / length, 1e-5, "normal x");
      check.Near(normals->GetComponent(n, 1), sign * slope / length, 1e-5, "normal y");
      check.Near(normals->GetComponent(n, 2), 0.0, 1e-5, "normal z");
    }
    for (vtkIdType n = 0; n < plane->GetNumberOfPoints(); ++n)
    {
      const double y = plane->GetPoint(n)[1];
      const double along = 0.2 * (y - space.World({ { 0, 0, 0 } })[1]);
      check.Near(output->GetPoint(n)[0], centre[0] + (backward ? -along : along), 1e-5, "sheared");
      check.Near(output->GetPoint(n)[1], y, 1e-5, "not aside");
    }
  }

  vtkNew<vtkUnstructuredGrid> cells;
  cells->SetPoints(plane->GetPoints());
  const vtkIdType corners[4] = { 0, 1, 5, 9 };
  cells->InsertNextCell(VTK_TETRA, 4, corners);
  vtkNew<vtkStructuredGrid> structured;
  structured->SetDimensions(4, 5, 1);
  structured->SetPoints(plane->GetPoints());
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetNumberOfBlocks(4);
  blocks->SetBlock(0, cells);
  blocks->SetBlock(1, structured);
  blocks->SetBlock(3, image);
  vtkNew<vtkChainMailCarry> carry;
  EventLog log(carry);
  carry->SetInputDataObject(1, image);
  carry->SetInputDataObject(0, blocks);
  carry->Update();
  check.Equal(log.TakeErrors(), std::string(), "blocks: no error");
  auto* output = vtkMultiBlockDataSet::SafeDownCast(carry->GetOutputDataObject(0));
  check.That(output && output->GetNumberOfBlocks() == 4 && !output->GetBlock(2), "the same blocks");
  for (const unsigned n : { 0u, 1u })
  {
    auto* before = vtkPointSet::SafeDownCast(blocks->GetBlock(n));
    auto* after = vtkPointSet::SafeDownCast(output ? output->GetBlock(n) : nullptr);
    check.That(after && after->GetDataObjectType() == before->GetDataObjectType() &&
                 after->GetNumberOfCells() == before->GetNumberOfCells(),
      "the block's type");
    check.Near(after ? after->GetPoint(3)[0] - before->GetPoint(3)[0] : 0.0,
      0.2 * (before->GetPoint(3)[1] - space.World({ { 0, 0, 0 } })[1]), 1e-5, "the block's points");
  }
  check.That(vtkImageData::SafeDownCast(output->GetBlock(3)) != nullptr, "the block's image");
  for (vtkPointSet* one : { static_cast<vtkPointSet*>(cells), static_cast<vtkPointSet*>(structured) })
  {
    carry->SetInputDataObject(0, one);
    carry->Update();
    check.Equal(carry->GetOutputDataObject(0)->GetDataObjectType(), one->GetDataObjectType(), "the type");
  }
  vtkNew<vtkPolyData> empty;
  carry->SetInputDataObject(0, empty);
  carry->Update();
  check.Equal(log.TakeErrors(), std::string(), "an empty mesh is no error");
}

void TestErrors(Checks& check)
{
  const Model model = RandomBlock(3);
  auto good = model.Image();
  auto points = MakePoints({ model.S.World({ { 5, 5, 5 } }) });
  vtkNew<vtkChainMailCarry> carry;
  EventLog log(carry);
  const auto expect = [&](vtkDataObject* input, vtkDataObject* deformation, const char* part)
  {
    carry->SetInputDataObject(0, input);
    carry->SetInputDataObject(1, deformation);
    carry->Update();
    const std::string error = log.TakeErrors();
    check.Contains(error, part, "the error");
    check.Equal(static_cast<int>(carry->GetErrorCode()), static_cast<int>(vtkErrorCode::UserError), "the error code");
    auto* output = carry->GetOutputDataObject(0);
    check.That(output && output->GetDataObjectType() == input->GetDataObjectType(), "the input is shown");
    auto* text = vtkStringArray::SafeDownCast(output->GetFieldData()->GetAbstractArray("Error"));
    check.That(text && error.find(text->GetValue(0)) != std::string::npos, "the output has the error");
    check.That(!input->GetFieldData()->HasArray("Error"), "and the input does not");
    carry->SetInputDataObject(0, points);
    carry->SetInputDataObject(1, good);
    carry->Update();
    check.Equal(log.TakeErrors(), std::string(), "good input works again");
    check.Equal(static_cast<int>(carry->GetErrorCode()), static_cast<int>(vtkErrorCode::NoError), "no error code");
    check.That(!carry->GetOutputDataObject(0)->GetFieldData()->HasArray("Error"), "the error is gone");
  };
  vtkNew<vtkImageData> bad;
  bad->DeepCopy(good);
  bad->GetPointData()->RemoveArray("Displacement");
  expect(points, bad, "with Displacement among its ModelArrays");
  vtkNew<vtkFloatArray> back;
  back->SetName("PullBack");
  back->SetNumberOfComponents(3);
  back->SetNumberOfTuples(bad->GetNumberOfPoints());
  back->FillValue(0.0);
  bad->GetPointData()->AddArray(back);
  expect(points, bad, "Connect the second output of ChainMail Deformation");
  bad->DeepCopy(good);
  bad->GetPointData()->RemoveArray("Element");
  expect(points, bad, "no array Element");
  bad->DeepCopy(good);
  bad->GetPointData()->GetArray("Displacement")->SetComponent(7, 1, std::nan(""));
  expect(points, bad, "not finite");
  vtkNew<vtkFloatArray> scalar;
  scalar->SetName("Displacement");
  scalar->SetNumberOfTuples(bad->GetNumberOfPoints());
  scalar->FillValue(0.0);
  bad->GetPointData()->AddArray(scalar);
  expect(points, bad, "3 components");
  vtkNew<vtkImageData> empty;
  expect(points, empty, "empty");
  vtkNew<vtkRectilinearGrid> rectilinear;
  expect(rectilinear, good, "Resample To Image");

  // A place that is none stays, and does no harm to others.
  auto some = MakePoints({ model.S.World({ { 5, 5, 5 } }), { { std::nan(""), 0.0, 0.0 } } });
  carry->SetInputData(some);
  carry->Update();
  check.Equal(log.TakeErrors(), std::string(), "NaN is no error");
  auto* output = vtkPolyData::SafeDownCast(carry->GetOutputDataObject(0));
  check.That(std::isnan(output->GetPoint(1)[0]) && output->GetPoint(1)[1] == 0.0, "NaN stays");
  check.That(std::fabs(output->GetPoint(0)[1] - some->GetPoint(0)[1]) > 0.1, "the other moves");

  // Cell arrays of images are named once.
  auto image = model.S.Image();
  AddPlaces(image);
  vtkNew<vtkFloatArray> cells;
  cells->SetName("OfCells");
  cells->SetNumberOfTuples(image->GetNumberOfCells());
  cells->FillValue(1.0);
  image->GetCellData()->AddArray(cells);
  carry->SetInputData(image);
  carry->Update();
  check.Contains(log.TakeWarnings(), "OfCells", "the warning");
  carry->SetDirectionToBackward();
  carry->Update();
  check.Equal(log.TakeWarnings(), std::string(), "one warning");
  carry->Print(std::cout);
}

}

int TestChainMailCarry(int, char*[])
{
  Checks check;
  TestInterpolation(check);
  TestCut(check);
  TestEndOfCut(check);
  TestAir(check);
  TestSlice(check);
  TestDatasets(check);
  TestErrors(check);
  return check.Finish();
}
