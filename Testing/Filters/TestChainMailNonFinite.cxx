// SPDX-License-Identifier: BSD-3-Clause
// Tissue beside NaN and infinity. A rigid ball is moved by a fraction of a voxel; every voxel of every array is
// compared with a sum over the eight corners around the place it shows, in which corners that are neither tissue nor
// finite have no weight; where the nearest corner is such a one, so is what is shown.

#include "FilterTest.h"

#include <algorithm>
#include <limits>

using namespace FilterTest;

namespace
{

const double notANumber = std::nan("");
const double infinity = std::numeric_limits<double>::infinity();
const int size = 27;               // so that the tissue is three voxels and more from the faces
const double background = -5000.0; // of the scalars
const double far = -7777.0;        // of the other arrays: a voxel far away has it

using Index = std::array<int, 3>;

/// Of 4139 voxels.
bool IsTissue(const Index& at)
{
  const int x = at[0] - size / 2;
  const int y = at[1] - size / 2;
  const int z = at[2] - size / 2;
  return x * x + y * y + z * z <= 99;
}

bool IsInside(const Index& at)
{
  return std::all_of(at.begin(), at.end(), [](int i) { return i >= 0 && i < size; });
}

vtkIdType IdOf(const Index& at)
{
  return at[0] + size * (at[1] + static_cast<vtkIdType>(size) * at[2]);
}

/// Alternates, so that it tells which of two voxels a value was taken from.
double NotFinite(const Index& at)
{
  return at[2] % 3 == 0 ? notANumber : at[0] % 2 == 0 ? infinity : -infinity;
}

double Linear(const Index& at)
{
  return 1000.0 + 2.0 * at[0] - 3.0 * at[1] + 5.0 * at[2];
}

void AddArray(vtkImageData* image, const char* name, int type, int components,
  const std::function<double(const Index&, int)>& value)
{
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(image->GetNumberOfPoints());
  for (int k = 0; k < size; ++k)
  {
    for (int j = 0; j < size; ++j)
    {
      for (int i = 0; i < size; ++i)
      {
        const Index at{ { i, j, k } };
        for (int c = 0; c < components; ++c)
        {
          array->SetComponent(IdOf(at), c, i + j + k == 0 ? far : value(at, c));
        }
      }
    }
  }
  image->GetPointData()->AddArray(array);
}

/// Whether there is tissue in a box of voxels.
bool HasTissue(const Index& first, const Index& last)
{
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      for (int i = first[0]; i <= last[0]; ++i)
      {
        if (IsInside({ { i, j, k } }) && IsTissue({ { i, j, k } }))
        {
          return true;
        }
      }
    }
  }
  return false;
}

/// What voxel `at` of the output has to show. `exact`: without rounding.
double Expected(vtkDataArray* array, int component, const Index& at, const Vector& displacement, bool& exact)
{
  exact = true;
  Index before; // of cells that hold the place, the first
  Index after;
  Index corner;
  Index nearest;
  Vector share;
  bool near = true;
  for (int a = 0; a < 3; ++a)
  {
    const double place = at[a] - displacement[a];
    before[a] = static_cast<int>(std::ceil(place)) - 1;
    corner[a] = static_cast<int>(std::floor(place));
    after[a] = corner[a] + 1;
    nearest[a] = static_cast<int>(std::floor(place + 0.5));
    share[a] = place - corner[a];
    near = near && std::fabs(displacement[a]) < 1.0;
  }
  // Air beside tissue goes with it where that goes less than a voxel; otherwise it is gone, as tissue is.
  const bool beside = HasTissue({ { at[0] - 1, at[1] - 1, at[2] - 1 } }, { { at[0] + 1, at[1] + 1, at[2] + 1 } });
  if (!HasTissue(before, after) && !(near && beside && !IsTissue(at)))
  {
    return !beside                                   ? array->GetComponent(IdOf(at), component)
           : std::string(array->GetName()) == "Scan" ? background
                                                     : far;
  }
  double weights = 0.0;
  double sum = 0.0;
  for (int c = 0; c < 8; ++c)
  {
    const Index other{ { corner[0] + (c & 1), corner[1] + (c >> 1 & 1), corner[2] + (c >> 2) } };
    const double weight =
      (c & 1 ? share[0] : 1.0 - share[0]) * (c & 2 ? share[1] : 1.0 - share[1]) * (c & 4 ? share[2] : 1.0 - share[2]);
    const double value = weight > 0.0 ? array->GetComponent(IdOf(other), component) : 0.0;
    if (weight > 0.0 && (IsTissue(other) || std::isfinite(value)))
    {
      weights += weight;
      sum += weight * value;
    }
  }
  const double nearestValue = array->GetComponent(IdOf(nearest), component);
  const bool known = IsTissue(nearest) || std::isfinite(nearestValue);
  exact = weights == 1.0 || !known;
  return known ? sum / weights : nearestValue;
}

/// NaN is like NaN, infinities are like those of their sign.
bool Alike(double a, double b, double tolerance)
{
  return std::isfinite(a) && std::isfinite(b) ? std::fabs(a - b) <= tolerance
                                              : (std::isnan(a) && std::isnan(b)) || a == b;
}

std::vector<Index> AllVoxels()
{
  std::vector<Index> all;
  for (int n = 0; n < size * size * size; ++n)
  {
    all.push_back({ { n % size, n / size % size, n / size / size } });
  }
  return all;
}

vtkSmartPointer<vtkChainMailDeformation> MoveBall(vtkImageData* image, const Vector& displacement)
{
  auto filter = vtkSmartPointer<vtkChainMailDeformation>::New();
  image->GetPointData()->SetActiveScalars("Scan");
  filter->SetInputData(image);
  filter->SetTissueThreshold(0.0);
  filter->SetMaterialFunction(ConstantMaterial(0.0));
  filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
  filter->SetBackgroundValue(background);
  const double middle = size / 2;
  filter->SetInputDataObject(1, MakeProbes({ { { { middle, middle, middle } }, displacement } }));
  return filter;
}

}

int TestChainMailNonFinite(int, char*[])
{
  Checks check;

  // Shares of a power of two and small integers: sums without rounding. Displacements along a single axis leave places
  // whose only corners of any weight are air, though tissue is beside them.
  const std::vector<Vector> displacements = { { { 0.125, 0.125, 0.125 } }, { { -0.25, 0.5, 0.875 } },
    { { 2.5, -1.75, 0.125 } }, { { 0.25, 0.0, 0.0 } }, { { 0.75, 0.0, 0.0 } }, { { 0.0, -0.25, 0.5 } },
    { { 3.0, 0.0, -2.0 } } };
  for (const int type : { VTK_FLOAT, VTK_DOUBLE, VTK_SHORT })
  {
    auto image = MakeImage({ { 0, size - 1, 0, size - 1, 0, size - 1 } }, type);
    image->GetPointData()->Initialize();
    AddArray(image, "Scan", type, 1,
      [&](const Index& at, int) { return IsTissue(at)        ? Linear(at)
                                         : type == VTK_SHORT ? -1000.0
                                                             : NotFinite(at); });
    AddArray(
      image, "finite around", VTK_FLOAT, 1, [](const Index& at, int) { return IsTissue(at) ? Linear(at) : -1000.0; });
    AddArray(image, "dose", VTK_FLOAT, 2,
      [](const Index& at, int c)
      {
        // NaN in tissue, too, where a dose was not measured.
        return !IsTissue(at)                                         ? NotFinite(at)
               : c == 1 && (at[0] + 2 * at[1] + 3 * at[2]) % 11 == 0 ? notANumber
                                                                     : Linear(at) - c;
      });
    for (const Vector& displacement : displacements)
    {
      auto filter = MoveBall(image, displacement);
      EventLog log(filter);
      filter->Update();
      check.Equal(log.TakeErrors(), std::string(), "no error");
      vtkDataArray* moved = filter->GetModelOutput()->GetPointData()->GetArray("Displacement");
      for (int a = 0; a < 3; ++a)
      {
        check.Equal(moved->GetComponent(IdOf({ { size / 2, size / 2, size / 2 } }), a), displacement[a],
          "the ball is moved exactly so");
      }
      vtkPointData* arrays = image->GetPointData();
      int normalised = 0;
      int propagated = 0;
      for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
      {
        vtkDataArray* from = arrays->GetArray(n);
        vtkDataArray* to = filter->GetOutput()->GetPointData()->GetArray(from->GetName());
        // A rounded quotient of doubles of some 1000, in the array's own type: half a unit in the last place of a float
        // is 6e-5.
        const double tolerance = from->GetDataType() == VTK_DOUBLE  ? 1e-11
                                 : from->GetDataType() == VTK_SHORT ? 0.5
                                                                    : 6.2e-5;
        for (const Index& at : AllVoxels())
        {
          for (int c = 0; c < from->GetNumberOfComponents(); ++c)
          {
            bool exact = true;
            const double expected = Expected(from, c, at, displacement, exact);
            const double shown = to->GetComponent(IdOf(at), c);
            const bool rounded = from->GetDataType() == VTK_SHORT;
            check.That(Alike(shown, expected, exact && !rounded ? 0.0 : tolerance),
              std::string(from->GetName()) + " of type " + from->GetDataTypeAsString() + " at " +
                std::to_string(at[0]) + " " + std::to_string(at[1]) + " " + std::to_string(at[2]) + ": " +
                std::to_string(shown) + " instead of " + std::to_string(expected));
            normalised += !exact;
            propagated += std::isnan(shown) && std::isnan(expected) && IsTissue(at) && c == 1;
          }
        }
      }
      const bool wholeVoxels = displacement[0] == 3.0;
      check.Equal(normalised > 100, !wholeVoxels, "places with corners of no weight were met");
      check.That(propagated > 100, "NaN of tissue spreads");
    }
  }

  // Nothing is lost by a move of a tenth of a voxel, in shares that are rounded, and what is uniform stays so exactly.
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    auto image = MakeImage({ { 0, size - 1, 0, size - 1, 0, size - 1 } }, type);
    image->GetPointData()->Initialize();
    AddArray(image, "Scan", type, 1, [&](const Index& at, int) { return IsTissue(at) ? 0.1 : NotFinite(at); });
    const double uniform = image->GetPointData()->GetArray("Scan")->GetTuple1(IdOf({ { 13, 13, 13 } }));
    auto filter = MoveBall(image, { { 0.1, 0.1, 0.1 } });
    filter->Update();
    int kept = 0;
    int tissue = 0;
    int shownTissue = 0;
    for (const Index& at : AllVoxels())
    {
      const double shown = filter->GetOutput()->GetPointData()->GetScalars()->GetTuple1(IdOf(at));
      tissue += IsTissue(at);
      kept += IsTissue(at) && shown == uniform;
      shownTissue += shown == uniform;
      check.That(shown == uniform || shown == background || shown == far || !std::isfinite(shown),
        "a uniform ball shows no other value than its own: " + std::to_string(shown));
    }
    check.Equal(tissue, 4139, "the ball's voxels");
    // A tenth of a voxel: the ball still covers the centres of more than half of each of its voxels, so all stay.
    check.Equal(kept, 4139, "moved by a tenth of a voxel, the ball keeps all its voxels");
    check.Equal(shownTissue, 4139, "and covers no others");
  }
  return check.Finish();
}
