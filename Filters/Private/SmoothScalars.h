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

/// Writes the scalars of the output once more, in floats and smoothed with a Gaussian. It works in tiles, of which an
/// update does those that are within reach of what it changed.
class SmoothScalars : public ArraySampler
{
public:
  /// What the array is called.
  static std::string NameFor(const std::string& scalars) { return scalars + " smooth"; }

  /// `scalars`: what samples the scalars. `deviation`: the Gaussian's standard deviation [voxels of the input], or 0.
  /// `notMeasured`: values that stay as they are and count for no other voxel; so do those that are not finite.
  SmoothScalars(
    std::shared_ptr<ArraySampler> scalars, const Grids& grids, double deviation, const PaddingValues& notMeasured);

  /// Whether this goes on from the last update, if the scalars do.
  bool IsFor(const std::shared_ptr<ArraySampler>& scalars, double deviation) const
  {
    return this->Scalars == scalars && this->Deviation == deviation;
  }

  std::uint64_t Begin() override;
  void Sample(const std::vector<chainmail::ResampledBox>& boxes) override;
  /// To be called before End(): the output's scalars of this update.
  void SetSampled(vtkDataArray* sampled) { this->Sampled = sampled; }
  vtkSmartPointer<vtkAbstractArray> End(std::uint64_t number, bool atRest) override;

private:
  struct Block;

  std::array<int, 3> FirstOf(std::size_t tile) const;
  /// False of NaN, and of infinite values where none stand for "not measured".
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
  std::array<int, 3> Tiles;   // along each axis
  std::vector<char> Changed;  // for each tile
  vtkSmartPointer<vtkDataArray> Sampled;
  OutputBuffers Buffers;
};

}

#endif
