#pragma once

#include "BrickTable.h"
#include "Context.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace chainmail
{

/// A link without a limit from one element to a place: that of all soft probes together that grip the element
/// (Probe::tolerance).
struct SoftLink
{
  std::size_t voxel = 0;         ///< the element, Grid::at
  double weight = 0.0;           ///< times the square of the way to the place it is the energy [mean spacings]
  std::array<double, 3> place{}; ///< the displacement that costs least [fractions of the spacing]
  double least = 0.0;            ///< what that costs, as probes pull to different places [mean spacings]
};

/// The soft links of a grid, on the host and on the device (softlinks.clh). There bricks without any take no memory.
class SoftLinks
{
public:
  /// Takes links in the order of voxels, one for each.
  SoftLinks(Context& context, const BrickTable& table, const Grid& grid, std::vector<SoftLink> links);

  const std::vector<SoftLink>& all() const { return this->links_; }
  /// The link of an element; null where it has none.
  const SoftLink* of(std::size_t voxel) const;

  /// The factor for weights in a sweep along an axis, which compares them with those of links between elements: where
  /// nothing turns these belong to lengths in spacings of that axis.
  double factor(int axis, bool turns) const { return turns ? 1.0 : this->proportions_.s[axis]; }
  const cl_float4& proportions() const { return this->proportions_; }
  /// What they all cost where each costs least [mm]: kernels know the rest of the energy alone.
  double least() const { return this->least_; }

  /// SOFT_ARGUMENTS of softlinks.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, cl_float4>(this->rows_, this->values_, this->proportions_);
  }
  std::size_t bytes() const { return this->bytes_; }

private:
  std::vector<SoftLink> links_;
  cl::Buffer rows_;
  cl::Buffer values_;
  cl_float4 proportions_; ///< as Spins::proportions
  double least_ = 0.0;
  std::size_t bytes_ = 0;
};

/// The spacing of a grid, divided by the geometric mean of that of the three axes; the fourth number is 0.
cl_float4 proportionsOf(const Grid& grid);

}
