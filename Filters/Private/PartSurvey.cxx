// SPDX-License-Identifier: BSD-3-Clause
#include "PartSurvey.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace vtkChainMail
{

namespace
{

/// The values of an array from the voxel (i, j, k) on, along x.
template <typename T> const T* RowOf(const T* values, const Extent& ofArray, int i, int j, int k)
{
  const auto width = static_cast<std::size_t>(ofArray[1] - ofArray[0] + 1);
  const auto height = static_cast<std::size_t>(ofArray[3] - ofArray[2] + 1);
  return values + ((k - ofArray[4]) * height + (j - ofArray[2])) * width + (i - ofArray[0]);
}

/// Calls f(values) with a pointer of the type of an array that IsCountable().
template <typename F> void Dispatch(vtkDataArray* array, const F& f)
{
  const auto call = [&](const auto* values)
  {
    if constexpr (sizeof(*values) <= 2)
    {
      f(values);
    }
  };
  switch (array->GetDataType())
  {
    vtkTemplateMacro(call(static_cast<const VTK_TT*>(array->GetVoidPointer(0))));
  default:
    break;
  }
}

template <typename T> void Append(std::vector<char>& bytes, const T* values, std::size_t count)
{
  const auto* const first = reinterpret_cast<const char*>(values);
  bytes.insert(bytes.end(), first, first + sizeof(T) * count);
}

}

bool IsCountable(vtkDataArray* array)
{
  const int type = array->GetDataType();
  return array->GetNumberOfComponents() == 1 &&
         (type == VTK_CHAR || type == VTK_SIGNED_CHAR || type == VTK_UNSIGNED_CHAR || type == VTK_SHORT ||
           type == VTK_UNSIGNED_SHORT);
}

std::vector<double> CountValues(vtkDataArray* array, const Extent& ofArray, const Extent& part)
{
  std::vector<double> counts;
  const auto count = [&](const auto* values)
  {
    using T = std::decay_t<decltype(*values)>;
    constexpr int lowest = std::numeric_limits<T>::min();
    std::vector<std::uint64_t> of(std::size_t(1) << (8 * sizeof(T)), 0);
    for (int k = part[4]; k <= part[5]; ++k)
    {
      for (int j = part[2]; j <= part[3]; ++j)
      {
        const T* const first = RowOf(values, ofArray, part[0], j, k);
        std::for_each(first, first + (part[1] - part[0] + 1), [&](T value) { ++of[value - lowest]; });
      }
    }
    for (std::size_t n = 0; n < of.size(); ++n)
    {
      if (of[n] > 0)
      {
        counts.push_back(static_cast<double>(n) + lowest);
        counts.push_back(static_cast<double>(of[n]));
      }
    }
  };
  if (IsCountable(array))
  {
    Dispatch(array, count);
  }
  return counts;
}

chainmail::Grid Reduction::GetGrid() const
{
  chainmail::Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = this->Whole[2 * a + 1] - this->Whole[2 * a] + 1;
  }
  return grid;
}

chainmail::VoxelBox Reduction::ElementsIn(const Extent& part) const
{
  chainmail::VoxelBox box;
  for (int a = 0; a < 3; ++a)
  {
    box.first[a] = part[2 * a] - this->Whole[2 * a];
    box.size[a] = part[2 * a + 1] - part[2 * a] + 1;
  }
  return chainmail::elementsWithin(this->GetGrid(), this->Factor, box);
}

chainmail::ReducedBox Reduction::Reduce(vtkDataArray* array, const Extent& ofArray, const Extent& part) const
{
  chainmail::ReducedBox box;
  Dispatch(array,
    [&](const auto* values)
    {
      using T = std::decay_t<decltype(*values)>;
      constexpr int lowest = std::numeric_limits<T>::min();
      constexpr float air = -std::numeric_limits<float>::infinity();
      std::vector<float> of(std::size_t(1) << (8 * sizeof(T)), air);
      for (const auto& [value, constraint] : this->Constraints)
      {
        of[static_cast<std::size_t>(value - lowest)] = constraint;
      }
      box = chainmail::reduceBox(this->GetGrid(), this->Factor, this->ElementsIn(part), 1,
        [&](int i, int j, int k, int count, float* out)
        {
          const T* const first = RowOf(values, ofArray, this->Whole[0] + i, this->Whole[2] + j, this->Whole[4] + k);
          std::transform(first, first + count, out, [&](T value) { return of[value - lowest]; });
        });
    });
  return box;
}

std::vector<char> Reduction::Pack() const
{
  std::vector<char> bytes;
  Append(bytes, this->Whole.data(), this->Whole.size());
  Append(bytes, this->Factor.data(), this->Factor.size());
  for (const auto& [value, constraint] : this->Constraints)
  {
    const double both[] = { value, constraint };
    Append(bytes, both, 2);
  }
  return bytes;
}

Reduction Reduction::Unpack(const std::vector<char>& bytes)
{
  Reduction reduction;
  const char* from = bytes.data();
  std::memcpy(reduction.Whole.data(), from, sizeof(reduction.Whole));
  from += sizeof(reduction.Whole);
  std::memcpy(reduction.Factor.data(), from, sizeof(reduction.Factor));
  from += sizeof(reduction.Factor);
  for (double both[2]; from < bytes.data() + bytes.size(); from += sizeof(both))
  {
    std::memcpy(both, from, sizeof(both));
    reduction.Constraints.emplace_back(both[0], static_cast<float>(both[1]));
  }
  return reduction;
}

std::vector<char> Reduction::Pack(const chainmail::ReducedBox& box)
{
  std::vector<char> bytes;
  Append(bytes, box.constraints.data(), box.constraints.size());
  Append(bytes, box.linked.data(), box.linked.size());
  return bytes;
}

chainmail::ReducedBox Reduction::Unpack(const std::vector<char>& bytes, const Extent& part) const
{
  chainmail::ReducedBox box;
  box.elements = this->ElementsIn(part);
  box.constraints.resize(box.elements.voxels());
  box.linked.resize(box.elements.voxels());
  const std::size_t constraints = sizeof(float) * box.constraints.size();
  std::memcpy(box.constraints.data(), bytes.data(), constraints);
  std::memcpy(box.linked.data(), bytes.data() + constraints, box.linked.size());
  return box;
}

}
