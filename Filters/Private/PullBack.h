// SPDX-License-Identifier: BSD-3-Clause
// Where the material of each output voxel comes from, as an array.

#ifndef PullBack_h
#define PullBack_h

#include "ArraySampler.h"
#include "Arrays.h"
#include "Frame.h"
#include "Grids.h"
#include "OutputBuffer.h"
#include "Threads.h"

#include "vtkFloatArray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vtkChainMail
{

/// Writes the array PullBack: the vector [mm, world axes] from a voxel to where its material was at rest, 0 where
/// nothing moved, NaN in the background.
class PullBackSampler : public ArraySampler
{
public:
  static constexpr const char* Name = "PullBack";

  /// `builds`: the number of the simulation (Session::GetBuilds()) whose resamplings follow.
  PullBackSampler(const Grids& grids, const Frame& frame, bool smoothCuts, int builds)
    : G(grids)
    , Space(frame)
    , SmoothCuts(smoothCuts)
    , Builds(builds)
  {
  }

  bool IsFor(const Grids& grids, const Frame& frame, bool smoothCuts, int builds) const
  {
    return this->G == grids && this->Space == frame && this->SmoothCuts == smoothCuts && this->Builds == builds;
  }

  std::uint64_t Begin() override { return this->Since = this->Buffers.Begin(); }

  void Sample(const std::vector<chainmail::ResampledBox>& boxes) override
  {
    this->Open();
    const bool isOld = this->Since != 0; // the buffer may hold former values of voxels that are at rest now
    this->Buffers.Get().Touch(boxes, this->G, Bytes(1));
    chainmail::inParallel(boxes.size(),
      [&](std::size_t n)
      {
        boxes[n].forVoxels(
          [&](const std::array<int, 3>& voxel, const float* offset)
          {
            float* out = this->Out + 3 * this->G.OutputId(voxel[0], voxel[1], voxel[2]);
            if (!isAtRest(offset))
            {
              this->Write(voxel, offset, out);
            }
            else if (isOld)
            {
              std::fill_n(out, 3, this->G.IsInput(voxel) ? 0.0f : Nowhere);
            }
          });
      });
  }

  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool) override
  {
    this->Open();
    this->Buffers.Get().Finish(number);
    const auto output = MakeArray<vtkFloatArray>(Name, 3, 0);
    this->Buffers.Get().Lend(output);
    return output;
  }

private:
  static constexpr float Nowhere = std::numeric_limits<float>::quiet_NaN();

  static std::size_t Bytes(vtkIdType voxels) { return 3 * sizeof(float) * static_cast<std::size_t>(voxels); }

  /// Material from outside the image is clamped to the image's border, as in all arrays.
  void Write(const std::array<int, 3>& voxel, const float* offset, float* out) const
  {
    if (std::isnan(offset[0]))
    {
      std::fill_n(out, 3, Nowhere);
      return;
    }
    float way[3];
    for (int a = 0; a < 3; ++a)
    {
      const double last = this->G.Size[a] - 1.0;
      const double place = this->G.PlaceOf(voxel[a]);
      const double inside = std::min(std::max(place + static_cast<double>(offset[a]), 0.0), last) - place;
      way[a] = static_cast<float>(inside * this->Space.GetSpacing()[a]);
    }
    this->Space.VectorToWorld(way, out);
  }

  void Open()
  {
    if (this->Buffers.IsOpen())
    {
      return;
    }
    const bool isNew = this->Buffers.Open(Bytes(this->G.OutputVoxels()));
    this->Out = reinterpret_cast<float*>(this->Buffers.Get().GetData());
    if (!isNew)
    {
      return;
    }
    chainmail::inParallel(static_cast<std::size_t>(this->G.Width[2]),
      [&](std::size_t slice)
      {
        const std::size_t values = 3 * static_cast<std::size_t>(this->G.Width[0]) * this->G.Width[1];
        std::fill_n(this->Out + values * slice, this->G.IsWithinInput() ? 0 : values, Nowhere);
        this->G.ForRows(this->G.First[2] + static_cast<int>(slice), [&](const std::array<int, 3>& first, int count)
          { std::fill_n(this->Out + 3 * this->G.OutputId(first[0], first[1], first[2]), 3 * count, 0.0f); });
      });
  }

  Grids G;
  Frame Space;
  bool SmoothCuts;
  int Builds;
  OutputBuffers Buffers;
  std::uint64_t Since = 0; // see ArraySampler::Begin()
  float* Out = nullptr;
};

}

#endif
