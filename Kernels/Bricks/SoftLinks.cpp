#include "SoftLinks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace chainmail
{

namespace
{

/// Components of a row of soft links (softlinks.clh).
constexpr std::size_t runs = 4;

}

cl_float4 proportionsOf(const Grid& grid)
{
  const double mean = std::cbrt(grid.spacing[0] * grid.spacing[1] * grid.spacing[2]);
  cl_float4 proportions{};
  for (int a = 0; a < 3; ++a)
  {
    proportions.s[a] = static_cast<float>(grid.spacing[a] / mean);
  }
  return proportions;
}

SoftLinks::SoftLinks(Context& context, const BrickTable& table, const Grid& grid, std::vector<SoftLink> links)
  : links_(std::move(links))
  , proportions_(proportionsOf(grid))
{
  const std::size_t elements = static_cast<std::size_t>(table.elementsPerBrick());
  std::vector<cl_int> rows(static_cast<std::size_t>(table.numbers()), -1);
  std::vector<cl_uint> addresses;
  std::vector<cl_float> values;
  const double mean = std::cbrt(grid.spacing[0] * grid.spacing[1] * grid.spacing[2]);
  cl_int count = 0;
  for (const SoftLink& link : this->links_)
  {
    this->least_ += link.least * mean;
    const Index3 at = grid.indexOf(link.voxel);
    cl_int& row = rows[static_cast<std::size_t>(table.brickAt(at[0], at[1], at[2]))];
    row = row < 0 ? count++ : row;
    addresses.push_back(static_cast<cl_uint>(runs * elements * row + table.local(at[0], at[1], at[2])));
    values.push_back(static_cast<cl_float>(link.weight));
    std::transform(link.place.begin(), link.place.end(), std::back_inserter(values),
      [](double place) { return static_cast<cl_float>(place); });
  }
  const char* purpose = "the soft probes";
  this->allocate(context, rows, runs * elements * static_cast<std::size_t>(count), true, purpose);
  const cl::Buffer list = context.upload(addresses, purpose);
  context.launchOver(context.kernel("scatter.cl", "", "scatter"), addresses.size(), this->values_,
    static_cast<cl_uint>(elements), static_cast<cl_int>(runs), list, context.upload(values, purpose));
  context.queue().finish();
}

SoftLinks::SoftLinks(Context& context, const BrickTable& table, const Grid& grid, const std::vector<int>& bricks)
  : proportions_(proportionsOf(grid))
{
  std::vector<cl_int> rows(static_cast<std::size_t>(table.numbers()), -1);
  for (std::size_t n = 0; n < bricks.size(); ++n)
  {
    rows[static_cast<std::size_t>(bricks[n])] = static_cast<cl_int>(n);
  }
  const std::size_t elements = static_cast<std::size_t>(table.elementsPerBrick());
  this->allocate(context, rows, runs * elements * bricks.size(), false, "the correction of a relaxation");
}

void SoftLinks::read(
  Context& context, const BrickTable& table, const Grid& grid, const std::vector<std::size_t>& voxels)
{
  this->links_.clear();
  const std::size_t elements = static_cast<std::size_t>(table.elementsPerBrick());
  std::vector<cl_int> rows(static_cast<std::size_t>(table.numbers()));
  context.read(this->rows_, rows);
  std::vector<cl_uint> addresses;
  for (const std::size_t voxel : voxels)
  {
    const Index3 at = grid.indexOf(voxel);
    const cl_int row = rows[static_cast<std::size_t>(table.brickAt(at[0], at[1], at[2]))];
    if (row >= 0)
    {
      this->links_.push_back({ voxel, 0.0, {}, 0.0 });
      addresses.push_back(static_cast<cl_uint>(runs * elements * row + table.local(at[0], at[1], at[2])));
    }
  }
  if (addresses.empty())
  {
    return;
  }
  const char* purpose = "the correction of a relaxation";
  std::vector<cl_float> values(runs * addresses.size());
  const cl::Buffer list = context.upload(addresses, purpose);
  const cl::Buffer found = context.allocate(sizeof(cl_float) * values.size(), purpose);
  context.launchOver(context.kernel("scatter.cl", "", "gather"), addresses.size(), this->values_,
    static_cast<cl_uint>(elements), std::numeric_limits<cl_uint>::max(), static_cast<cl_int>(runs), list, found);
  context.read(found, values);
  const cl_float* value = values.data();
  for (SoftLink& link : this->links_)
  {
    link.weight = *value++;
    for (double& place : link.place)
    {
      place = *value++;
    }
  }
}

/// Uploads the row of each brick, and allocates so many values, all 0 or with undefined content.
void SoftLinks::allocate(
  Context& context, const std::vector<cl_int>& rows, std::size_t values, bool zeros, const char* purpose)
{
  const std::size_t bytes = sizeof(cl_float) * values;
  this->rows_ = context.upload(rows, purpose);
  this->values_ = context.allocate(bytes, purpose, zeros ? bytes : 1);
  this->bytes_ = sizeof(cl_int) * rows.size() + bytes;
}

const SoftLink* SoftLinks::of(std::size_t voxel) const
{
  const auto found = std::lower_bound(this->links_.begin(), this->links_.end(), voxel,
    [](const SoftLink& link, std::size_t other) { return link.voxel < other; });
  return found != this->links_.end() && found->voxel == voxel ? &*found : nullptr;
}

}
