#include "Constraints.h"

#include "Dispatch.h"
#include "ElementRule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

namespace chainmail
{

namespace
{

constexpr float air = -std::numeric_limits<float>::infinity();

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

std::function<std::size_t(std::size_t first, int count)> nonFiniteCounter(const ArrayView& scalars)
{
  return dispatch(scalars,
    [&](const auto* scalar) -> std::function<std::size_t(std::size_t first, int count)>
    {
      using T = std::decay_t<decltype(*scalar)>;
      if constexpr (std::is_floating_point<T>::value)
      {
        return [rows = ArrayRows<T>(scalars), stride = static_cast<std::size_t>(scalars.components),
                 component = scalars.component](std::size_t first, int count)
        {
          const T* const values = rows(first, count) + component;
          std::size_t sum = 0;
          for (int n = 0; n < count; ++n)
          {
            sum += std::isfinite(values[n * stride]) ? 0 : 1;
          }
          return sum;
        };
      }
      return nullptr;
    });
}

}

void holdRigid(int axes, int count, float* constraints)
{
  for (float* c = constraints; c < constraints + static_cast<std::ptrdiff_t>(count) * axes; c += axes)
  {
    const bool held = std::find(c, c + axes, 0.0f) != c + axes;
    std::transform(c, c + axes, c, [held](float one) { return rule::asHeld(one, held); });
  }
}

Constraints::Constraints(const Grid& grid, const ArrayView& scalars, const Material& material)
  : grid_(grid)
  , axes_(material.constraintArray ? axesOf(material.constraintArray) : 1)
  , read_(material.constraintArray ? readerOfArray(scalars, material) : readerOfFunction(scalars, material))
  , countNonFinite_(nonFiniteCounter(scalars))
{
  if (!material.regions.empty())
  {
    this->read_ = withRegions(grid, this->axes_, material.regions, this->read_);
  }
}

TissueCounts Constraints::count(const VoxelBox& box) const
{
  TissueCounts found;
  const int width = box.size[0];
  std::vector<float> row(static_cast<std::size_t>(width) * this->axes_);
  const auto countRow = [&](std::size_t first)
  {
    try
    {
      this->read_(first, width, row.data());
    }
    catch (const InputError& error)
    {
      found.badVoxel = first;
      found.problem = error.what();
      return;
    }
    for (int i = 0; i < width; ++i)
    {
      found.elements += row[static_cast<std::size_t>(i) * this->axes_] != air ? 1 : 0;
    }
    found.nonFinite += this->countNonFinite_ ? this->countNonFinite_(first, width) : 0;
  };
  for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
  {
    for (int j = box.first[1]; j < box.first[1] + box.size[1] && found.badVoxel == TissueCounts::none; ++j)
    {
      countRow(this->grid_.at(box.first[0], j, k));
    }
  }
  for (int i = 0; i < width && found.badVoxel != TissueCounts::none; ++i) // which one of the row
  {
    try
    {
      this->read_(found.badVoxel + i, 1, row.data());
    }
    catch (const InputError&)
    {
      found.badVoxel += i;
      break;
    }
  }
  return found;
}

ReducedBox Constraints::reduce(const Index3& factor, bool anchored, const VoxelBox& box) const
{
  return reduceBox(this->grid_, factor, elementsWithin(this->grid_, factor, box), this->axes_,
    [&](int i, int j, int k, int count, float* out)
    {
      this->read_(this->grid_.at(i, j, k), count, out);
      if (anchored)
      {
        holdRigid(this->axes_, count, out);
      }
    });
}

}
