#pragma once

#include "BrickTable.h"
#include "Context.h"

#include <cstdint>
#include <tuple>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The signed distances [voxels] of grid points from the surfaces along which tissue was cut or carved, near these
/// surfaces. Between grid points they are interpolated, so that pictures show a cut surface where it is and not half
/// way between two elements.
class CutDistances
{
public:
  /// Grid points up to this far from a surface have a distance. The corners of a cell that a surface crosses are at
  /// most sqrt(3) away.
  static constexpr double farthest = 2.25;

  /// `table` must outlive this object and must not move.
  explicit CutDistances(const BrickTable& table)
    : table_(table)
  {
  }

  /// Stored as in cutdistance.clh, by brick, in the order of `local`.
  using Values = std::unordered_map<int, std::vector<std::uint16_t>>;
  const Values& all() const { return this->values_; }

  /// Starts a surface, from which the distances of set() are.
  void beginSurface();
  /// Sets the distance of a grid point, unless an earlier surface is nearer. A distance of 0 counts as positive.
  void set(int i, int j, int k, double distance);
  void clear();

  /// Copies the distances to the device for the bricks as they are now.
  void toDevice(Context& context);
  /// CUT_DISTANCE_ARGUMENTS of part.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&>(this->rows_.get(), this->distances_.get());
  }

private:
  const BrickTable& table_;
  Values values_;
  int surface_ = 0;
  Scratch rows_{ "the distances from cuts" };
  Scratch distances_{ "the distances from cuts" };
};

}
