#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace chainmail
{

using Index3 = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// A regular grid of voxels. The engine uses no origin and no direction matrix: its positions are lengths [mm] along
/// the image's own axes, measured from the centre of voxel (0, 0, 0). Arrays over a grid run x fastest, then y, then z.
struct Grid
{
  /// The largest number of voxels that an image may have, before or after deformation (6501 along each axis).
  static constexpr std::size_t maxVoxels = std::size_t(1) << 38;

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
    // The product of all three sizes may be too large for its type.
    const std::size_t layer = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
    return layer == 0 || static_cast<std::size_t>(size[2]) <= maxVoxels / layer;
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

/// A box of voxels of a grid. Arrays over a box run x fastest, then y, then z, as those over a grid do.
struct VoxelBox
{
  Index3 first{};
  Index3 size{};

  static VoxelBox all(const Grid& grid) { return { {}, grid.size }; }
  std::size_t voxels() const
  {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  bool contains(int i, int j, int k) const
  {
    return i >= first[0] && i < first[0] + size[0] && j >= first[1] && j < first[1] + size[1] && k >= first[2] &&
           k < first[2] + size[2];
  }
  bool contains(const VoxelBox& other) const
  {
    return this->contains(other.first[0], other.first[1], other.first[2]) &&
           this->contains(other.first[0] + other.size[0] - 1, other.first[1] + other.size[1] - 1,
             other.first[2] + other.size[2] - 1);
  }
  /// The place of a voxel of the grid in an array over this box.
  std::size_t at(int i, int j, int k) const
  {
    return static_cast<std::size_t>(i - first[0]) +
           static_cast<std::size_t>(size[0]) *
             (static_cast<std::size_t>(j - first[1]) + static_cast<std::size_t>(size[1]) * (k - first[2]));
  }
};

struct ReducedBox;

/// What one pass over the voxels of tissue finds.
struct TissueCounts
{
  static constexpr std::size_t none = ~std::size_t(0);

  std::size_t elements = 0;    ///< voxels of tissue
  std::size_t nonFinite = 0;   ///< voxels whose scalar is not finite
  std::size_t badVoxel = none; ///< the first one whose constraint is not in [0, 1); counting ends there
  std::string problem;         ///< what is wrong there

  /// Adds what was found in other voxels.
  void add(const TissueCounts& other)
  {
    this->elements += other.elements;
    this->nonFinite += other.nonFinite;
    if (other.badVoxel < this->badVoxel)
    {
      this->badVoxel = other.badVoxel;
      this->problem = other.problem;
    }
  }
};

/// A view of one array over a grid, in the type in which it is stored. It does not own the array, which may be in
/// memory or elsewhere.
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
  /// Where the array is elsewhere (`data` is null): reads the values of `count` voxels along x, from voxel number
  /// `first` on. They stay where they are until the next call. Called from one thread.
  std::function<const void*(std::size_t first, int count)> read;

  explicit operator bool() const { return this->data || this->read; }
};

/// A ball in which tissue has a constraint of its own, whatever the scan implies.
struct Region
{
  Vector3 centre{};        ///< [mm], see Grid
  double radius = 0.0;     ///< [mm]; voxels at this distance are in it
  double constraint = 0.0; ///< a fraction of the spacing on every axis, [0, 1)
};

/// How touching rigid tissue is divided into bodies that move independently. Where two bodies meet, voxels of one of
/// them at the other form a soft joint. They are voxels of the larger body, so small bones keep their shape. No link
/// between rigid voxels of two bodies remains, so a body is a connected component of rigid voxels. Stiff tissue between
/// two bodies gets such a layer, too, within some voxels of both.
///
/// With a constraint of 1 joints are free: bodies glide and rotate in them. The tissue within `margin` voxels of a body
/// then belongs to it, nearest first, and no links join the tissue of two bodies. The surrounding tissue holds them
/// together. Pictures are continuous across such a joint, as if the links existed.
struct Joints
{
  /// Whole numbers, 1 component: rigid voxels of different labels belong to different bodies. 0 (NaN): no label; each
  /// connected component without a label is a body of its own. Bodies come from the labels of rigid voxels alone;
  /// labels of other tissue only assign it to one of these bodies.
  ArrayView labels;
  /// Bridges of unlabelled rigid tissue that are thinner than this many voxels are joints where they connect parts more
  /// than twice as thick (see watershed()). Tissue enclosed in rigid tissue (marrow) counts as part of it. Parts that
  /// are not thick enough belong to a neighbour. A larger size finds the joints of a smaller one, and thicker ones. 0:
  /// none.
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
  /// Voxels with this scalar or a larger one are air, too: a number that stands for "not measured" may be large.
  double tissueCeiling = std::numeric_limits<double>::infinity();
  /// Scalar -> constraint as a fraction of the spacing, [0, 1); 0 is rigid. Called from one thread.
  std::function<double(double)> constraint;
  /// Replaces the function where it is given: 1 component (the same on every axis) or 3 (one per axis).
  ArrayView constraintArray;
  std::vector<Region> regions; ///< override function and array, later ones override earlier ones; air stays air
  Joints joints;

  // Where the arrays are elsewhere (ArrayView::read), or null: what Constraints does for all voxels, done there.
  std::function<TissueCounts()> count;
  /// Parts of a reduced model. The boxes do not overlap.
  std::function<std::vector<ReducedBox>(const Index3& factor)> reduce;
};

/// Tissue that is held in place from the start.
struct Anchors
{
  bool rigid = false; ///< all rigid elements
  std::array<bool, 6> faces{ { true, true, true, true, true,
    true } }; ///< x- x+ y- y+ z- z+ of the grid, on axes of more than one voxel
};

/// The tissue at rest: which voxels are elements, and their constraints. It reads the caller's arrays on demand and
/// copies nothing, so the arrays must outlive the model and must not change. Only the constructor reads the labels of
/// bodies.
class Model
{
public:
  /// Throws InputError like Grid::check(), and where no voxel is tissue or a constraint is not in [0, 1). Also where
  /// the place or radius of a region is not a finite number, or the labels of bodies are not single whole numbers.
  Model(const Grid& grid, const ArrayView& scalars, const Material& material, const Anchors& anchors);

  /// Reads the signed constraints (see row()) of `count` voxels along x, from voxel number `first` on.
  using RowReader = std::function<void(std::size_t first, int count, float* out)>;

  /// The link from a voxel (Grid::at) to the next one along an axis.
  using Link = std::pair<std::size_t, int>;

  /// Tissue whose row() is `rows`. `grid` must be one that the other constructor accepts. Checks nothing.
  Model(const Grid& grid, int axes, RowReader rows);

  /// The same tissue on another grid, where its row() is `rows`. `joints` are the voxels of joints, ascending, and
  /// `links` the links across free joints. Checks nothing.
  std::shared_ptr<const Model> derived(
    const Grid& grid, RowReader rows, std::vector<std::size_t> joints = {}, std::vector<Link> links = {}) const;

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

  /// Parts of this tissue, reduced by a factor where their voxels are (Material::reduce), if they are elsewhere. They
  /// do not know what the faces of the grid anchor.
  std::vector<ReducedBox> reduceElsewhere(const Index3& factor) const;

  /// Whether rigid tissue is divided into bodies, see Joints.
  bool isDivided() const { return this->divided_; }
  /// The voxels of joints (Grid::at), ascending.
  const std::vector<std::size_t>& joints() const { return this->joints_; }
  bool isJoint(std::size_t voxel) const;
  /// The links across free joints, which do not exist.
  const std::vector<Link>& linksOfJoints() const { return this->linksOfJoints_; }

  /// The face of the grid that anchors a voxel (numbered as in Anchors::faces), the first of several; -1 where none
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
  std::function<std::vector<ReducedBox>(const Index3&)> reduce_; ///< see reduceElsewhere(); may be null
  RowReader read_; ///< constraints of the arrays and regions, before joints_ and anchors_ are applied
};

}
