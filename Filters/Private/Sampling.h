// SPDX-License-Identifier: BSD-3-Clause
// Samples the point arrays of an image at displaced places, each in its own type.

#ifndef Sampling_h
#define Sampling_h

#include "ArraySampler.h"
#include "Arrays.h"
#include "Grids.h"
#include "NumericSampler.h"

#include "vtkBitArray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace vtkChainMail
{

/// Samples arrays of bits, strings and variants at the nearest voxel. Serial, because neighbouring bits share a byte,
/// and strings share a look-up table. The background is a bit of 0, an empty string or an invalid variant.
class TupleSampler : public ArraySampler
{
public:
  TupleSampler(vtkAbstractArray* input, const Grids& grids)
    : Input(input)
    , G(grids)
  {
  }

  std::uint64_t Begin() override
  {
    this->Output = nullptr;
    return 0;
  }

  void Sample(const std::vector<chainmail::ResampledBox>& boxes) override
  {
    this->MakeOutput();
    for (const chainmail::ResampledBox& box : boxes)
    {
      box.forVoxels(
        [&](const std::array<int, 3>& voxel, const float* offset)
        {
          if (std::isnan(offset[0]))
          {
            this->Output->SetTuple(this->G.OutputId(voxel[0], voxel[1], voxel[2]), 0, this->Background);
          }
          else if (!isAtRest(offset))
          {
            this->SampleAt(voxel, offset);
          }
        });
    }
  }

  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t, bool atRest) override
  {
    if (atRest && this->G.AreAlike())
    {
      return this->Input;
    }
    this->MakeOutput();
    return this->Output;
  }

private:
  void SampleAt(const std::array<int, 3>& voxel, const float* offset)
  {
    int place[3];
    for (int a = 0; a < 3; ++a)
    {
      const double index = std::floor(this->G.PlaceOf(voxel[a]) + static_cast<double>(offset[a]) + 0.5);
      place[a] = static_cast<int>(this->G.Inside(index, a));
    }
    this->Output->SetTuple(
      this->G.OutputId(voxel[0], voxel[1], voxel[2]), this->G.InputId(place[0], place[1], place[2]), this->Input);
  }

  void MakeOutput()
  {
    if (this->Output)
    {
      return;
    }
    this->Background.TakeReference(this->Input->NewInstance());
    this->Background->SetNumberOfComponents(this->Input->GetNumberOfComponents());
    this->Background->SetNumberOfTuples(1);
    if (vtkBitArray* bits = vtkBitArray::SafeDownCast(this->Background))
    {
      for (int c = 0; c < bits->GetNumberOfComponents(); ++c)
      {
        bits->SetValue(c, 0);
      }
    }
    this->Output.TakeReference(this->Input->NewInstance());
    Describe(this->Output, this->Input);
    this->Output->SetNumberOfTuples(this->G.OutputVoxels());
    for (vtkIdType v = 0; v < this->G.OutputVoxels() && !this->G.IsWithinInput(); ++v)
    {
      this->Output->SetTuple(v, 0, this->Background);
    }
    const float rest[3] = { 0.0f, 0.0f, 0.0f };
    for (int k = this->G.First[2]; k < this->G.First[2] + this->G.Width[2]; ++k)
    {
      this->G.ForRows(k,
        [&](const std::array<int, 3>& first, int count)
        {
          for (int i = 0; i < count; ++i)
          {
            this->SampleAt({ { first[0] + i, first[1], first[2] } }, rest);
          }
        });
    }
  }

  vtkSmartPointer<vtkAbstractArray> Input;
  Grids G;
  vtkSmartPointer<vtkAbstractArray> Background;
  vtkSmartPointer<vtkAbstractArray> Output;
};

/// Makes the sampler for an array. `background` NaN: the smallest finite value of the array, by component. This is
/// `smallest`, of one tuple, or null: where this process has the whole array, it can be found when it is needed. `far`:
/// what `input` lacks of what the output shows; only of arrays of numbers.
inline std::unique_ptr<ArraySampler> MakeSampler(vtkAbstractArray* input, const Grids& grids, bool nearest,
  double background, vtkDataArray* smallest, const PaddingValues& notMeasured, const TissueTest& isTissue,
  const FarValues& far = {})
{
  vtkDataArray* numbers = vtkDataArray::SafeDownCast(input);
  if (numbers)
  {
    switch (numbers->GetDataType())
    {
      vtkTemplateMacro(return std::make_unique<NumericSampler<VTK_TT>>(
        numbers, grids, nearest, background, smallest, notMeasured, isTissue, far));
    }
  }
  return std::make_unique<TupleSampler>(input, grids);
}

/// The smallest finite value of each component of an array, also of one that is spread over processes.
class Smallest
{
public:
  /// `array`: null or of bits where there is none.
  explicit Smallest(vtkDataArray* array)
  {
    if (!array || array->GetDataType() == VTK_BIT)
    {
      return;
    }
    this->Values = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
    this->Values->SetNumberOfComponents(array->GetNumberOfComponents());
    this->Values->SetNumberOfTuples(1);
    this->Found.assign(static_cast<std::size_t>(array->GetNumberOfComponents()), 0);
    const vtkSmartPointer<vtkDataArray> all = Interleaved(array);
    switch (array->GetDataType())
    {
      vtkTemplateMacro(FindSmallest(static_cast<const VTK_TT*>(all->GetVoidPointer(0)), all->GetNumberOfTuples(),
        all->GetNumberOfComponents(), static_cast<VTK_TT*>(this->Values->GetVoidPointer(0)), this->Found.data()));
    }
  }

  /// The values, and for each component whether it has any.
  std::vector<char> ToBytes() const
  {
    const auto* const first = static_cast<const char*>(this->Values->GetVoidPointer(0));
    std::vector<char> bytes(first, first + this->Found.size() * this->Values->GetDataTypeSize());
    bytes.insert(bytes.end(), this->Found.begin(), this->Found.end());
    return bytes;
  }
  /// Adds the values of another part.
  void Add(const std::vector<char>& bytes)
  {
    const char* const found = bytes.data() + bytes.size() - this->Found.size();
    const auto take = [&](auto* mine, const auto* others)
    {
      for (std::size_t c = 0; c < this->Found.size(); ++c)
      {
        if (found[c] != 0 && (this->Found[c] == 0 || others[c] < mine[c]))
        {
          mine[c] = others[c];
          this->Found[c] = 1;
        }
      }
    };
    switch (this->Values->GetDataType())
    {
      vtkTemplateMacro(
        take(static_cast<VTK_TT*>(this->Values->GetVoidPointer(0)), reinterpret_cast<const VTK_TT*>(bytes.data())));
    }
  }
  /// As an array of one tuple, with 0 where a component has none; null where the array does not hold numbers.
  vtkSmartPointer<vtkDataArray> ToArray() const { return this->Values; }

private:
  vtkSmartPointer<vtkDataArray> Values;
  std::vector<char> Found; // for each component
};

/// Handles an array that belongs to the grid and not to the material, such as marks of blank voxels. Its values stay in
/// place, with 0 in the padding.
class StillArray : public ArraySampler
{
public:
  StillArray(vtkAbstractArray* input, const Grids& grids)
    : Padded(MakeSampler(input, grids, true, 0.0, nullptr, PaddingValues(), nullptr))
  {
  }

  std::uint64_t Begin() override { return this->Padded->Begin(); }
  void Sample(const std::vector<chainmail::ResampledBox>&) override {}
  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool) override { return this->Padded->End(number, true); }

private:
  std::unique_ptr<ArraySampler> Padded;
};

}

#endif
