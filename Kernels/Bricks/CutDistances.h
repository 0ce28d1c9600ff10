#pragma once

#include "BrickTable.h"
#include "Context.h"

#include <cstdint>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace chainmail
{

/// The signed distances [voxels] of grid points from the surfaces along which tissue was cut or carved, near these
/// surfaces. Pictures interpolate them between grid points, and so show a cut surface where it is, not half way between
/// two elements.
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

  bool any() const { return !this->bricks_.empty(); }
  void clear()
  {
    this->bricks_.clear();
    this->changed_.clear();
  }

  /// The grid points of a brick.
  class Brick
  {
  public:
    explicit Brick(std::size_t points)
      : values_(points, 0)
      , squares_(points, 0)
    {
    }

    /// Adds a triangle for the grid point at `local`: the squared distance of the point from the triangle, and its
    /// signed distance from the triangle's plane, where 0 counts as positive. The nearest triangle counts, in whatever
    /// order they are added. Several are equally near where the point is nearest to an edge that they share. Of these,
    /// the one with the larger distance from its plane counts, because it has the right sign.
    void add(std::uint32_t local, double squared, double distance);

    const std::vector<std::uint16_t>& values() const { return this->values_; }
    void setValues(std::vector<std::uint16_t> values) { this->values_ = std::move(values); }

  private:
    std::vector<std::uint16_t> values_; ///< as in cutdistance.clh
    std::vector<std::uint16_t> squares_;
  };

  /// A brick to add distances to; it counts as changed.
  Brick& at(int brick)
  {
    this->changed_.insert(brick);
    return this->bricks_.try_emplace(brick, this->table_.elementsPerBrick()).first->second;
  }
  const std::unordered_map<int, Brick>& all() const { return this->bricks_; }
  /// The bricks that at() was called for since the last call of this function.
  std::set<int> takeChanged() { return std::exchange(this->changed_, {}); }

  /// Copies the distances to the device, for the slots as they are now.
  void toDevice(Context& context);
  /// `distanceRows, distances` of resample.clh.
  auto arguments() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&>(this->rows_.get(), this->distances_.get());
  }

private:
  const BrickTable& table_;
  std::unordered_map<int, Brick> bricks_;
  std::set<int> changed_;
  Scratch rows_{ "the distances from cuts" };
  Scratch distances_{ "the distances from cuts" };
};

}
