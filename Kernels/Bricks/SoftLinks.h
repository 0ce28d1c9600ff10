#pragma once

#include "BrickTable.h"
#include "Context.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace chainmail
{

/// A link without a limit from one element to a fixed place: the combined pull of all soft probes that grab the element
/// (Probe::tolerance).
struct SoftLink
{
  std::size_t voxel = 0;         ///< the element, Grid::at
  double weight = 0.0;           ///< energy above `least` = weight * (distance from `place`)^2 [mean spacings]
  std::array<double, 3> place{}; ///< the displacement of least energy [fractions of the spacing]
  double least = 0.0;            ///< the energy there, from probes that pull to different places [mean spacings]
};

/// The soft links of a grid, on the host and on the device (softlinks.clh), where only bricks with soft links take
/// memory.
class SoftLinks
{
public:
  /// Takes links in ascending order of voxels, at most one per voxel.
  SoftLinks(Context& context, const BrickTable& table, const Grid& grid, std::vector<SoftLink> links);
  /// Soft links of all elements of these bricks, on the device alone: a kernel writes values() before anything reads
  /// them, with a row for each brick in this order.
  SoftLinks(Context& context, const BrickTable& table, const Grid& grid, const std::vector<int>& bricks);

  /// Reads the links of these elements (ascending) from the device, and replaces all() by them. Elements of bricks
  /// without soft links have none.
  void read(Context& context, const BrickTable& table, const Grid& grid, const std::vector<std::size_t>& voxels);

  const cl::Buffer& values() const { return this->values_; }
  const std::vector<SoftLink>& all() const { return this->links_; }
  /// The link of an element; null where it has none.
  const SoftLink* of(std::size_t voxel) const;

  /// The factor that makes the weights comparable with those of links between elements, in a sweep along an axis.
  /// Without rotations, the weights of links are for lengths in spacings of that axis.
  double factor(int axis, bool rotates) const { return rotates ? 1.0 : this->proportions_.s[axis]; }
  const cl_float4& proportions() const { return this->proportions_; }
  /// The sum of SoftLink::least [mm]. Kernels compute only the energy above it.
  double least() const { return this->least_; }

  /// SOFT_ARGUMENTS of softlinks.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_float4>(this->rows_, this->values_, this->proportions_);
  }
  std::size_t bytes() const { return this->bytes_; }

private:
  void allocate(Context& context, const std::vector<cl_int>& rows, std::size_t values, bool zeros, const char* purpose);

  std::vector<SoftLink> links_;
  cl::Buffer rows_;
  cl::Buffer values_;
  cl_float4 proportions_; ///< as Rotations::proportions
  double least_ = 0.0;
  std::size_t bytes_ = 0;
};

/// The spacing of each axis, divided by the geometric mean of all three; the fourth number is 0.
cl_float4 proportionsOf(const Grid& grid);

}
