#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace chainmail
{

using Index3 = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// A regular grid of voxels. The engine knows no origin and no direction matrix: its positions are lengths [mm] along
/// the image's own axes, measured from the centre of voxel (0, 0, 0). Arrays over a grid run x fastest, then y, then z.
struct Grid
{
  /// The most voxels that an image, deformed or to be deformed, may have.
  static constexpr std::size_t maxVoxels = std::size_t(1) << 31;

  Index3 size{ 0, 0, 0 };           ///< voxels per axis
  Vector3 spacing{ 1.0, 1.0, 1.0 }; ///< [mm], positive

  /// Throws InputError where there are no voxels, more than maxVoxels, or a spacing that is not positive.
  void check() const;

  std::size_t voxels() const
  {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  /// Whether there are at most maxVoxels.
  bool fits() const
  {
    // The product of all three sizes may be too large for its type, so two of them are multiplied first.
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

/// A view of one array over a grid, in the type in which it is stored. It does not own the array.
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
  int component = 0;  ///< the component that is read as the scalar

  explicit operator bool() const { return this->data != nullptr; }
};

/// A ball in which tissue has another constraint, whatever the scan says.
struct Region
{
  Vector3 centre{};        ///< [mm], see Grid
  double radius = 0.0;     ///< [mm]; voxels at this distance are in it
  double constraint = 0.0; ///< a fraction of the spacing on every axis, [0, 1)
};

/// Where rigid tissue that touches is divided into bodies, each of which moves by itself. Where two bodies meet, the
/// voxels of one of them at the other (those of the larger body, so that small bones keep their shape) form a soft
/// joint. Links between the bodies' rigid voxels do not remain, so a body is what rigid voxels are connected. Stiff
/// tissue between bodies gets such a layer, too, within some voxels of both.
///
/// With a constraint of 1 joints are free: bodies glide and turn in them. Each body then has the tissue within `margin`
/// voxels of it, nearest first, and no links join what two bodies have. What lies around holds them together. Pictures
/// go on across such a joint, as if the links were there.
struct Joints
{
  /// Whole numbers, 1 component: rigid voxels of different labels belong to different bodies. 0 (NaN): no label; what
  /// is connected of it is a body of its own. Nothing is read of it where voxels are not rigid.
  ArrayView labels;
  /// Bridges of unlabelled rigid tissue that are thinner than so many voxels are joints where they join parts at least
  /// twice as thick. Tissue enclosed in rigid tissue (marrow) counts as part of it. Thinner unlabelled tissue belongs
  /// to the body that is nearest within it. 0: none.
  int size = 0;
  double constraint = 0.5; ///< of the voxels of joints, a fraction of the spacing, [0, 1]; 0: no joints, 1: free ones
  int margin = 4;          ///< of free joints, [1, 100] voxels

  bool areFree() const { return this->constraint == 1.0; }
  bool wanted() const { return (this->labels || this->size > 0) && this->constraint > 0.0; }
};

/// How the scan's scalars become tissue.
struct Material
{
  /// Voxels whose scalar is smaller, or not finite, are air and have no element.
  double tissueThreshold = 0.0;
  /// Voxels whose scalar is this or larger are none, either: a number that stands for "not measured" may be large.
  double tissueCeiling = std::numeric_limits<double>::infinity();
  /// Scalar -> constraint as a fraction of the spacing, [0, 1); 0 is rigid. Called from one thread.
  std::function<double(double)> constraint;
  /// Takes the place of the function where it is given: 1 component (the same on every axis) or 3 (one per axis).
  ArrayView constraintArray;
  std::vector<Region> regions; ///< win over function and array, later ones over earlier ones; air stays air
  Joints joints;
};

/// Tissue that is held where it is from the start.
struct Anchors
{
  bool rigid = false; ///< all rigid elements
  std::array<bool, 6> faces{ { true, true, true, true, true,
    true } }; ///< x- x+ y- y+ z- z+ of the grid, on axes of more than one voxel
};

/// The tissue at rest: which voxels are elements and how far each of them may give. It reads the caller's arrays on
/// demand and copies nothing, so the arrays must outlive the model and must not change. Labels of bodies are read by
/// the constructor alone.
class Model
{
public:
  /// Throws InputError as Grid::check() does, where no voxel is tissue, where a constraint is not in [0, 1), where the
  /// place or radius of a region is no finite number, or where the labels of bodies are not single whole numbers.
  Model(const Grid& grid, const ArrayView& scalars, const Material& material, const Anchors& anchors);

  /// Reads the signed constraints (see row()) of `count` voxels along x, from voxel number `first` on.
  using RowReader = std::function<void(std::size_t first, int count, float* out)>;

  /// The link from a voxel (Grid::at) to the next one along an axis.
  using Link = std::pair<std::size_t, int>;

  /// Tissue that `rows` gives as row() would. `grid` must be one that the other constructor accepts. `joints` are the
  /// voxels of joints, ascending, and `links` those that free joints are without. Checks nothing.
  Model(const Grid& grid, int axes, RowReader rows, std::vector<std::size_t> joints = {}, std::vector<Link> links = {});

  const Grid& grid() const { return this->grid_; }

  /// 1 where the constraint is the same on every axis, else 3.
  int axes() const { return this->axes_; }

  /// Number of elements of the whole grid (tissue voxels).
  std::size_t elements() const { return this->elements_; }

  /// Number of voxels whose scalar is not finite.
  std::size_t nonFinite() const { return this->nonFinite_; }

  /// The signed constraints of `count` voxels along x from (i, j, k) on, `axes()` interleaved values each. The
  /// magnitude is the constraint as a fraction of the spacing; the sign bit is set where the element is anchored (rigid
  /// and anchored is -0.0f). Air is minus infinity.
  void row(int i, int j, int k, int count, float* out) const;

  /// Whether rigid tissue is divided into bodies, see Joints.
  bool isDivided() const { return this->divided_; }
  /// The voxels of joints (Grid::at), ascending.
  const std::vector<std::size_t>& joints() const { return this->joints_; }
  bool isJoint(std::size_t voxel) const;
  /// The links that free joints are without.
  const std::vector<Link>& linksOfJoints() const { return this->linksOfJoints_; }

  /// The face of the grid (a number as in Anchors::faces) that anchors a voxel, the first of several; -1 where none
  /// does.
  int anchoringFace(int i, int j, int k) const;

private:
  void divide(const Joints& joints);
  void soften(std::size_t first, int count, float* out) const;

  Grid grid_;
  Anchors anchors_;
  int axes_ = 1;
  std::size_t elements_ = 0;
  std::size_t nonFinite_ = 0;
  bool divided_ = false;
  float jointConstraint_ = 0.0f;
  std::vector<std::size_t> joints_;
  std::vector<Link> linksOfJoints_;
  RowReader read_; ///< what the arrays say, before anchors_ are applied
};

}
