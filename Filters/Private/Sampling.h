// SPDX-License-Identifier: BSD-3-Clause
// Samples the point arrays of an image at displaced places, each in its own type.

#ifndef Sampling_h
#define Sampling_h

#include "Arrays.h"

#include "Model.h"

#include "vtkBitArray.h"
#include "vtkSMPTools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

namespace vtkChainMail
{

/// The size of an image with `padding` more voxels on every side. Axes with a single voxel are not padded.
inline chainmail::Grid Padded(const std::array<int, 3>& size, int padding)
{
  chainmail::Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = size[a] + (size[a] > 1 ? 2 * padding : 0);
  }
  return grid;
}

/// The most padding, up to `wanted`, with which the image has no more voxels than can be handled.
inline int FittingPadding(const std::array<int, 3>& size, int wanted)
{
  while (wanted > 0 && !Padded(size, wanted).fits())
  {
    --wanted;
  }
  return wanted;
}

/// The input's grid and the padded grid of the output. Indices are those of the input, from 0, so output voxels in the
/// padding have a negative index or one beyond the size.
struct Grids
{
  std::array<int, 3> Size;
  std::array<int, 3> Padding;

  bool IsPadded() const { return this->Padding != std::array<int, 3>{ { 0, 0, 0 } }; }
  vtkIdType InputVoxels() const { return static_cast<vtkIdType>(this->Size[0]) * this->Size[1] * this->Size[2]; }
  vtkIdType OutputWidth(int axis) const { return this->Size[axis] + 2 * static_cast<vtkIdType>(this->Padding[axis]); }
  vtkIdType OutputVoxels() const { return this->OutputWidth(0) * this->OutputWidth(1) * this->OutputWidth(2); }
  /// The same for the cells between the voxels.
  Grids Cells() const
  {
    Grids cells = *this;
    for (int& width : cells.Size)
    {
      width = std::max(width - 1, 1);
    }
    return cells;
  }
  vtkIdType InputId(int i, int j, int k) const
  {
    return i + this->Size[0] * (j + this->Size[1] * static_cast<vtkIdType>(k));
  }
  vtkIdType OutputId(int i, int j, int k) const
  {
    return (i + this->Padding[0]) +
           this->OutputWidth(0) * ((j + this->Padding[1]) + this->OutputWidth(1) * (k + this->Padding[2]));
  }
};

/// A box of output voxels with the offset from each to the place its material came from, 3 numbers a voxel [voxels]. 0:
/// the voxel did not change. NaN: no material is left.
struct Box
{
  std::array<int, 3> First;
  std::array<int, 3> Size;
  const float* Offset;

  int Rows() const { return this->Size[1] * this->Size[2]; }

  /// Calls f(voxel, offset) for the voxels of a row that change.
  template <typename F> void ForChanged(int row, F&& f) const
  {
    std::array<int, 3> voxel = { { this->First[0], this->First[1] + row % this->Size[1],
      this->First[2] + row / this->Size[1] } };
    const float* offset = this->Offset + 3 * static_cast<std::size_t>(row) * this->Size[0];
    for (int n = 0; n < this->Size[0]; ++n, ++voxel[0], offset += 3)
    {
      // This is true for NaN, too.
      if (offset[0] != 0.0f || offset[1] != 0.0f || offset[2] != 0.0f)
      {
        f(voxel, offset);
      }
    }
  }
};

/// Tells whether a voxel of the input is tissue at rest. May be called from several threads.
using TissueTest = std::function<bool(vtkIdType)>;

/// Makes one array of the output from one of the input.
class ArraySampler
{
public:
  virtual ~ArraySampler() = default;

  /// Writes the values that change in the box.
  virtual void Sample(const Box& box) = 0;

  /// The output's array. It is the input's own one where nothing has changed and there is no padding.
  virtual vtkAbstractArray* GetOutput() = 0;
};

/// Samples arrays of numbers, stored interleaved: trilinear or nearest.
template <typename T> class NumericSampler : public ArraySampler
{
public:
  /// See MakeSampler().
  NumericSampler(
    vtkDataArray* original, const Grids& grids, bool nearest, double background, const TissueTest& isTissue)
    : Original(original)
    , Input(Interleaved(original))
    , In(static_cast<const T*>(this->Input->GetVoidPointer(0)))
    , Components(this->Input->GetNumberOfComponents())
    , G(grids)
    , Nearest(nearest)
    , BackgroundValue(background)
    , IsTissue(isTissue)
  {
    this->Step[0] = this->Components;
    this->Step[1] = this->Step[0] * grids.Size[0];
    this->Step[2] = this->Step[1] * grids.Size[1];
  }

  void Sample(const Box& box) override
  {
    this->MakeOutput();
    vtkSMPTools::For(0, box.Rows(),
      [&](vtkIdType first, vtkIdType last)
      {
        for (vtkIdType row = first; row < last; ++row)
        {
          box.ForChanged(static_cast<int>(row),
            [&](const std::array<int, 3>& voxel, const float* offset)
            {
              T* out = this->Out + this->Components * this->G.OutputId(voxel[0], voxel[1], voxel[2]);
              if (std::isnan(offset[0]))
              {
                std::copy(this->Background.begin(), this->Background.end(), out);
              }
              else
              {
                this->SampleAt(voxel, offset, out);
              }
            });
        }
      });
  }

  vtkAbstractArray* GetOutput() override
  {
    if (this->G.IsPadded())
    {
      this->MakeOutput();
    }
    return this->Output ? this->Output.Get() : this->Original.Get();
  }

private:
  static constexpr bool IsWide = std::is_integral<T>::value && sizeof(T) == 8;

  /// The value of the type that is nearest to `value`.
  static T ToType(double value)
  {
    if constexpr (std::is_integral<T>::value)
    {
      const double rounded = std::floor(value + 0.5);
      // std::clamp would not do: the largest 64-bit integer becomes larger by one as a double, and overflows on the way
      // back.
      return rounded <= static_cast<double>(std::numeric_limits<T>::lowest()) ? std::numeric_limits<T>::lowest()
             : rounded >= static_cast<double>(std::numeric_limits<T>::max())  ? std::numeric_limits<T>::max()
                                                                              : static_cast<T>(rounded);
    }
    else
    {
      return static_cast<T>(value);
    }
  }

  /// Interpolation is done in double. 64-bit integers do not fit into one, but their differences from a neighbour do,
  /// unless they are as large as 2^53.
  static double ToDouble(T value, T base)
  {
    if constexpr (IsWide)
    {
      return value >= base ? static_cast<double>(Magnitude(value, base)) : -static_cast<double>(Magnitude(base, value));
    }
    else
    {
      return static_cast<double>(value);
    }
  }
  static T FromDouble(double value, T base)
  {
    if constexpr (IsWide)
    {
      const double rounded = std::floor(value + 0.5);
      const std::uint64_t room = rounded < 0.0 ? Magnitude(base, std::numeric_limits<T>::lowest())
                                               : Magnitude(std::numeric_limits<T>::max(), base);
      const double distance = std::fabs(rounded);
      const std::uint64_t step = distance >= static_cast<double>(room) ? room : static_cast<std::uint64_t>(distance);
      const auto from = static_cast<std::uint64_t>(base);
      return static_cast<T>(rounded < 0.0 ? from - step : from + step);
    }
    else
    {
      return ToType(value);
    }
  }
  /// larger - smaller, which may not fit into T.
  static std::uint64_t Magnitude(T larger, T smaller)
  {
    return static_cast<std::uint64_t>(larger) - static_cast<std::uint64_t>(smaller);
  }

  /// A value between a and b. Equal ends are returned as they are, without rounding and without inf - inf.
  static double Between(double a, double b, double share) { return a == b ? a : a + share * (b - a); }

  /// Interpolates along the axes up to `Axis`. Neighbours of weight 0 are not read: a place on the grid gets the value
  /// that is there, whatever lies beside it.
  template <int Axis> double Interpolate(const T* corner, const double* share, T base) const
  {
    if constexpr (Axis < 0)
    {
      return ToDouble(*corner, base);
    }
    else
    {
      const double low = this->template Interpolate<Axis - 1>(corner, share, base);
      return share[Axis] == 0.0
               ? low
               : Between(
                   low, this->template Interpolate<Axis - 1>(corner + this->Step[Axis], share, base), share[Axis]);
    }
  }

  struct Weighted
  {
    double Value;
    double Weight;
  };

  /// Like Interpolate(), but values outside tissue that are not finite have no weight, since they would blot out tissue
  /// beside them. Values within tissue count even so: what is unknown there stays unknown. A place whose nearest voxel
  /// has no weight gets that voxel's value, as tissue would otherwise grow by half a voxel on all sides.
  template <int Axis> Weighted InterpolateKnown(const T* corner, const double* share) const
  {
    if constexpr (Axis < 0)
    {
      const bool known = std::isfinite(*corner) || this->IsTissue((corner - this->In) / this->Components);
      return { static_cast<double>(*corner), known ? 1.0 : 0.0 };
    }
    else
    {
      const Weighted low = this->template InterpolateKnown<Axis - 1>(corner, share);
      if (share[Axis] == 0.0)
      {
        return low;
      }
      const Weighted high = this->template InterpolateKnown<Axis - 1>(corner + this->Step[Axis], share);
      const double part = share[Axis] * high.Weight;
      const double whole = (1.0 - share[Axis]) * low.Weight + part;
      return { high.Weight == 0.0  ? low.Value
               : low.Weight == 0.0 ? high.Value
                                   : Between(low.Value, high.Value, part / whole),
        whole };
    }
  }

  void SampleAt(const std::array<int, 3>& voxel, const float* offset, T* out) const
  {
    const T* corner = this->In;
    vtkIdType toNearest = 0;
    double share[3];
    bool onGrid = true;
    for (int a = 0; a < 3; ++a)
    {
      const double place =
        std::min(std::max(voxel[a] + static_cast<double>(offset[a]), 0.0), static_cast<double>(this->G.Size[a] - 1));
      const double index = std::floor(this->Nearest ? place + 0.5 : place);
      share[a] = this->Nearest ? 0.0 : place - index;
      onGrid = onGrid && share[a] == 0.0;
      toNearest += share[a] >= 0.5 ? this->Step[a] : 0;
      corner += static_cast<vtkIdType>(index) * this->Step[a];
    }
    if (onGrid)
    {
      std::copy(corner, corner + this->Components, out);
      return;
    }
    for (int c = 0; c < this->Components; ++c)
    {
      const double value = this->template Interpolate<2>(corner + c, share, corner[c]);
      if constexpr (std::is_floating_point<T>::value)
      {
        if (!std::isfinite(value))
        {
          const Weighted nearest = this->template InterpolateKnown<-1>(corner + c + toNearest, share);
          out[c] = nearest.Weight > 0.0 ? ToType(this->template InterpolateKnown<2>(corner + c, share).Value)
                                        : static_cast<T>(nearest.Value);
          continue;
        }
      }
      out[c] = FromDouble(value, corner[c]);
    }
  }

  void MakeOutput()
  {
    if (this->Output)
    {
      return;
    }
    this->MakeBackground();
    this->Output.TakeReference(this->Input->NewInstance());
    Describe(this->Output, this->Original);
    Allocate(this->Output, this->G.OutputVoxels());
    this->Output->SetLookupTable(this->Original->GetLookupTable());
    this->Out = static_cast<T*>(this->Output->GetVoidPointer(0));
    if (this->G.IsPadded())
    {
      for (vtkIdType v = 0; v < this->G.OutputVoxels(); ++v)
      {
        std::copy(this->Background.begin(), this->Background.end(), this->Out + v * this->Components);
      }
    }
    const std::size_t row = static_cast<std::size_t>(this->G.Size[0]) * this->Components * sizeof(T);
    for (int k = 0; k < this->G.Size[2]; ++k)
    {
      for (int j = 0; j < this->G.Size[1]; ++j)
      {
        std::memcpy(this->Out + this->Components * this->G.OutputId(0, j, k),
          this->In + this->Components * this->G.InputId(0, j, k), row);
      }
    }
  }

  void MakeBackground()
  {
    if (!std::isnan(this->BackgroundValue))
    {
      this->Background.assign(this->Components, ToType(this->BackgroundValue));
      return;
    }
    this->Background.assign(this->Components, T(0));
    const vtkIdType voxels = this->G.InputVoxels();
    for (int c = 0; c < this->Components; ++c)
    {
      bool found = false;
      for (vtkIdType v = 0; v < voxels; ++v)
      {
        const T value = this->In[v * this->Components + c];
        const bool finite = value >= std::numeric_limits<T>::lowest() && value <= std::numeric_limits<T>::max();
        if (finite && (!found || value < this->Background[c]))
        {
          this->Background[c] = value;
          found = true;
        }
      }
    }
  }

  vtkSmartPointer<vtkDataArray> Original;
  vtkSmartPointer<vtkDataArray> Input;
  const T* In;
  int Components;
  Grids G;
  bool Nearest;
  double BackgroundValue;
  TissueTest IsTissue;
  vtkIdType Step[3];
  std::vector<T> Background;
  vtkSmartPointer<vtkDataArray> Output;
  T* Out = nullptr;
};

/// Samples arrays of bits, strings and variants: nearest. It is serial, since neighbouring bits share a byte, and
/// strings share a look-up table. The background is a bit of 0, an empty string or an invalid variant.
class TupleSampler : public ArraySampler
{
public:
  TupleSampler(vtkAbstractArray* input, const Grids& grids)
    : Input(input)
    , G(grids)
  {
  }

  void Sample(const Box& box) override
  {
    this->MakeOutput();
    for (int row = 0; row < box.Rows(); ++row)
    {
      box.ForChanged(row,
        [&](const std::array<int, 3>& voxel, const float* offset)
        {
          const vtkIdType id = this->G.OutputId(voxel[0], voxel[1], voxel[2]);
          if (std::isnan(offset[0]))
          {
            this->Output->SetTuple(id, 0, this->Background);
            return;
          }
          int place[3];
          for (int a = 0; a < 3; ++a)
          {
            const double index = std::floor(voxel[a] + static_cast<double>(offset[a]) + 0.5);
            place[a] = static_cast<int>(std::min(std::max(index, 0.0), static_cast<double>(this->G.Size[a] - 1)));
          }
          this->Output->SetTuple(id, this->G.InputId(place[0], place[1], place[2]), this->Input);
        });
    }
  }

  vtkAbstractArray* GetOutput() override
  {
    if (this->G.IsPadded())
    {
      this->MakeOutput();
    }
    return this->Output ? this->Output.Get() : this->Input.Get();
  }

private:
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
    if (this->G.IsPadded())
    {
      for (vtkIdType v = 0; v < this->G.OutputVoxels(); ++v)
      {
        this->Output->SetTuple(v, 0, this->Background);
      }
    }
    for (int k = 0; k < this->G.Size[2]; ++k)
    {
      for (int j = 0; j < this->G.Size[1]; ++j)
      {
        const vtkIdType from = this->G.InputId(0, j, k);
        const vtkIdType to = this->G.OutputId(0, j, k);
        for (int i = 0; i < this->G.Size[0]; ++i)
        {
          this->Output->SetTuple(to + i, from + i, this->Input);
        }
      }
    }
  }

  vtkSmartPointer<vtkAbstractArray> Input;
  Grids G;
  vtkSmartPointer<vtkAbstractArray> Background;
  vtkSmartPointer<vtkAbstractArray> Output;
};

/// Makes the sampler for an array. A `background` of NaN stands for the array's own smallest finite value, by
/// component.
inline std::unique_ptr<ArraySampler> MakeSampler(
  vtkAbstractArray* input, const Grids& grids, bool nearest, double background, const TissueTest& isTissue)
{
  vtkDataArray* numbers = vtkDataArray::SafeDownCast(input);
  if (numbers)
  {
    switch (numbers->GetDataType())
    {
      vtkTemplateMacro(return std::make_unique<NumericSampler<VTK_TT>>(numbers, grids, nearest, background, isTissue));
    }
  }
  return std::make_unique<TupleSampler>(input, grids);
}

/// Handles an array of the grid and not of the material, such as which voxels are blank: it stays where it is, with 0
/// in the padding.
class StillArray : public ArraySampler
{
public:
  StillArray(vtkAbstractArray* input, const Grids& grids)
    : Padded(MakeSampler(input, grids, true, 0.0, nullptr))
  {
  }

  void Sample(const Box&) override {}

  vtkAbstractArray* GetOutput() override { return this->Padded->GetOutput(); }

private:
  std::unique_ptr<ArraySampler> Padded;
};

}

#endif
