#include "Sharing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

/// By how much links count as shorter than they are, as a fraction of the largest displacement. In float32 the bounds,
/// and the wave to them, round by up to 1.8e-7 of it at each link, and the means by 4.8e-7.
constexpr float leastMargin = 7e-7f;

}

Sharing::Sharing(Bricks& bricks)
  : bricks_(bricks)
  , fixedPoint_(bricks, "share.cl", "bound")
{
}

void Sharing::release()
{
  this->bricks_.removeField(this->lower_);
  this->bricks_.removeField(this->upper_);
}

/// Spreads bounds that were set in these bricks along links that count as shorter by `margin`.
void Sharing::spread(
  const std::vector<int>& bricks, float margin, Field& lower, Field& upper, const Checkpoint& checkpoint)
{
  this->fixedPoint_.start(bricks);
  this->fixedPoint_.run(0, std::numeric_limits<float>::infinity(), checkpoint,
    [&](ArgumentList& own) { own.add(lower.buffer, upper.buffer, margin); });
}

/// Resets the bounds of held tissue to 0. Returns the bricks where one was not 0.
std::vector<int> Sharing::holdBounds()
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->fixedPoint_.seen();
  std::vector<cl_int> found(slots.size(), 0);
  const cl::Buffer& foundBuffer = this->found_.holding(context, found);
  context.launch(context.kernel("share.cl", this->bricks_.definesOfRows(this->bricks_.activeRotations()), "holdBounds"),
    slots.size(), this->bricks_.workItems(true), this->list_.holding(context, slots), this->bricks_.pitch(),
    this->bricks_.tissuePitch(), this->bricks_.constraint(), this->lower_.buffer, this->upper_.buffer, foundBuffer);
  context.read(foundBuffer, found);
  return this->bricks_.bricksWhere(slots, found);
}

std::vector<float> Sharing::run(const Elements& elements, const std::vector<int>& bricks,
  const std::vector<float>& wanted, const Checkpoint& checkpoint)
{
  const std::vector<float> before = elements.displacements();
  std::vector<float> shift(wanted.size()), low(wanted.size()), high(wanted.size());
  for (std::size_t m = 0; m < shift.size(); ++m)
  {
    shift[m] = wanted[m] - before[m];
  }
  const auto marginNow = [&]
  {
    float furthest = 0.0f;
    for (std::size_t m = 0; m < shift.size(); ++m)
    {
      furthest = std::max({ furthest, std::fabs(before[m] + shift[m]), std::fabs(shift[m]) });
    }
    return leastMargin * furthest;
  };
  // All bounds start as 0 except at the requests, where lower bounds are raised and upper bounds are lowered.
  const auto begin = [&](const std::array<float, 3>& least, const std::array<float, 3>& most, float shorter)
  {
    this->release();
    this->bricks_.addField(this->lower_);
    this->bricks_.addField(this->upper_);
    for (std::size_t m = 0; m < shift.size(); ++m)
    {
      low[m] = std::max(shift[m] - least[m % 3], 0.0f);
      high[m] = std::min(shift[m] - most[m % 3], 0.0f);
    }
    elements.set(this->lower_, low);
    elements.set(this->upper_, high);
    this->spread(bricks, shorter, this->lower_, this->upper_, checkpoint);
  };

  // Clamp the requests to what held tissue allows. The first spread gives in `lower_` how far the requests raise all
  // tissue, and in `upper_` how far they lower it. Held tissue resets both to 0. From there a second spread with
  // swapped roles takes `lower_` as an upper and `upper_` as a lower bound. It changes nothing elsewhere in spite of
  // rounding, because the first spread used shorter links (twice the margin).
  //
  // Bounds that come from held tissue are at most the length of a path through the grid, however large the requests
  // are. This limits the margin, too.
  const Index3& size = this->bricks_.model().grid().size;
  const float margin = std::min(marginNow(), leastMargin * static_cast<float>(size[0] + size[1] + size[2]));
  begin({}, {}, 2.0f * margin);
  const std::vector<int> beyond = this->holdBounds();
  if (!beyond.empty())
  {
    this->spread(beyond, margin, this->upper_, this->lower_, checkpoint);
    const std::vector<float> most = elements.values(this->lower_);
    const std::vector<float> least = elements.values(this->upper_);
    for (std::size_t m = 0; m < shift.size(); ++m)
    {
      shift[m] = std::min(std::max(shift[m], least[m]), most[m]);
    }
  }

  // L and U of the requests. Bounds below the least request or above the greatest have no effect. So the fields hold
  // max(L - least, 0) and min(U - most, 0).
  std::array<float, 3> least, most;
  for (int a = 0; a < 3; ++a)
  {
    least[a] = most[a] = shift[a];
    for (std::size_t m = a; m < shift.size(); m += 3)
    {
      least[a] = std::min(least[a], shift[m]);
      most[a] = std::max(most[a], shift[m]);
    }
  }
  begin(least, most, marginNow());
  const std::vector<float> lower = elements.values(this->lower_);
  const std::vector<float> upper = elements.values(this->upper_);
  std::vector<float> shared(shift.size());
  for (std::size_t m = 0; m < shared.size(); ++m)
  {
    if (lower[m] != low[m] || upper[m] != high[m])
    {
      shift[m] = 0.5f * ((least[m % 3] + lower[m]) + (most[m % 3] + upper[m]));
    }
    shared[m] = shift[m] == wanted[m] - before[m] ? wanted[m] : before[m] + shift[m];
  }
  this->release();
  return shared;
}

}
