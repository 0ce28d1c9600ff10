#include "StepStart.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace chainmail
{

namespace
{

/// The kernel counts the squares of changes in units of 2^-48 of the square of the largest displacement, for which
/// float has no more digits. Sums of whole numbers do not depend on their order.
constexpr double unitsPerSquare = 281474976710656.0;

/// Elements that are displaced by a smaller share of the largest displacement do not count.
constexpr float leastDisplaced = 1e-3f;

}

/// What change() needs to know. Lengths are in units of measure().
struct StepStart::Change
{
  double squares = 0.0;      ///< the sum of the squares of all changes
  std::size_t displaced = 0; ///< the number of elements that count
  float largest = 0.0f;      ///< the square of the largest displacement
};

/// `unit`: of lengths, relative to the spacing along x.
StepStart::Change StepStart::measure(float unit)
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.dirtySlots();
  Change change;
  if (slots.empty())
  {
    return change;
  }
  constexpr std::size_t figures = 3;
  const std::size_t items = this->bricks_.workItems(true);
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  const auto scale = [&](int axis) { return static_cast<cl_float>(spacing[axis] / spacing[0] / unit); };
  std::uint64_t low = 0; // the sum of the lower halves of the squares, and that of the upper ones
  std::uint64_t high = 0;
  std::vector<cl_ulong> found(figures * slots.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_ulong) * found.size());
  context.launch(context.kernel("stepstart.cl", this->bricks_.definesOfRows(), "measureStep"), slots.size(), items,
    this->list_.holding(context, slots), this->bricks_.pitch(), this->start_.buffer, this->bricks_.displacement(),
    cl_float4{ { scale(0), scale(1), scale(2), 0.0f } }, leastDisplaced * leastDisplaced,
    cl::Local(sizeof(cl_ulong) * figures * items), result);
  context.read(result, found);
  for (std::size_t n = 0; n < found.size(); n += figures)
  {
    low += found[n] & 0xffffffffu;
    high += found[n] >> 32;
    change.displaced += static_cast<std::size_t>(found[n + 1]);
    const auto bits = static_cast<cl_uint>(found[n + 2]);
    float square = 0.0f;
    std::memcpy(&square, &bits, sizeof(square));
    change.largest = std::max(change.largest, square);
  }
  change.squares = (4294967296.0 * static_cast<double>(high) + static_cast<double>(low)) / unitsPerSquare;
  return change;
}

double StepStart::change()
{
  const float largest = std::sqrt(this->measure(1.0f).largest);
  if (largest == 0.0f)
  {
    return 0.0;
  }
  const Change change = this->measure(largest);
  return std::sqrt(change.squares / static_cast<double>(change.displaced));
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
