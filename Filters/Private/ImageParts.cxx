// SPDX-License-Identifier: BSD-3-Clause
#include "ImageParts.h"

#include "Arrays.h"

#include "Error.h"

#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"
#include "vtkFieldData.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessStream.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace vtkChainMail
{

namespace
{

/// Where the value of a voxel comes from.
enum Knowledge : char
{
  Nothing,
  Ghost,
  Own
};

/// Whether two images have their voxels at the same places of the world.
bool HasSameGrid(vtkImageData* a, vtkImageData* b)
{
  return std::equal(a->GetOrigin(), a->GetOrigin() + 3, b->GetOrigin()) &&
         std::equal(a->GetSpacing(), a->GetSpacing() + 3, b->GetSpacing()) &&
         std::equal(a->GetDirectionMatrix()->GetData(), a->GetDirectionMatrix()->GetData() + 9,
           b->GetDirectionMatrix()->GetData());
}

/// Throws InputError for a part that does not belong to this image.
void Check(vtkImageData* part, vtkImageData* image)
{
  if (!HasSameGrid(part, image))
  {
    throw chainmail::InputError("The processes have parts of the input that differ in origin, spacing or direction, so "
                                "the parts do not form one image. Give one image.");
  }
  vtkPointData* arrays = image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    const char* name = arrays->GetArrayName(a);
    vtkAbstractArray* from = part->GetPointData()->GetAbstractArray(name);
    if (from && from->GetNumberOfTuples() != part->GetNumberOfPoints())
    {
      throw chainmail::InputError(
        "The point array \"" + std::string(name ? name : "") + "\" has " + std::to_string(from->GetNumberOfTuples()) +
        " tuples in a part of the image that has " + std::to_string(part->GetNumberOfPoints()) +
        " voxels. Remove it, or give it a value for each.");
    }
    if (!from || from->GetDataType() != arrays->GetAbstractArray(a)->GetDataType() ||
        from->GetNumberOfComponents() != arrays->GetAbstractArray(a)->GetNumberOfComponents())
    {
      throw chainmail::InputError("The point array \"" + std::string(name ? name : "") +
                                  "\" is missing from the part of the image of some process, or has another type or "
                                  "number of components there. Give all parts the same arrays.");
    }
  }
}

/// Calls f(first, count) for each row of voxels along x, with the first voxel.
template <typename F> void ForRows(const Extent& e, const F& f)
{
  for (int k = e[4]; k <= e[5]; ++k)
  {
    for (int j = e[2]; j <= e[3]; ++j)
    {
      int first[3] = { e[0], j, k };
      f(first, e[1] - e[0] + 1);
    }
  }
}

/// The place of a voxel in an array over a box.
vtkIdType IdIn(const Extent& e, const int* at)
{
  return (at[0] - e[0]) + (e[1] - e[0] + vtkIdType(1)) *
                            ((at[1] - e[2]) + (e[3] - e[2] + vtkIdType(1)) * static_cast<vtkIdType>(at[2] - e[4]));
}

/// Copies the tuples of a box, whose place in each of two larger boxes is given by their extents.
void CopyTuples(
  vtkAbstractArray* from, const Extent& ofFrom, vtkAbstractArray* to, const Extent& ofTo, const Extent& box)
{
  vtkDataArray* one = vtkDataArray::SafeDownCast(from);
  vtkDataArray* other = vtkDataArray::SafeDownCast(to);
  if (one && other && one->HasStandardMemoryLayout() && other->HasStandardMemoryLayout() &&
      one->GetDataType() == other->GetDataType() && one->GetDataType() != VTK_BIT)
  {
    CopyBox(static_cast<const char*>(one->GetVoidPointer(0)), ofFrom, static_cast<char*>(other->GetVoidPointer(0)),
      ofTo, box, BytesOfVoxel(one)); // much faster than VTK's own functions
    return;
  }
  ForRows(
    box, [&](const int* first, int count) { to->InsertTuples(IdIn(ofTo, first), count, IdIn(ofFrom, first), from); });
}

/// Gives an array memory for `tuples` tuples. Throws std::bad_alloc where it is a block of numbers, see Allocate().
void SetTuples(vtkAbstractArray* array, vtkIdType tuples)
{
  vtkDataArray* const numbers = vtkDataArray::SafeDownCast(array);
  if (numbers && numbers->HasStandardMemoryLayout() && numbers->GetDataType() != VTK_BIT)
  {
    Allocate(numbers, tuples);
  }
  else
  {
    array->SetNumberOfTuples(tuples);
  }
}

/// Adds the arrays of `from`, with the values of a part of it, and makes those active that are active there.
void CopyArrays(vtkDataSetAttributes* from, const Extent& whole, vtkDataSetAttributes* to, const Extent& part)
{
  for (int a = 0; a < from->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = from->GetAbstractArray(a);
    const auto copy = vtkSmartPointer<vtkAbstractArray>::Take(array->NewInstance());
    Describe(copy, array);
    if (vtkDataArray* numbers = vtkDataArray::SafeDownCast(array))
    {
      vtkDataArray::SafeDownCast(copy)->SetLookupTable(numbers->GetLookupTable());
    }
    SetTuples(copy, VoxelsOf(part));
    CopyTuples(array, whole, copy, part, part);
    to->AddArray(copy);
  }
  int active[vtkDataSetAttributes::NUM_ATTRIBUTES];
  from->GetAttributeIndices(active);
  for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
  {
    if (active[attribute] >= 0)
    {
      to->SetActiveAttribute(active[attribute], attribute);
    }
  }
}

/// The cells between the points of an extent; an axis with one point has one cell.
Extent CellsOf(const Extent& points)
{
  Extent cells = points;
  for (int a = 0; a < 3; ++a)
  {
    cells[2 * a + 1] = std::max(cells[2 * a + 1] - 1, cells[2 * a]);
  }
  return cells;
}

}

Extent Common(const Extent& one, const Extent& other)
{
  Extent common;
  for (int a = 0; a < 6; ++a)
  {
    common[a] = a % 2 == 0 ? std::max(one[a], other[a]) : std::min(one[a], other[a]);
  }
  return common;
}

std::vector<Extent> Without(const std::vector<Extent>& boxes, const Extent& extent)
{
  std::vector<Extent> rest;
  for (Extent box : boxes)
  {
    const Extent common = Common(box, extent);
    if (IsEmpty(common))
    {
      rest.push_back(box);
      continue;
    }
    // What is on both sides of the common voxels, along one axis after the other.
    for (int a = 0; a < 3; ++a)
    {
      Extent low = box;
      Extent high = box;
      low[2 * a + 1] = common[2 * a] - 1;
      high[2 * a] = common[2 * a + 1] + 1;
      for (const Extent& side : { low, high })
      {
        if (!IsEmpty(side))
        {
          rest.push_back(side);
        }
      }
      box[2 * a] = common[2 * a];
      box[2 * a + 1] = common[2 * a + 1];
    }
  }
  return rest;
}

vtkIdType VoxelsOf(const Extent& e)
{
  return static_cast<vtkIdType>(e[1] - e[0] + 1) * (e[3] - e[2] + 1) * (e[5] - e[4] + 1);
}

std::size_t BytesOfVoxel(vtkDataArray* array)
{
  return static_cast<std::size_t>(array->GetNumberOfComponents()) * static_cast<std::size_t>(array->GetDataTypeSize());
}

void CopyBox(
  const char* from, const Extent& ofFrom, char* to, const Extent& ofTo, const Extent& box, std::size_t bytesOfVoxel)
{
  ForRows(box,
    [&](const int* first, int count)
    {
      std::memcpy(to + bytesOfVoxel * static_cast<std::size_t>(IdIn(ofTo, first)),
        from + bytesOfVoxel * static_cast<std::size_t>(IdIn(ofFrom, first)),
        bytesOfVoxel * static_cast<std::size_t>(count));
    });
}

void WriteGeometry(vtkMultiProcessStream& stream, vtkImageData* image)
{
  for (const int e : ExtentOf(image))
  {
    stream << e;
  }
  for (int a = 0; a < 3; ++a)
  {
    stream << image->GetOrigin()[a] << image->GetSpacing()[a];
  }
  for (int n = 0; n < 9; ++n)
  {
    stream << image->GetDirectionMatrix()->GetData()[n];
  }
}

void ReadGeometry(vtkMultiProcessStream& stream, vtkImageData* image)
{
  Extent extent;
  double origin[3];
  double spacing[3];
  double direction[9];
  for (int& e : extent)
  {
    stream >> e;
  }
  for (int a = 0; a < 3; ++a)
  {
    stream >> origin[a] >> spacing[a];
  }
  for (double& d : direction)
  {
    stream >> d;
  }
  image->SetExtent(extent.data());
  image->SetOrigin(origin);
  image->SetSpacing(spacing);
  image->SetDirectionMatrix(direction);
}

std::string ListTypes(vtkImageData* image)
{
  std::string list;
  vtkPointData* arrays = image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    list += std::string(array->GetName() ? array->GetName() : "") + '\n' + std::to_string(array->GetDataType()) + ' ' +
            std::to_string(array->GetNumberOfComponents()) + '\n';
  }
  return list;
}

bool IsEmpty(const Extent& e)
{
  return e[0] > e[1] || e[2] > e[3] || e[4] > e[5];
}

bool Contains(const Extent& outer, const Extent& inner)
{
  return inner[0] >= outer[0] && inner[1] <= outer[1] && inner[2] >= outer[2] && inner[3] <= outer[3] &&
         inner[4] >= outer[4] && inner[5] <= outer[5];
}

Extent ExtentOf(vtkImageData* image)
{
  Extent extent{ { 0, -1, 0, -1, 0, -1 } };
  if (image)
  {
    image->GetExtent(extent.data());
  }
  return extent;
}

vtkSmartPointer<vtkImageData> Cut(vtkImageData* whole, const Extent& part)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  const Extent there = ExtentOf(whole);
  if (!IsEmpty(part) && Contains(part, there))
  {
    image->ShallowCopy(whole);
    return image;
  }
  image->SetOrigin(whole->GetOrigin());
  image->SetSpacing(whole->GetSpacing());
  image->SetDirectionMatrix(whole->GetDirectionMatrix());
  image->GetFieldData()->ShallowCopy(whole->GetFieldData());
  // After an error the extent shown may differ from the announced one.
  const Extent common = Common(part, there);
  const bool meets = !IsEmpty(part) && !IsEmpty(common);
  const Extent extent = meets ? common : part;
  image->SetExtent(const_cast<int*>(extent.data()));
  if (meets)
  {
    CopyArrays(whole->GetPointData(), there, image->GetPointData(), common);
    CopyArrays(whole->GetCellData(), CellsOf(there), image->GetCellData(), CellsOf(common));
  }
  return image;
}

void Assembly::Begin(vtkImageData* first)
{
  const Extent whole = this->Whole;
  this->Image = vtkSmartPointer<vtkImageData>::New();
  this->Image->SetOrigin(first->GetOrigin());
  this->Image->SetSpacing(first->GetSpacing());
  this->Image->SetDirectionMatrix(first->GetDirectionMatrix());
  this->Image->SetExtent(const_cast<int*>(whole.data()));
  this->Image->GetFieldData()->ShallowCopy(first->GetFieldData());
  vtkPointData* arrays = this->Image->GetPointData();
  arrays->CopyAllOn();
  arrays->CopyAllocate(first->GetPointData(), 1);
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    SetTuples(arrays->GetAbstractArray(a), this->Image->GetNumberOfPoints());
  }
}

void Assembly::Add(vtkImageData* part)
{
  if (!this->Image)
  {
    this->Begin(part);
  }
  Check(part, this->Image);
  const Extent extent = Common(ExtentOf(part), ExtentOf(this->Image));
  if (IsEmpty(extent))
  {
    return;
  }
  if (part->GetPointGhostArray() && this->Known.empty())
  {
    // From now on it is known of each voxel what is known, since ghosts do not form a box.
    this->Known.assign(this->Image->GetNumberOfPoints(), Own);
    for (const Extent& box : this->Missing)
    {
      ForRows(box, [&](int* first, int count)
        { std::fill_n(this->Known.begin() + this->Image->ComputePointId(first), count, Nothing); });
    }
  }
  if (this->Known.empty())
  {
    this->CopyRows(part, extent);
    this->Missing = Without(this->Missing, extent);
  }
  else
  {
    this->CopyVoxels(part, extent);
  }
}

void Assembly::CopyRows(vtkImageData* part, const Extent& extent)
{
  vtkPointData* arrays = this->Image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    CopyTuples(part->GetPointData()->GetAbstractArray(arrays->GetArrayName(a)), ExtentOf(part),
      arrays->GetAbstractArray(a), ExtentOf(this->Image), extent);
  }
}

/// Copies the voxels that are still missing, or of which only a ghost copy was found so far.
void Assembly::CopyVoxels(vtkImageData* part, const Extent& extent)
{
  vtkPointData* arrays = this->Image->GetPointData();
  vtkUnsignedCharArray* ghosts = part->GetPointGhostArray();
  ForRows(extent,
    [&](int* first, int count)
    {
      const vtkIdType from = part->ComputePointId(first);
      const vtkIdType to = this->Image->ComputePointId(first);
      for (int i = 0; i < count; ++i)
      {
        const bool isGhost = ghosts && (ghosts->GetValue(from + i) & vtkDataSetAttributes::DUPLICATEPOINT) != 0;
        const char now = isGhost ? Ghost : Own;
        if (this->Known[to + i] < now)
        {
          this->Known[to + i] = now;
          for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
          {
            arrays->GetAbstractArray(a)->SetTuple(
              to + i, from + i, part->GetPointData()->GetAbstractArray(arrays->GetArrayName(a)));
          }
        }
      }
    });
}

vtkSmartPointer<vtkImageData> Assembly::End()
{
  vtkIdType missing = std::count(this->Known.begin(), this->Known.end(), Nothing);
  for (const Extent& box : this->Missing)
  {
    missing += this->Known.empty() ? VoxelsOf(box) : 0;
  }
  if (missing > 0)
  {
    throw chainmail::InputError("The processes' parts of the image leave out " + std::to_string(missing) + " of its " +
                                std::to_string(this->Image->GetNumberOfPoints()) + " voxels. Give the whole image.");
  }
  // In the whole image no voxel duplicates one of another process.
  if (vtkUnsignedCharArray* ghosts = this->Image->GetPointGhostArray())
  {
    for (vtkIdType v = 0; v < ghosts->GetNumberOfTuples(); ++v)
    {
      ghosts->SetValue(v, ghosts->GetValue(v) & ~vtkDataSetAttributes::DUPLICATEPOINT);
    }
  }
  return this->Image;
}

}
