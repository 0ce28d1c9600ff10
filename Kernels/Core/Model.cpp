#include "Model.h"

#include "Dispatch.h"
#include "ElementRule.h"
#include "Error.h"
#include "Format.h"
#include "Joints.h"
#include "ReducedBox.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>

namespace chainmail
{

namespace
{

constexpr float air = -std::numeric_limits<float>::infinity();

/// `where` returns the words that name the value. It is a function because only an error message needs them, and this
/// is called for every voxel.
template <typename Where> float checkedConstraint(double value, Where&& where)
{
  // Rounding to float must not turn 0.99999999999 into a constraint of 1.
  if (!(value >= 0.0) || !(static_cast<float>(value) < 1.0f))
  {
    throw InputError(
      "The constraint " + where() + " is " + toString(value) +
      ". A constraint is a fraction of the spacing from 0 (rigid) to less than 1: correct the material.");
  }
  return static_cast<float>(value) + 0.0f; // -0 would mark the element as held
}

/// Scalar -> constraint through the material function. Scalars of up to 16 bits get a table that is filled on demand.
template <typename T> class FunctionOfScalar
{
public:
  explicit FunctionOfScalar(const Material& material)
    : material_(material)
  {
    if constexpr (tabulated)
    {
      this->table_ = std::make_shared<std::vector<float>>(std::size_t(1) << (8 * sizeof(T)), unknown);
    }
  }

  float operator()(T scalar) const
  {
    if constexpr (tabulated)
    {
      float& entry = (*this->table_)[static_cast<std::make_unsigned_t<T>>(scalar)];
      if (entry == unknown)
      {
        entry = this->evaluate(scalar);
      }
      return entry;
    }
    else
    {
      return this->evaluate(scalar);
    }
  }

private:
  static constexpr bool tabulated = std::is_integral<T>::value && sizeof(T) <= 2;
  static constexpr float unknown = -1.0f;

  float evaluate(T scalar) const
  {
    const double value = static_cast<double>(scalar);
    if (!std::isfinite(value) || value < this->material_.tissueThreshold || value >= this->material_.tissueCeiling)
    {
      return air;
    }
    return checkedConstraint(this->material_.constraint(value), [&] { return "for a scalar of " + toString(value); });
  }

  Material material_;
  std::shared_ptr<std::vector<float>> table_;
};

int axesOf(const ArrayView& fractions)
{
  if (fractions.components != 1 && fractions.components != 3)
  {
    throw InputError("The constraint array has " + std::to_string(fractions.components) +
                     " components; it needs 1 (the same on every axis) or 3 (one per axis).");
  }
  return fractions.components;
}

Model::RowReader readerOfArray(const ArrayView& scalars, const Material& material)
{
  const ArrayView& fractions = material.constraintArray;
  return dispatch(scalars,
    [&](const auto* scalar) -> Model::RowReader
    {
      const ArrayRows<std::decay_t<decltype(*scalar)>> scalarRows(scalars);
      return dispatch(fractions,
        [&](const auto* fraction) -> Model::RowReader
        {
          const ArrayRows<std::decay_t<decltype(*fraction)>> fractionRows(fractions);
          const double threshold = material.tissueThreshold;
          const double ceiling = material.tissueCeiling;
          const std::size_t stride = scalars.components;
          const std::size_t component = scalars.component;
          const int axes = fractions.components;
          return [=](std::size_t first, int count, float* out)
          {
            const auto* values = scalarRows(first, count) + component;
            const auto* given = fractionRows(first, count);
            for (int n = 0; n < count; ++n)
            {
              const double value = static_cast<double>(values[n * stride]);
              const bool tissue = std::isfinite(value) && value >= threshold && value < ceiling;
              for (int a = 0; a < axes; ++a)
              {
                out[n * axes + a] = !tissue
                                      ? air
                                      : checkedConstraint(static_cast<double>(given[n * axes + a]), [&]
                                          { return "in the constraint array at voxel " + std::to_string(first + n); });
              }
            }
          };
        });
    });
}

Model::RowReader readerOfFunction(const ArrayView& scalars, const Material& material)
{
  if (!material.constraint)
  {
    throw InputError("No material was given: neither a function from scalar to constraint nor an array.");
  }
  return dispatch(scalars,
    [&](const auto* scalar) -> Model::RowReader
    {
      using T = std::decay_t<decltype(*scalar)>;
      const FunctionOfScalar<T> function(material);
      const ArrayRows<T> rows(scalars);
      const std::size_t stride = scalars.components;
      const std::size_t component = scalars.component;
      return [=](std::size_t first, int count, float* out)
      {
        const T* values = rows(first, count) + component;
        for (int n = 0; n < count; ++n)
        {
          out[n] = function(values[n * stride]);
        }
      };
    });
}

/// The tissue of `read`, with the constraints of regions.
Model::RowReader withRegions(
  const Grid& grid, int axes, const std::vector<Region>& regions, const Model::RowReader& read)
{
  std::vector<float> constraints;
  for (const Region& region : regions)
  {
    const bool isFinite =
      std::all_of(region.centre.begin(), region.centre.end(), [](double x) { return std::isfinite(x); });
    if (!isFinite || !(region.radius >= 0.0) || !std::isfinite(region.radius))
    {
      throw InputError("A region needs a finite place, and a radius of 0 or more.");
    }
    constraints.push_back(checkedConstraint(region.constraint, [] { return std::string("of a region"); }));
  }
  return [=](std::size_t first, int count, float* out)
  {
    read(first, count, out);
    const Index3 at = grid.indexOf(first);
    for (std::size_t r = 0; r < regions.size(); ++r)
    {
      const Region& region = regions[r];
      const double y = at[1] * grid.spacing[1] - region.centre[1];
      const double z = at[2] * grid.spacing[2] - region.centre[2];
      const double room = region.radius * region.radius - y * y - z * z;
      for (int n = 0; n < count && room >= 0.0; ++n)
      {
        const double x = (at[0] + n) * grid.spacing[0] - region.centre[0];
        float* c = out + static_cast<std::size_t>(n) * axes;
        if (x * x <= room && c[0] != air)
        {
          std::fill(c, c + axes, constraints[r]);
        }
      }
    }
  };
}

/// The values of tissue with their constraints, all of which it checks, and the number of its voxels.
std::pair<ConstraintsOfValues, std::size_t> countTissue(
  const std::vector<std::pair<double, std::size_t>>& counts, const Material& material)
{
  const FunctionOfScalar<double> function(material);
  std::pair<ConstraintsOfValues, std::size_t> found;
  for (const auto& [value, count] : counts)
  {
    const float c = function(value);
    if (c != air)
    {
      found.first.emplace_back(value, c);
      found.second += count;
    }
  }
  return found;
}

std::size_t countNonFinite(const ArrayView& scalars, const Grid& grid)
{
  return dispatch(scalars,
    [&](const auto* scalar) -> std::size_t
    {
      using T = std::decay_t<decltype(*scalar)>;
      std::size_t count = 0;
      if constexpr (std::is_floating_point<T>::value)
      {
        const ArrayRows<T> rows(scalars);
        const int width = grid.size[0];
        for (std::size_t first = 0; first < grid.voxels(); first += width)
        {
          const T* values = rows(first, width) + scalars.component;
          for (int n = 0; n < width; ++n)
          {
            count += !std::isfinite(values[static_cast<std::size_t>(n) * scalars.components]);
          }
        }
      }
      return count;
    });
}

}

void Grid::check() const
{
  for (int a = 0; a < 3; ++a)
  {
    if (this->size[a] < 1)
    {
      throw InputError("The image is empty: give one with at least one voxel on every axis.");
    }
    if (!(this->spacing[a] > 0.0) || !std::isfinite(this->spacing[a]))
    {
      throw InputError(
        "The spacing of the image is not positive on every axis. Set a positive spacing, for a single slice too.");
    }
  }
  if (!this->fits())
  {
    throw InputError("The image has " + toString(this->size) + " voxels; at most " + std::to_string(maxVoxels) +
                     " can be handled. Crop it or resample it to fewer.");
  }
}

Model::Model(const Grid& grid, const ArrayView& scalars, const Material& material, const Anchors& anchors)
  : grid_(grid)
  , anchors_(anchors)
{
  grid.check();
  if (!scalars)
  {
    throw InputError("The image has no scalars to tell tissue from air: choose an array.");
  }

  this->axes_ = material.constraintArray ? axesOf(material.constraintArray) : 1;
  this->read_ = material.constraintArray ? readerOfArray(scalars, material) : readerOfFunction(scalars, material);

  if (!material.regions.empty())
  {
    this->read_ = withRegions(grid, this->axes_, material.regions, this->read_);
  }

  // One pass over all voxels counts the elements and finds every constraint that is out of range before work begins.
  const bool isCounted = scalars.counts && !material.constraintArray;
  if (isCounted)
  {
    ConstraintsOfValues constraints;
    std::tie(constraints, this->elements_) = countTissue(scalars.counts(), material);
    if (scalars.reduce && material.regions.empty() && !material.joints.wanted())
    {
      for (auto& [value, c] : constraints)
      {
        c = rule::asHeld(c, anchors.rigid && c == 0.0f);
      }
      this->reduce_ = [reduce = scalars.reduce, constraints](const Index3& factor)
      { return reduce(factor, constraints); };
    }
  }
  const int width = grid.size[0];
  std::vector<float> row(static_cast<std::size_t>(width) * this->axes_);
  const std::size_t rows = isCounted ? 0 : static_cast<std::size_t>(grid.size[1]) * grid.size[2];
  for (std::size_t r = 0; r < rows; ++r)
  {
    this->read_(r * width, width, row.data());
    for (int i = 0; i < width; ++i)
    {
      this->elements_ += row[static_cast<std::size_t>(i) * this->axes_] != air;
    }
  }
  this->divide(material.joints);
  this->nonFinite_ = countNonFinite(scalars, grid);
  if (this->elements_ == 0)
  {
    throw InputError("The image is all air: no voxel has a finite scalar of at least the tissue threshold, " +
                     toString(material.tissueThreshold) + ". Lower TissueThreshold, or choose another MaterialPreset.");
  }
}

/// Finds the joints where bodies of rigid tissue meet.
void Model::divide(const Joints& joints)
{
  this->jointConstraint_ =
    joints.areFree() ? 0.0f : checkedConstraint(joints.constraint, [] { return std::string("of the joints"); });
  if (joints.size < 0)
  {
    throw InputError("The size of the joints is " + std::to_string(joints.size) + "; it has to be 0 (none) or more.");
  }
  if (joints.margin < 1 || joints.margin > 100)
  {
    throw InputError(
      "The margin of the joints is " + std::to_string(joints.margin) + "; it has to be 1 to 100 voxels.");
  }
  this->divided_ = joints.wanted();
  if (this->divided_)
  {
    FoundJoints found = findJoints(this->grid_, this->axes_, this->read_, joints);
    this->joints_ = std::move(found.voxels);
    this->linksOfJoints_ = std::move(found.links);
  }
}

Model::Model(const Grid& grid, int axes, RowReader rows)
  : grid_(grid)
  , axes_(axes)
  , read_(std::move(rows))
{
  this->anchors_.faces.fill(false);
}

std::shared_ptr<const Model> Model::derived(
  const Grid& grid, RowReader rows, std::vector<std::size_t> joints, std::vector<Link> links) const
{
  auto model = std::make_shared<Model>(grid, this->axes_, std::move(rows));
  model->joints_ = std::move(joints);
  model->linksOfJoints_ = std::move(links);
  return model;
}

std::vector<ReducedBox> Model::reduceElsewhere(const Index3& factor) const
{
  return this->reduce_ ? this->reduce_(factor) : std::vector<ReducedBox>();
}

bool Model::isJoint(std::size_t voxel) const
{
  return !this->joints_.empty() && std::binary_search(this->joints_.begin(), this->joints_.end(), voxel);
}

/// Makes the voxels of joints soft among `count` voxels, from voxel number `first` on.
void Model::soften(std::size_t first, int count, float* out) const
{
  const auto begin = std::lower_bound(this->joints_.begin(), this->joints_.end(), first);
  for (auto joint = begin; joint != this->joints_.end() && *joint < first + count; ++joint)
  {
    float* c = out + (*joint - first) * this->axes_;
    std::transform(c, c + this->axes_, c, [this](float one) { return std::max(one, this->jointConstraint_); });
  }
}

void Model::row(int i, int j, int k, int count, float* out) const
{
  this->read_(this->grid_.at(i, j, k), count, out);
  if (this->divided_)
  {
    this->soften(this->grid_.at(i, j, k), count, out);
  }
  const Index3& size = this->grid_.size;
  std::array<bool, 6> faces = this->anchors_.faces;
  for (int a = 0; a < 3; ++a)
  {
    // An axis with a single layer has no faces: holding them would hold everything.
    faces[2 * a] = faces[2 * a] && size[a] > 1;
    faces[2 * a + 1] = faces[2 * a + 1] && size[a] > 1;
  }
  const bool all =
    (faces[2] && j == 0) || (faces[3] && j == size[1] - 1) || (faces[4] && k == 0) || (faces[5] && k == size[2] - 1);
  const bool ends = (faces[0] && i == 0) || (faces[1] && i + count == size[0]);
  if (!all && !ends && !this->anchors_.rigid)
  {
    return; // nothing is held
  }
  for (int n = 0; n < count; ++n)
  {
    const bool face = all || (faces[0] && i + n == 0) || (faces[1] && i + n == size[0] - 1);
    float* c = out + static_cast<std::size_t>(n) * this->axes_;
    bool held = face;
    for (int a = 0; a < this->axes_; ++a)
    {
      held = held || (this->anchors_.rigid && c[a] == 0.0f);
    }
    for (int a = 0; a < this->axes_; ++a)
    {
      c[a] = rule::asHeld(c[a], held);
    }
  }
}

int Model::anchoringFace(int i, int j, int k) const
{
  const Index3 at{ i, j, k };
  for (int face = 0; face < 6; ++face)
  {
    const int size = this->grid_.size[face / 2];
    if (this->anchors_.faces[face] && size > 1 && at[face / 2] == (face % 2 == 0 ? 0 : size - 1))
    {
      return face;
    }
  }
  return -1;
}
}
