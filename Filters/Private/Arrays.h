// SPDX-License-Identifier: BSD-3-Clause
// Allocates and copies arrays of numbers that may be as large as a scan.

#ifndef Arrays_h
#define Arrays_h

#include "vtkAbstractArray.h"
#include "vtkDataArray.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkVariant.h"
#include "vtkVersionMacros.h"

#include <cmath>
#include <cstdlib>
#include <new>

namespace vtkChainMail
{

/// Allocates memory for `tuples` tuples. With `zeros` it holds 0, and the system maps each page only on its first
/// write. Throws std::bad_alloc. VTK's own allocation would instead end the process, unless VTK is a release build.
inline void Allocate(vtkDataArray* array, vtkIdType tuples, bool zeros = false)
{
  const vtkIdType values = tuples * array->GetNumberOfComponents();
  const std::size_t size = static_cast<std::size_t>(array->GetDataTypeSize());
  void* memory = zeros ? std::calloc(values, size) : std::malloc(values * size);
  if (!memory && values > 0)
  {
    throw std::bad_alloc();
  }
  array->SetVoidArray(memory, values, 0, vtkAbstractArray::VTK_DATA_ARRAY_FREE);
}

/// Gives `array` the name, components and information of `like`.
inline void Describe(vtkAbstractArray* array, vtkAbstractArray* like)
{
  array->SetName(like->GetName());
  array->SetNumberOfComponents(like->GetNumberOfComponents());
  array->CopyComponentNames(like);
  if (like->HasInformation())
  {
    array->CopyInformation(like->GetInformation());
  }
}

/// An array with interleaved tuples (AOS): `array` itself, or a copy where its layout differs (by component, mapped,
/// ...). Not for bits.
inline vtkSmartPointer<vtkDataArray> Interleaved(vtkDataArray* array)
{
  if (array->HasStandardMemoryLayout())
  {
    return array;
  }
  auto copy = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
  Describe(copy, array);
  Allocate(copy, array->GetNumberOfTuples());
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 7, 0)
  array->ExportToVoidPointer(copy->GetVoidPointer(0)); // DeepCopy() rounds some 64-bit integers to doubles here
#else
  copy->DeepCopy(array); // into the memory allocated above
#endif
  return copy;
}

/// A new array of numbers with memory for `tuples` tuples, see Allocate().
template <typename ArrayType>
vtkSmartPointer<ArrayType> MakeArray(const char* name, int components, vtkIdType tuples, bool zeros = false)
{
  auto array = vtkSmartPointer<ArrayType>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  Allocate(array, tuples, zeros);
  return array;
}

/// Makes the copies of the image's active arrays active in `out`. Global ids are left out because they have to be
/// unique, and stretched tissue shows an id twice.
inline void CopyActiveAttributes(vtkPointData* arrays, vtkPointData* out)
{
  for (int attribute = 0; attribute < vtkDataSetAttributes::NUM_ATTRIBUTES; ++attribute)
  {
    vtkAbstractArray* active =
      attribute == vtkDataSetAttributes::GLOBALIDS ? nullptr : arrays->GetAbstractAttribute(attribute);
    for (int a = 0; active && a < arrays->GetNumberOfArrays(); ++a)
    {
      if (arrays->GetAbstractArray(a) == active)
      {
        out->SetActiveAttribute(a, attribute);
      }
    }
  }
}

}

#endif
