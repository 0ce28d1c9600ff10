// SPDX-License-Identifier: BSD-3-Clause
// Samples arrays of numbers, each in its own type.

#ifndef NumericSampler_h
#define NumericSampler_h

#include "ArraySampler.h"
#include "Arrays.h"
#include "Grids.h"
#include "OutputBuffer.h"
#include "Threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

namespace vtkChainMail
{

/// Writes the smallest finite value of each component, 0 where there is none, and whether there is one.
template <typename T> void FindSmallest(const T* values, vtkIdType tuples, int components, T* smallest, char* found)
{
  for (int c = 0; c < components; ++c)
  {
    smallest[c] = T(0);
    found[c] = 0;
    for (vtkIdType t = 0; t < tuples; ++t)
    {
      const T value = values[t * components + c];
      const bool finite = value >= std::numeric_limits<T>::lowest() && value <= std::numeric_limits<T>::max();
      if (finite && (found[c] == 0 || value < smallest[c]))
      {
        smallest[c] = value;
        found[c] = 1;
      }
    }
  }
}

/// Samples arrays of numbers, stored interleaved: trilinear or nearest.
template <typename T> class NumericSampler : public ArraySampler
{
public:
  /// See MakeSampler().
  NumericSampler(vtkDataArray* original, const Grids& grids, bool nearest, double background, vtkDataArray* smallest,
    const PaddingValues& notMeasured, const TissueTest& isTissue, const FarValues& far)
    : Original(original)
    , Input(Interleaved(original))
    , Components(this->Input->GetNumberOfComponents())
    , Near(this->Input, grids.Held, isTissue)
    , Far(far.Array ? Interleaved(far.Array) : nullptr, far.Box, far.IsTissue)
    , G(grids)
    , Nearest(nearest)
    , BackgroundValue(background)
    , Smallest(smallest)
    , NotMeasured(notMeasured)
    , HasPadding(notMeasured.AreThere())
  {
  }

  std::uint64_t Begin() override { return this->Since = this->Buffers.Begin(); }

  void Sample(const std::vector<chainmail::ResampledBox>& boxes) override
  {
    this->MakeOutput();
    this->Buffers.Get().Touch(boxes, this->G, this->Bytes(1));
    const bool isOld = this->Since != 0; // the buffer may hold former values of voxels that are at rest now
    // Not with vtkSMPTools: in Debian's build of VTK they use one thread until an application requests more.
    chainmail::inParallel(boxes.size(),
      [&](std::size_t n)
      {
        boxes[n].forCovered(
          [&](const std::array<int, 3>& voxel, const float* offset, float coverage)
          {
            if (isOld || !isAtRest(offset) || coverage < 1.0f)
            {
              this->SampleVoxel(voxel, offset, coverage);
            }
          });
      });
  }

  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool atRest) override
  {
    const bool isInput = atRest && this->G.AreAlike();
    if (!isInput)
    {
      this->MakeOutput();
    }
    if (this->Buffers.IsOpen())
    {
      this->Buffers.Get().Finish(number);
    }
    if (isInput)
    {
      return this->Original;
    }
    auto output = vtkSmartPointer<vtkDataArray>::Take(this->Input->NewInstance());
    Describe(output, this->Original);
    output->SetLookupTable(this->Original->GetLookupTable());
    this->Buffers.Get().Lend(output);
    return output;
  }

private:
  /// A box of voxels of the input.
  struct Part
  {
    Part(const vtkSmartPointer<vtkDataArray>& array, const chainmail::VoxelBox& box, const TissueTest& isTissue)
      : Array(array)
      , In(array ? static_cast<const T*>(array->GetVoidPointer(0)) : nullptr)
      , Box(box)
      , IsTissue(isTissue)
    {
      this->Step[0] = array ? array->GetNumberOfComponents() : 0;
      this->Step[1] = this->Step[0] * box.size[0];
      this->Step[2] = this->Step[1] * box.size[1];
    }

    vtkSmartPointer<vtkDataArray> Array;
    const T* In;
    chainmail::VoxelBox Box;
    TissueTest IsTissue;
    vtkIdType Step[3];
  };

  static constexpr bool IsWide = std::is_integral<T>::value && sizeof(T) == 8;

  /// The value of the type that is nearest to `value`.
  static T ToType(double value)
  {
    if constexpr (std::is_integral<T>::value)
    {
      const double rounded = std::floor(value + 0.5);
      // std::clamp would not do: the largest 64-bit integer is rounded up by one to a double, which overflows when cast
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

  /// Interpolation is in double. 64-bit integers do not fit into a double, but their difference from a neighbour
  /// (`base`) does, below 2^53.
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
  /// The difference larger - smaller, which may not fit into T.
  static std::uint64_t Magnitude(T larger, T smaller)
  {
    return static_cast<std::uint64_t>(larger) - static_cast<std::uint64_t>(smaller);
  }

  /// A value between a and b. Equal ends are returned as they are, without rounding and without inf - inf.
  static double Between(double a, double b, double share) { return a == b ? a : a + share * (b - a); }

  /// Interpolates along the axes 0 to `Axis`. Neighbours of weight 0 are not read, so a place on a voxel gets exactly
  /// its value, whatever its neighbours are.
  template <int Axis> static double Interpolate(const Part& from, const T* corner, const double* share, T base)
  {
    if constexpr (Axis < 0)
    {
      return ToDouble(*corner, base);
    }
    else
    {
      const double low = Interpolate<Axis - 1>(from, corner, share, base);
      return share[Axis] == 0.0
               ? low
               : Between(low, Interpolate<Axis - 1>(from, corner + from.Step[Axis], share, base), share[Axis]);
    }
  }

  struct Weighted
  {
    double Value;
    double Weight;
  };

  /// Like Interpolate(), but without weight for values outside tissue that are not finite, which would spread NaN into
  /// adjacent tissue, and for padding, whose blends occur in no scan. Non-finite values within tissue keep their
  /// weight: what is unknown there stays unknown.
  template <int Axis> Weighted InterpolateKnown(const Part& from, const T* corner, const double* share) const
  {
    if constexpr (Axis < 0)
    {
      const auto value = static_cast<double>(*corner);
      const bool known =
        !this->NotMeasured.Has(value) && (std::isfinite(value) || from.IsTissue((corner - from.In) / this->Components));
      return { value, known ? 1.0 : 0.0 };
    }
    else
    {
      const Weighted low = this->template InterpolateKnown<Axis - 1>(from, corner, share);
      if (share[Axis] == 0.0)
      {
        return low;
      }
      const Weighted high = this->template InterpolateKnown<Axis - 1>(from, corner + from.Step[Axis], share);
      const double part = share[Axis] * high.Weight;
      const double whole = (1.0 - share[Axis]) * low.Weight + part;
      return { high.Weight == 0.0  ? low.Value
               : low.Weight == 0.0 ? high.Value
                                   : Between(low.Value, high.Value, part / whole),
        whole };
    }
  }

  void SampleVoxel(const std::array<int, 3>& voxel, const float* offset, float coverage)
  {
    T* out = this->Out + this->Components * this->G.OutputId(voxel[0], voxel[1], voxel[2]);
    const bool rests = isAtRest(offset);
    if (std::isnan(offset[0]) || (rests && !this->G.IsInput(voxel)) || (this->Nearest && coverage < 0.5f))
    {
      std::copy(this->Background.begin(), this->Background.end(), out);
    }
    else if (rests && this->G.IsOnInput(voxel))
    {
      const int finer = this->G.Finer;
      const vtkIdType from = this->G.InputId(voxel[0] / finer, voxel[1] / finer, voxel[2] / finer);
      std::copy_n(this->Near.In + this->Components * from, this->Components, out);
    }
    else
    {
      this->SampleAt(this->PartFor(voxel, offset), voxel, offset, out);
      if (rests && this->HasPadding)
      {
        this->KeepPadding(voxel, out);
      }
    }
    if (coverage < 1.0f && !this->Nearest)
    {
      this->MixIn(1.0 - coverage, out);
    }
  }

  /// Mixes a share of the background into values. Where one of both is not finite, the one with the larger share is
  /// taken.
  void MixIn(double share, T* out) const
  {
    for (int c = 0; c < this->Components; ++c)
    {
      const T background = this->Background[c];
      const double difference = ToDouble(background, out[c]) - ToDouble(out[c], out[c]);
      if (std::isfinite(difference))
      {
        const double base = IsWide ? 0.0 : static_cast<double>(out[c]);
        out[c] = FromDouble(base + share * difference, out[c]);
      }
      else if (share > 0.5)
      {
        out[c] = background;
      }
    }
  }

  /// The part that has all voxels around a place.
  const Part& PartFor(const std::array<int, 3>& voxel, const float* offset) const
  {
    bool isNear = true;
    for (int a = 0; a < 3 && this->Far.In; ++a)
    {
      const double place =
        std::clamp(this->G.PlaceOf(voxel[a]) + static_cast<double>(offset[a]), 0.0, this->G.Size[a] - 1.0);
      const int first = this->Near.Box.first[a];
      isNear = isNear && place >= first && place <= first + this->Near.Box.size[a] - 1;
    }
    return isNear ? this->Near : this->Far;
  }

  void SampleAt(const Part& from, const std::array<int, 3>& voxel, const float* offset, T* out) const
  {
    const T* corner = from.In;
    vtkIdType step[3]; // to the next voxel; 0 at the last voxel, where the share is 0
    double share[3];
    for (int a = 0; a < 3; ++a)
    {
      const int first = from.Box.first[a];
      const int last = first + from.Box.size[a] - 1;
      const double place =
        std::min(std::max(this->G.PlaceOf(voxel[a]) + static_cast<double>(offset[a]), static_cast<double>(first)),
          static_cast<double>(last));
      const int index = static_cast<int>(this->Nearest ? place + 0.5 : place);
      share[a] = this->Nearest ? 0.0 : place - index;
      step[a] = index < last ? from.Step[a] : 0;
      corner += (index - first) * from.Step[a];
    }
    if (this->Nearest)
    {
      for (int c = 0; c < this->Components; ++c)
      {
        out[c] = this->NotMeasured.Has(static_cast<double>(corner[c])) ? this->Background[c] : corner[c];
      }
      return;
    }
    for (int c = 0; c < this->Components; ++c)
    {
      if (this->HasPadding && this->IsBesidePadding(corner + c, step))
      {
        this->SampleKnown(from, corner + c, share, c, out + c);
        continue;
      }
      if constexpr (!IsWide)
      {
        // The fast path for most voxels: no branches in Blend(). Results that are not finite go to SampleCarefully().
        const double value = Blend(corner + c, step, share);
        if (std::is_integral<T>::value || std::isfinite(value))
        {
          out[c] = Rounded(value);
          continue;
        }
      }
      this->SampleCarefully(from, corner + c, share, c, out + c);
    }
  }

  /// For an output voxel at rest: takes the value of the nearest input voxel where that is padding.
  void KeepPadding(const std::array<int, 3>& voxel, T* out) const
  {
    const T* nearest = this->Near.In;
    for (int a = 0; a < 3; ++a)
    {
      nearest += (static_cast<int>(this->G.PlaceOf(voxel[a]) + 0.5) - this->G.Held.first[a]) * this->Near.Step[a];
    }
    for (int c = 0; c < this->Components; ++c)
    {
      out[c] = this->NotMeasured.Has(static_cast<double>(nearest[c])) ? nearest[c] : out[c];
    }
  }

  /// Whether any of the eight voxels around a place is padding.
  bool IsBesidePadding(const T* corner, const vtkIdType* step) const
  {
    bool is = false;
    for (int n = 0; n < 8; ++n)
    {
      const T* at = corner + (n & 1 ? step[0] : 0) + (n & 2 ? step[1] : 0) + (n & 4 ? step[2] : 0);
      is = is || this->NotMeasured.Has(static_cast<double>(*at));
    }
    return is;
  }

  /// Samples the voxels that have weight. If the nearest voxel has none, its value is taken, or the background if it is
  /// padding. Otherwise tissue would grow by half a voxel on all sides.
  void SampleKnown(const Part& from, const T* corner, const double* share, int component, T* out) const
  {
    vtkIdType toNearest = 0;
    for (int a = 0; a < 3; ++a)
    {
      toNearest += share[a] >= 0.5 ? from.Step[a] : 0;
    }
    const Weighted nearest = this->template InterpolateKnown<-1>(from, corner + toNearest, share);
    if (nearest.Weight > 0.0)
    {
      *out = ToType(this->template InterpolateKnown<2>(from, corner, share).Value);
    }
    else
    {
      *out = this->NotMeasured.Has(nearest.Value) ? this->Background[component] : static_cast<T>(nearest.Value);
    }
  }

  /// Trilinear interpolation of one component. All eight values are read.
  static double Blend(const T* corner, const vtkIdType* step, const double* share)
  {
    double along[4];
    for (int row = 0; row < 4; ++row)
    {
      const T* from = corner + (row & 1 ? step[1] : 0) + (row & 2 ? step[2] : 0);
      const double low = static_cast<double>(from[0]);
      along[row] = low + share[0] * (static_cast<double>(from[step[0]]) - low);
    }
    const double low = along[0] + share[1] * (along[1] - along[0]);
    const double high = along[2] + share[1] * (along[3] - along[2]);
    return low + share[2] * (high - low);
  }

  /// Rounds an interpolated value to T, whose range contains it.
  static T Rounded(double value)
  {
    if constexpr (std::is_integral<T>::value)
    {
      // The floor of `up`. std::floor() would be a function call in builds for old processors.
      const double up = value + 0.5;
      const auto whole = static_cast<std::int64_t>(up);
      return static_cast<T>(whole - (up < static_cast<double>(whole) ? 1 : 0));
    }
    else
    {
      return static_cast<T>(value);
    }
  }

  /// Samples one component where values may not be finite, or not fit into a double.
  void SampleCarefully(const Part& from, const T* corner, const double* share, int component, T* out) const
  {
    if (share[0] == 0.0 && share[1] == 0.0 && share[2] == 0.0)
    {
      *out = *corner;
      return;
    }
    const double value = Interpolate<2>(from, corner, share, *corner);
    if constexpr (std::is_floating_point<T>::value)
    {
      if (!std::isfinite(value))
      {
        this->SampleKnown(from, corner, share, component, out);
        return;
      }
    }
    *out = FromDouble(value, *corner);
  }

  std::size_t Bytes(vtkIdType voxels) const { return static_cast<std::size_t>(voxels) * this->Components * sizeof(T); }

  /// Opens a buffer to write to that holds the result of the resampling `Since`, or of the undeformed input.
  void MakeOutput()
  {
    if (this->Buffers.IsOpen())
    {
      return;
    }
    this->MakeBackground();
    const bool isNew = this->Buffers.Open(this->Bytes(this->G.OutputVoxels()));
    this->Out = reinterpret_cast<T*>(this->Buffers.Get().GetData());
    if (isNew)
    {
      this->CopyInput();
    }
  }

  void CopyInput()
  {
    chainmail::inParallel(static_cast<std::size_t>(this->G.Width[2]),
      [&](std::size_t slice)
      {
        const int k = this->G.First[2] + static_cast<int>(slice);
        const vtkIdType voxels = static_cast<vtkIdType>(this->G.Width[0]) * this->G.Width[1];
        for (vtkIdType v = 0; v < voxels && !this->G.IsWithinInput(); ++v)
        {
          std::copy(this->Background.begin(), this->Background.end(),
            this->Out + this->Components * (v + voxels * static_cast<vtkIdType>(slice)));
        }
        this->G.ForRows(k, [&](const std::array<int, 3>& first, int count) { this->CopyRow(first, count); });
      });
  }

  /// Copies a row of output voxels within the input or, where the output is finer, interpolates them.
  void CopyRow(const std::array<int, 3>& first, int count)
  {
    if (this->G.Finer == 1)
    {
      std::memcpy(this->Out + this->Components * this->G.OutputId(first[0], first[1], first[2]),
        this->Near.In + this->Components * this->G.InputId(first[0], first[1], first[2]), this->Bytes(count));
      return;
    }
    const float rest[3] = { 0.0f, 0.0f, 0.0f };
    for (int i = 0; i < count; ++i)
    {
      this->SampleVoxel({ { first[0] + i, first[1], first[2] } }, rest, 1.0f);
    }
  }

  void MakeBackground()
  {
    if (!this->Background.empty())
    {
      return;
    }
    if (!std::isnan(this->BackgroundValue))
    {
      this->Background.assign(this->Components, ToType(this->BackgroundValue));
      return;
    }
    this->Background.resize(this->Components);
    if (this->Smallest)
    {
      std::copy_n(static_cast<const T*>(this->Smallest->GetVoidPointer(0)), this->Components, this->Background.begin());
      return;
    }
    std::vector<char> found(static_cast<std::size_t>(this->Components));
    FindSmallest(this->Near.In, this->G.InputVoxels(), this->Components, this->Background.data(), found.data());
  }

  vtkSmartPointer<vtkDataArray> Original;
  vtkSmartPointer<vtkDataArray> Input;
  int Components;
  Part Near; // the voxels of the output's own place
  Part Far;  // those that move into it from elsewhere; none where Near has all
  Grids G;
  bool Nearest;
  double BackgroundValue;
  vtkSmartPointer<vtkDataArray> Smallest;
  PaddingValues NotMeasured;
  bool HasPadding;
  std::vector<T> Background;

  OutputBuffers Buffers;
  std::uint64_t Since = 0; // see ArraySampler::Begin()
  T* Out = nullptr;
};

}

#endif
