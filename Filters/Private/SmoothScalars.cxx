// SPDX-License-Identifier: BSD-3-Clause
#include "SmoothScalars.h"

#include "Arrays.h"
#include "Threads.h"

#include "vtkFloatArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vtkChainMail
{

namespace
{

// [voxels] Rows are long enough for SIMD, and a tile with its halo fits into the cache.
constexpr std::array<int, 3> sizeOfTile{ { 32, 16, 16 } };

template <typename T> void ReadRow(const T* from, int components, int count, float* to)
{
  if (components == 1) // contiguous, for SIMD
  {
    std::copy_n(from, count, to);
    return;
  }
  for (int i = 0; i < count; ++i)
  {
    to[i] = static_cast<float>(from[static_cast<std::size_t>(i) * components]);
  }
}

}

/// The values of a box of voxels, x fastest.
struct SmoothScalars::Block
{
  explicit Block(const std::array<int, 3>& size, float value = 0.0f)
    : Size(size)
    , Values(static_cast<std::size_t>(size[0]) * size[1] * size[2], value)
  {
  }

  float* Row(int j, int k)
  {
    return this->Values.data() + static_cast<std::size_t>(this->Size[0]) * (j + this->Size[1] * k);
  }

  std::array<int, 3> Size;
  std::vector<float> Values;
};

SmoothScalars::SmoothScalars(
  std::shared_ptr<ArraySampler> scalars, const Grids& grids, double deviation, const PaddingValues& notMeasured)
  : Scalars(std::move(scalars))
  , G(grids)
  , Deviation(deviation)
  , Low(static_cast<float>(notMeasured.Low))
  , High(static_cast<float>(notMeasured.High))
  , Radius(RadiusOf(deviation, grids.Finer))
{
  std::vector<double> weights;
  double sum = 0.0;
  for (int n = -this->Radius; n <= this->Radius; ++n)
  {
    weights.push_back(n == 0 ? 1.0 : std::exp(-0.5 * std::pow(n / (deviation * grids.Finer), 2)));
    sum += weights.back();
  }
  for (double& weight : weights)
  {
    weight /= sum;
    this->Weights.push_back(static_cast<float>(weight));
  }
  const int window = 2 * this->Radius + 1;
  this->Whole = this->Convolved(Block({ { window, window, window } }, 1.0f)).Values.front();
  std::size_t tiles = 1;
  for (int a = 0; a < 3; ++a)
  {
    this->Tiles[a] = (grids.Width[a] + sizeOfTile[a] - 1) / sizeOfTile[a];
    tiles *= static_cast<std::size_t>(this->Tiles[a]);
  }
  this->Changed.assign(tiles, 0);
}

std::uint64_t SmoothScalars::Begin()
{
  const std::uint64_t since = this->Buffers.Begin();
  std::fill(this->Changed.begin(), this->Changed.end(), since == 0 ? 1 : 0);
  return since;
}

void SmoothScalars::Sample(const std::vector<chainmail::ResampledBox>& boxes)
{
  for (const chainmail::ResampledBox& box : boxes)
  {
    std::array<int, 3> low;
    std::array<int, 3> high;
    for (int a = 0; a < 3; ++a)
    {
      const int first = box.first[a] - this->G.First[a];
      low[a] = std::max(first - this->Radius, 0) / sizeOfTile[a];
      high[a] = std::min(first + box.size[a] - 1 + this->Radius, this->G.Width[a] - 1) / sizeOfTile[a];
    }
    for (int k = low[2]; k <= high[2]; ++k)
    {
      for (int j = low[1]; j <= high[1]; ++j)
      {
        const std::size_t row = this->Tiles[0] * (j + this->Tiles[1] * static_cast<std::size_t>(k));
        std::fill_n(this->Changed.begin() + static_cast<std::ptrdiff_t>(row) + low[0], high[0] - low[0] + 1, 1);
      }
    }
  }
}

vtkSmartPointer<vtkAbstractArray> SmoothScalars::End(std::uint64_t number, bool)
{
  const int components = this->Sampled->GetNumberOfComponents();
  const auto voxels = static_cast<std::size_t>(this->G.OutputVoxels());
  this->Buffers.Open(sizeof(float) * voxels * static_cast<std::size_t>(components));
  OutputBuffer& buffer = this->Buffers.Get();
  auto* const output = reinterpret_cast<float*>(buffer.GetData());
  this->Sampled = Interleaved(this->Sampled);
  std::vector<std::size_t> changed;
  for (std::size_t tile = 0; tile < this->Changed.size(); ++tile)
  {
    if (this->Changed[tile])
    {
      changed.push_back(tile);
      chainmail::ResampledBox box; // only its position and size are used
      const std::array<int, 3> first = this->FirstOf(tile);
      for (int a = 0; a < 3; ++a)
      {
        box.first[a] = first[a] + this->G.First[a];
        box.size[a] = std::min(sizeOfTile[a], this->G.Width[a] - first[a]);
      }
      buffer.Touch({ box }, this->G, sizeof(float) * static_cast<std::size_t>(components));
    }
  }
  chainmail::inParallel(changed.size() * static_cast<std::size_t>(components),
    [&](std::size_t n) { this->SmoothTile(changed[n / components], static_cast<int>(n % components), output); });
  buffer.Finish(number);
  const auto array =
    MakeArray<vtkFloatArray>(NameFor(this->Sampled->GetName() ? this->Sampled->GetName() : "").c_str(), components, 0);
  buffer.Lend(array);
  this->Sampled = nullptr;
  return array;
}

/// The first voxel of a tile, in indices from the output's first voxel.
std::array<int, 3> SmoothScalars::FirstOf(std::size_t tile) const
{
  const auto along = [&](int a, std::size_t n) { return sizeOfTile[a] * static_cast<int>(n); };
  const std::size_t row = tile / this->Tiles[0];
  return { { along(0, tile % this->Tiles[0]), along(1, row % this->Tiles[1]), along(2, row / this->Tiles[1]) } };
}

/// Reads a box of the output's scalars, with NaN outside the image.
SmoothScalars::Block SmoothScalars::Read(
  const std::array<int, 3>& first, const std::array<int, 3>& size, int component) const
{
  Block block(size, std::numeric_limits<float>::quiet_NaN());
  const int components = this->Sampled->GetNumberOfComponents();
  const int low = std::max(first[0], 0);
  const int count = std::min(first[0] + size[0], this->G.Width[0]) - low;
  for (int k = std::max(-first[2], 0); k < std::min(size[2], this->G.Width[2] - first[2]); ++k)
  {
    for (int j = std::max(-first[1], 0); j < std::min(size[1], this->G.Width[1] - first[1]); ++j)
    {
      const vtkIdType voxel =
        low + this->G.Width[0] * (first[1] + j + this->G.Width[1] * static_cast<vtkIdType>(first[2] + k));
      const void* from = this->Sampled->GetVoidPointer(voxel * components + component);
      float* to = block.Row(j, k) + (low - first[0]);
      switch (this->Sampled->GetDataType())
      {
        vtkTemplateMacro(ReadRow(static_cast<const VTK_TT*>(from), components, count, to));
      }
    }
  }
  return block;
}

/// The separable convolution of a block with Weights along all axes. The result is smaller by Radius on all sides.
SmoothScalars::Block SmoothScalars::Convolved(Block values) const
{
  for (int a = 0; a < 3; ++a)
  {
    std::array<int, 3> size = values.Size;
    size[a] -= 2 * this->Radius;
    Block sums(size);
    for (int k = 0; k < size[2]; ++k)
    {
      for (int j = 0; j < size[1]; ++j)
      {
        float* sum = sums.Row(j, k);
        for (int n = 0; n <= 2 * this->Radius; ++n)
        {
          const float weight = this->Weights[static_cast<std::size_t>(n)];
          const float* value = values.Row(j + (a == 1 ? n : 0), k + (a == 2 ? n : 0)) + (a == 0 ? n : 0);
          for (int i = 0; i < size[0]; ++i)
          {
            sum[i] += weight * value[i];
          }
        }
      }
    }
    values = std::move(sums);
  }
  return values;
}

void SmoothScalars::SmoothTile(std::size_t tile, int component, float* output) const
{
  const std::array<int, 3> first = this->FirstOf(tile);
  std::array<int, 3> around;
  std::array<int, 3> size;
  for (int a = 0; a < 3; ++a)
  {
    around[a] = first[a] - this->Radius;
    size[a] = std::min(sizeOfTile[a], this->G.Width[a] - first[a]) + 2 * this->Radius;
  }
  Block values = this->Read(around, size, component);
  int unknown = 0; // without a branch, because this loop visits all voxels
  for (const float value : values.Values)
  {
    unknown |= this->IsKnown(value) ? 0 : 1;
  }
  const bool areKnown = unknown == 0;
  Block own(std::array<int, 3>{});
  Block known = own;
  if (!areKnown)
  {
    // Normalised convolution: the weighted mean of the known values.
    own = values;
    known = values;
    for (float& value : known.Values)
    {
      value = this->IsKnown(value) ? 1.0f : 0.0f;
    }
    for (std::size_t n = 0; n < values.Values.size(); ++n)
    {
      values.Values[n] = known.Values[n] > 0.0f ? values.Values[n] : 0.0f;
    }
    known = this->Convolved(std::move(known));
  }
  values = this->Convolved(std::move(values));
  const int components = this->Sampled->GetNumberOfComponents();
  for (int k = 0; k < values.Size[2]; ++k)
  {
    for (int j = 0; j < values.Size[1]; ++j)
    {
      float* out = output + component +
                   components * (first[0] + this->G.Width[0] *
                                              (first[1] + j + this->G.Width[1] * static_cast<vtkIdType>(first[2] + k)));
      const float* value = values.Row(j, k);
      for (int i = 0; i < values.Size[0]; ++i)
      {
        out[static_cast<std::ptrdiff_t>(i) * components] = value[i];
      }
      for (int i = 0; i < values.Size[0] && !areKnown; ++i)
      {
        const float itself = own.Row(j + this->Radius, k + this->Radius)[i + this->Radius];
        const float weight = known.Row(j, k)[i];
        // Where everything around is known, as in tiles without unknown values: so values do not depend on the tiles.
        out[static_cast<std::ptrdiff_t>(i) * components] = !this->IsKnown(itself)  ? itself
                                                           : weight == this->Whole ? value[i]
                                                                                   : value[i] / weight;
      }
    }
  }
}

}
