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
constexpr float unitsPerSquare = 281474976710656.0f;

/// Elements that are displaced by a smaller share of the largest displacement do not count.
constexpr float leastDisplaced = 1e-3f;

}

/// What change() needs to know.
struct StepStart::Change
{
  double squares = 0.0;      ///< the sum of the squares of all changes, in units
  std::size_t displaced = 0; ///< the number of elements that count
  float largest = 0.0f;      ///< the square of the largest displacement, in units of the spacing along x
};

/// `largest`: as in Change, from the call before; 0 for the first one.
StepStart::Change StepStart::measure(float largest)
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
  const auto ofX = [&](int axis) { return static_cast<cl_float>(spacing[axis] / spacing[0]); };
  std::uint64_t low = 0; // the sum of the lower halves of the squares, and that of the upper ones
  std::uint64_t high = 0;
  std::vector<cl_ulong> found(figures * slots.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_ulong) * found.size());
  context.launch(context.kernel("stepstart.cl", this->bricks_.definesOfRows(), "measureStep"), slots.size(), items,
    this->list_.holding(context, slots), this->bricks_.pitch(), this->start_.buffer, this->bricks_.displacement(),
    cl_float4{ { 1.0f, ofX(1), ofX(2), 0.0f } }, leastDisplaced * leastDisplaced * largest,
    largest > 0.0f ? unitsPerSquare / largest : 0.0f, cl::Local(sizeof(cl_ulong) * figures * items), result);
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
  change.squares = 4294967296.0 * static_cast<double>(high) + static_cast<double>(low);
  return change;
}

double StepStart::change()
{
  const float largest = this->measure(0.0f).largest;
  const Change change = this->measure(largest);
  return change.displaced > 0 && largest > 0.0f
           ? std::sqrt(change.squares / unitsPerSquare / static_cast<double>(change.displaced))
           : 0.0;
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
