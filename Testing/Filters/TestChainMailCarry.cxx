// SPDX-License-Identifier: BSD-3-Clause
// Meshes, points and images go along with a deformation and back. The oracles are maps that are known in closed form
// and a trilinear interpolation of its own, on models made by hand; and what the deformation itself shows of its scan.

#include "FilterTest.h"

#include "vtkChainMailCarry.h"

#include "vtkCellData.h"
#include "vtkDataArraySelection.h"
#include "vtkErrorCode.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkPlaneSource.h"
#include "vtkRectilinearGrid.h"
#include "vtkShortArray.h"
#include "vtkSphereSource.h"
#include "vtkStructuredGrid.h"
#include "vtkUnstructuredGrid.h"

#include <random>
#include <set>

using namespace FilterTest;

namespace
{

/// An oblique grid of odd spacing whose extent begins anywhere.
struct Space
{
  Vector Origin{ { -40.0, 12.0, 7.0 } };
  Vector Spacing{ { 1.5, 0.75, 2.0 } };
  std::array<double, 9> Direction; // its columns are the axes
  std::array<int, 3> First{ { -3, 5, 2 } };
  std::array<int, 3> Size{ { 12, 14, 10 } };

  Space()
  {
    const double c = std::cos(0.5), s = std::sin(0.5);
    this->Direction = { { c, -s * 0.8, s * 0.6, s, c * 0.8, -c * 0.6, 0.0, 0.6, 0.8 } };
  }

  /// The place of a voxel, counted from the first one.
  Vector World(const Vector& voxel) const
  {
    Vector world = this->Origin;
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        world[a] += this->Direction[3 * a + b] * this->Spacing[b] * (this->First[b] + voxel[b]);
      }
    }
    return world;
  }

  Vector WorldVector(const Vector& voxels) const
  {
    const Vector from = this->World({ { 0, 0, 0 } });
    Vector to = this->World(voxels);
    for (int a = 0; a < 3; ++a)
    {
      to[a] -= from[a];
    }
    return to;
  }

  vtkSmartPointer<vtkImageData> Image() const
  {
    auto image = vtkSmartPointer<vtkImageData>::New();
    image->SetExtent(this->First[0], this->First[0] + this->Size[0] - 1, this->First[1],
      this->First[1] + this->Size[1] - 1, this->First[2], this->First[2] + this->Size[2] - 1);
    image->SetOrigin(this->Origin.data());
    image->SetSpacing(this->Spacing.data());
    image->SetDirectionMatrix(this->Direction.data());
    return image;
  }

  vtkIdType Id(int i, int j, int k) const { return i + this->Size[0] * (j + this->Size[1] * vtkIdType(k)); }

  template <typename F> void Each(const F& f) const
  {
    for (int k = 0; k < this->Size[2]; ++k)
    {
      for (int j = 0; j < this->Size[1]; ++j)
      {
        for (int i = 0; i < this->Size[0]; ++i)
        {
          f(i, j, k);
        }
      }
    }
  }
};

/// A model at rest, with displacements given in voxels.
struct Model
{
  Space S;
  std::vector<Vector> U;
  std::vector<unsigned char> Element;
  std::vector<unsigned char> Links; // empty: the array is not there

  explicit Model(const Space& space)
    : S(space)
    , U(static_cast<std::size_t>(space.Size[0]) * space.Size[1] * space.Size[2])
    , Element(this->U.size(), 1)
  {
  }

  /// All links between elements.
  void LinkAll()
  {
    this->Links.assign(this->U.size(), 0);
    this->S.Each(
      [&](int i, int j, int k)
      {
        const int at[3] = { i, j, k };
        for (int a = 0; a < 3; ++a)
        {
          const vtkIdType from = this->S.Id(i, j, k), to = this->S.Id(i + (a == 0), j + (a == 1), k + (a == 2));
          if (at[a] + 1 < this->S.Size[a] && this->Element[from] && this->Element[to])
          {
            this->Links[from] |= 2 << 2 * a;
            this->Links[to] |= 1 << 2 * a;
          }
        }
      });
  }

  /// Cuts all links between x and x + 1.
  void CutAcrossX(int x)
  {
    this->S.Each([&](int i, int j, int k) { this->Links[this->S.Id(i, j, k)] &= i == x ? ~2 : i == x + 1 ? ~1 : ~0; });
  }

  vtkSmartPointer<vtkImageData> Image() const
  {
    auto image = this->S.Image();
    vtkNew<vtkFloatArray> displacement;
    displacement->SetName("Displacement");
    displacement->SetNumberOfComponents(3);
    vtkNew<vtkUnsignedCharArray> element;
    element->SetName("Element");
    vtkNew<vtkUnsignedCharArray> links;
    links->SetName("Links");
    for (std::size_t v = 0; v < this->U.size(); ++v)
    {
      displacement->InsertNextTuple(this->S.WorldVector(this->U[v]).data());
      element->InsertNextValue(this->Element[v]);
      links->InsertNextValue(this->Links.empty() ? 0 : this->Links[v]);
    }
    image->GetPointData()->SetVectors(displacement);
    image->GetPointData()->AddArray(element);
    if (!this->Links.empty())
    {
      image->GetPointData()->AddArray(links);
    }
    return image;
  }

  /// x + u(x) between the voxels of a block without air and cuts.
  Vector Forward(const Vector& x) const
  {
    Vector y = x;
    int low[3];
    for (int a = 0; a < 3; ++a)
    {
      low[a] = std::min(static_cast<int>(x[a]), this->S.Size[a] - 2);
    }
    for (int n = 0; n < 8; ++n)
    {
      const int p[3] = { n & 1, n >> 1 & 1, n >> 2 };
      double weight = 1.0;
      for (int a = 0; a < 3; ++a)
      {
        const double t = x[a] - low[a];
        weight *= p[a] ? t : 1.0 - t;
      }
      for (int a = 0; a < 3; ++a)
      {
        y[a] += weight * this->U[this->S.Id(low[0] + p[0], low[1] + p[1], low[2] + p[2])][a];
      }
    }
    return y;
  }
};

vtkSmartPointer<vtkPolyData> MakePoints(const std::vector<Vector>& places, int type = VTK_DOUBLE)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataType(type);
  for (const Vector& place : places)
  {
    points->InsertNextPoint(place.data());
  }
  data->SetPoints(points);
  return data;
}

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

/// A block full of tissue with links strained by up to a third of a voxel, below which nothing folds.
Model RandomBlock(unsigned seed)
{
  Model model{ Space() };
  Noise noise(seed);
  for (Vector& u : model.U)
  {
    for (int a = 0; a < 3; ++a)
    {
      u[a] = 4.0 * a - 3.0 + 0.3 * (noise.Uniform() - 0.5);
    }
  }
  return model;
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

/// A point array with the place of each voxel.
void AddPlaces(vtkImageData* image)
{
  vtkNew<vtkDoubleArray> place;
  place->SetName("Place");
  place->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    place->InsertNextTuple(image->GetPoint(p));
  }
  image->GetPointData()->AddArray(place);
}

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
  expect(points, bad, "no finite numbers");
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
  TestOtherGrid(check);
  TestOwnGrid(check);
  TestErrors(check);
  return check.Finish();
}
