// SPDX-License-Identifier: BSD-3-Clause
#include "ImageParts.h"

#include "Error.h"

#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"
#include "vtkFieldData.h"
#include "vtkMatrix3x3.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <string>

namespace vtkChainMail
{

namespace
{

/// Where the value of a voxel comes from.
enum Knowledge : unsigned char
{
  Missing,
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
    if (!from || from->GetDataType() != arrays->GetAbstractArray(a)->GetDataType() ||
        from->GetNumberOfComponents() != arrays->GetAbstractArray(a)->GetNumberOfComponents())
    {
      throw chainmail::InputError("The point array \"" + std::string(name ? name : "") +
                                  "\" is missing from the part of the image of some process, or has another type or "
                                  "number of components there. Give all parts the same arrays.");
    }
  }
}

/// Copies the voxels of a part that are still missing, or of which only a ghost copy was found so far.
void Copy(vtkImageData* part, vtkImageData* image, std::vector<Knowledge>& known)
{
  vtkPointData* arrays = image->GetPointData();
  vtkUnsignedCharArray* ghosts = part->GetPointGhostArray();
  const Extent whole = ExtentOf(image);
  const Extent e = ExtentOf(part);
  vtkIdType from = 0;
  for (int k = e[4]; k <= e[5]; ++k)
  {
    for (int j = e[2]; j <= e[3]; ++j)
    {
      for (int i = e[0]; i <= e[1]; ++i, ++from)
      {
        if (!Contains(whole, { { i, i, j, j, k, k } }))
        {
          continue;
        }
        int at[3] = { i, j, k };
        const vtkIdType to = image->ComputePointId(at);
        const Knowledge now = ghosts && (ghosts->GetValue(from) & vtkDataSetAttributes::DUPLICATEPOINT) ? Ghost : Own;
        if (known[to] < now)
        {
          known[to] = now;
          for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
          {
            arrays->GetAbstractArray(a)->SetTuple(
              to, from, part->GetPointData()->GetAbstractArray(arrays->GetArrayName(a)));
          }
        }
      }
    }
  }
}

/// Makes the arrays active that are active in `from`. A copied array keeps only one active role, so an array that is
/// both the vectors and the scalars would lose one.
void CopyAttributes(vtkDataSetAttributes* from, vtkDataSetAttributes* to)
{
  for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
  {
    vtkAbstractArray* active = from->GetAbstractAttribute(attribute);
    if (active && active->GetName() && to->GetAbstractAttribute(attribute) == nullptr)
    {
      to->SetActiveAttribute(active->GetName(), attribute);
    }
  }
}

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
  image->ShallowCopy(whole);
  // After an error the extent shown may differ from the announced one.
  const Extent there = ExtentOf(whole);
  bool meets = true;
  for (int a = 0; a < 3; ++a)
  {
    meets = meets && part[2 * a] <= there[2 * a + 1] && there[2 * a] <= part[2 * a + 1];
  }
  if (IsEmpty(part) || !meets)
  {
    image->Initialize();
    image->SetExtent(const_cast<int*>(part.data()));
    image->GetFieldData()->ShallowCopy(whole->GetFieldData());
  }
  else if (!Contains(part, there))
  {
    image->GetPointData()->CopyAllOn();
    image->GetCellData()->CopyAllOn();
    image->Crop(part.data());
    CopyAttributes(whole->GetPointData(), image->GetPointData());
  }
  return image;
}

vtkSmartPointer<vtkImageData> PutTogether(const std::vector<vtkSmartPointer<vtkImageData>>& parts, const Extent& whole)
{
  vtkImageData* first = parts.front();
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetOrigin(first->GetOrigin());
  image->SetSpacing(first->GetSpacing());
  image->SetDirectionMatrix(first->GetDirectionMatrix());
  image->SetExtent(whole[0], whole[1], whole[2], whole[3], whole[4], whole[5]);
  image->GetFieldData()->ShallowCopy(first->GetFieldData());
  const vtkIdType voxels = image->GetNumberOfPoints();
  vtkPointData* arrays = image->GetPointData();
  arrays->CopyAllOn();
  arrays->CopyAllocate(first->GetPointData(), voxels);
  arrays->SetNumberOfTuples(voxels);

  std::vector<Knowledge> known(voxels, Missing);
  for (vtkImageData* part : parts)
  {
    Check(part, image);
    Copy(part, image, known);
  }
  if (const auto missing = std::count(known.begin(), known.end(), Missing))
  {
    throw chainmail::InputError("The processes' parts of the image leave out " + std::to_string(missing) + " of its " +
                                std::to_string(voxels) + " voxels. Give the whole image.");
  }
  // In the whole image no voxel duplicates one of another process.
  if (vtkUnsignedCharArray* ghosts = image->GetPointGhostArray())
  {
    for (vtkIdType v = 0; v < voxels; ++v)
    {
      ghosts->SetValue(v, ghosts->GetValue(v) & ~vtkDataSetAttributes::DUPLICATEPOINT);
    }
  }
  return image;
}

}
