#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace chainmail
{

using Index3 = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// A regular grid of voxels. The engine knows no origin and no direction: its positions are lengths along the image's
/// own axes, measured from the centre of voxel (0, 0, 0). Arrays over a grid run x fastest, then y, then z.
struct Grid
{
  /// The most voxels of an image that is deformed, and of one that is made of it.
  static constexpr std::size_t maxVoxels = std::size_t(1) << 28;

  Index3 size{ 0, 0, 0 };           ///< voxels per axis
  Vector3 spacing{ 1.0, 1.0, 1.0 }; ///< [mm], positive

  /// Throws InputError: no voxels, a spacing that is not positive, more than maxVoxels.
  void check() const;

  std::size_t voxels() const
  {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  /// Whether there are at most maxVoxels.
  bool fits() const
  {
    // The product of all three need not fit its type.
    const std::size_t layer = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
    return layer <= maxVoxels && layer * static_cast<std::size_t>(size[2]) <= maxVoxels;
  }
  std::size_t at(int i, int j, int k) const
  {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size[0]) * (static_cast<std::size_t>(j) + static_cast<std::size_t>(size[1]) * k);
  }
  Index3 indexOf(std::size_t voxel) const
  {
    const std::size_t nx = static_cast<std::size_t>(size[0]);
    const std::size_t ny = static_cast<std::size_t>(size[1]);
    return { static_cast<int>(voxel % nx), static_cast<int>(voxel / nx % ny), static_cast<int>(voxel / (nx * ny)) };
  }
  bool contains(int i, int j, int k) const
  {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
};

/// A view of one array over a grid, in the type it is stored in. Not owned.
struct ArrayView
{
  enum class Type
  {
    None,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64
  };

  const void* data = nullptr;
  Type type = Type::None;
  int components = 1; ///< values per voxel, interleaved
  int component = 0;  ///< the one that is read as the scalar

  explicit operator bool() const { return this->data != nullptr; }
};

/// What the scan is made of.
struct Material
{
  /// Voxels with a smaller scalar, or with one that is not finite, are air: no elements.
  double tissueThreshold = 0.0;
  /// Scalar -> constraint as a fraction of the spacing, [0, 1); 0 is rigid. Called from one thread.
  std::function<double(double)> constraint;
  /// Wins over the function where given: 1 component (the same on every axis) or 3 (one per axis).
  ArrayView constraintArray;
};

/// Tissue that is held where it is from the start.
struct Anchors
{
  bool rigid = false; ///< all rigid elements
  std::array<bool, 6> faces{ { true, true, true, true, true,
    true } }; ///< x- x+ y- y+ z- z+ of the grid, on axes of more than one voxel
};

/// The tissue at rest: which voxels are elements and how far each may give. Reads the caller's arrays on demand and
/// keeps no copy of them: they must outlive the model unchanged.
class Model
{
public:
  /// Throws InputError: what Grid::check() finds, no finite tissue at all, a constraint outside [0, 1).
  Model(const Grid& grid, const ArrayView& scalars, const Material& material, const Anchors& anchors);

  /// Reads the signed constraints (see row()) of `count` voxels from one on along x.
  using RowReader = std::function<void(std::size_t first, int count, float* out)>;

  /// Tissue that is given as row() gives it. `grid` must be one that the other constructor takes.
  Model(const Grid& grid, int axes, RowReader rows);

  const Grid& grid() const { return this->grid_; }

  /// 1 where the constraint is the same on every axis, else 3.
  int axes() const { return this->axes_; }

  /// Number of elements of the whole grid (tissue voxels).
  std::size_t elements() const { return this->elements_; }

  /// Number of voxels whose scalar is not finite.
  std::size_t nonFinite() const { return this->nonFinite_; }

  /// The signed constraint of `count` voxels from (i, j, k) on along x, `axes()` interleaved values each: the
  /// magnitude is the constraint as a fraction of the spacing, the sign bit is set where the element is anchored
  /// (rigid and anchored: -0.0f). Air is minus infinity.
  void row(int i, int j, int k, int count, float* out) const;

  /// The face of the grid (as Anchors::faces) that a voxel is anchored by, the first of several; -1: none.
  int anchoringFace(int i, int j, int k) const;

private:
  Grid grid_;
  Anchors anchors_;
  int axes_ = 1;
  std::size_t elements_ = 0;
  std::size_t nonFinite_ = 0;
  RowReader read_; ///< before anchors_ are applied
};

}
