// SPDX-License-Identifier: BSD-3-Clause
// The scalars of the output, smoothed for a picture.

#ifndef SmoothScalars_h
#define SmoothScalars_h

#include "ArraySampler.h"
#include "Grids.h"
#include "OutputBuffer.h"

#include "vtkDataArray.h"
#include "vtkSmartPointer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vtkChainMail
{

/// Writes a second array of the output's scalars, as floats smoothed with a Gaussian. It works in tiles: an update
/// computes only the tiles within Radius of changed voxels.
class SmoothScalars : public ArraySampler
{
public:
  /// The name of the array.
  static std::string NameFor(const std::string& scalars) { return scalars + " smooth"; }

  /// `scalars`: the sampler of the scalars. `deviation`: the Gaussian's standard deviation [voxels of the input]; 0
  /// copies the scalars. `notMeasured`: values that stay unchanged and have no weight for other voxels, as have all
  /// values that are not finite.
  SmoothScalars(
    std::shared_ptr<ArraySampler> scalars, const Grids& grids, double deviation, const PaddingValues& notMeasured);

  /// Whether this object can continue from the last update: the sampler of the scalars and the deviation are the same.
  bool IsFor(const std::shared_ptr<ArraySampler>& scalars, double deviation) const
  {
    return this->Scalars == scalars && this->Deviation == deviation;
  }

  std::uint64_t Begin() override;
  void Sample(const std::vector<chainmail::ResampledBox>& boxes) override;
  /// To be called before End(): the output's scalars of this update.
  void SetSampled(vtkDataArray* sampled) { this->Sampled = sampled; }
  /// How many voxels around a voxel of the output have an influence on it.
  static int RadiusOf(double deviation, int finer) { return static_cast<int>(Reach * deviation * finer); }
  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool atRest) override;

private:
  struct Block;
  static constexpr double Reach = 3.0; // cut-off of the Gaussian [standard deviations]

  std::array<int, 3> FirstOf(std::size_t tile) const;
  /// Whether a value has weight. False for NaN, for padding, and for infinite values.
  bool IsKnown(float value) const { return value > this->Low && value < this->High; }
  Block Read(const std::array<int, 3>& first, const std::array<int, 3>& size, int component) const;
  Block Convolved(Block values) const;
  void SmoothTile(std::size_t tile, int component, float* output) const;

  std::shared_ptr<ArraySampler> Scalars;
  Grids G;
  double Deviation;
  float Low; // see PaddingValues
  float High;
  int Radius;
  std::vector<float> Weights; // 2 Radius + 1, with a sum of 1
  float Whole;                // their sum over a window, as it is rounded
  std::array<int, 3> Tiles;   // along each axis
  std::vector<char> Changed;  // for each tile
  vtkSmartPointer<vtkDataArray> Sampled;
  OutputBuffers Buffers;
};

}

#endif
