#include "StepStart.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace chainmail
{

namespace
{

/// The kernel counts the squares of changes in units of 2^-48 of the square of the largest displacement, for which
/// float has no more digits. Sums of whole numbers do not depend on their order.
constexpr double unitsPerSquare = 281474976710656.0;

/// Elements that are displaced by a smaller share of the largest displacement do not count.
constexpr float leastDisplaced = 1e-3f;

/// The factors that bring displacements along each axis to the unit of lengths, `unit` times the spacing along x.
cl_float4 toUnit(const Grid& grid, float unit)
{
  cl_float4 factors{};
  for (int axis = 0; axis < 3; ++axis)
  {
    factors.s[axis] = static_cast<cl_float>(grid.spacing[axis] / grid.spacing[0] / unit);
  }
  return factors;
}

}

/// The largest displacement of an element in dirty bricks, in units of the spacing along x.
float StepStart::largest()
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.dirtySlots();
  const std::size_t items = this->bricks_.workItems(true);
  std::vector<cl_float> squares(slots.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_float) * std::max<std::size_t>(1, squares.size()));
  context.launch(context.kernel("stepstart.cl", this->bricks_.definesOfRows(), "largestSquare"), slots.size(), items,
    this->list_.holding(context, slots), this->bricks_.pitch(), this->bricks_.displacement(),
    toUnit(this->bricks_.model().grid(), 1.0f), cl::Local(sizeof(cl_float) * items), result);
  context.read(result, squares);
  return squares.empty() ? 0.0f : std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

double StepStart::change()
{
  const float unit = this->largest();
  if (unit == 0.0f)
  {
    return 0.0;
  }
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.dirtySlots();
  constexpr std::size_t figures = 2;
  const std::size_t items = this->bricks_.workItems(true);
  std::vector<cl_ulong> found(figures * slots.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_ulong) * found.size());
  context.launch(context.kernel("stepstart.cl", this->bricks_.definesOfRows(), "measureStep"), slots.size(), items,
    this->list_.holding(context, slots), this->bricks_.pitch(), this->start_.buffer, this->bricks_.displacement(),
    toUnit(this->bricks_.model().grid(), unit), leastDisplaced * leastDisplaced,
    cl::Local(sizeof(cl_ulong) * figures * items), result);
  context.read(result, found);
  std::uint64_t low = 0; // the sum of the lower halves of the squares, and that of the upper ones
  std::uint64_t high = 0;
  std::size_t displaced = 0;
  for (std::size_t n = 0; n < found.size(); n += figures)
  {
    low += found[n] & 0xffffffffu;
    high += found[n] >> 32;
    displaced += static_cast<std::size_t>(found[n + 1]);
  }
  const double squares = (4294967296.0 * static_cast<double>(high) + static_cast<double>(low)) / unitsPerSquare;
  return std::sqrt(squares / static_cast<double>(displaced));
}

void StepStart::goBack(float share)
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.dirtySlots();
  context.launch(context.kernel("stepstart.cl", this->bricks_.definesOfRows(), "goBack"), slots.size(),
    this->bricks_.workItems(true), this->list_.holding(context, slots), this->bricks_.pitch(), share,
    this->start_.buffer, this->bricks_.displacement());
}

void StepStart::restore()
{
  this->bricks_.context().queue().enqueueCopyBuffer(
    this->start_.buffer, this->bricks_.displacement(), 0, 0, sizeof(cl_float) * 3 * this->bricks_.pitch());
}

}
