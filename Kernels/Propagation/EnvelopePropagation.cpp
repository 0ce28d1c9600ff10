#include "EnvelopePropagation.h"

#include "fixedpointaccount.clh"

#include <algorithm>

namespace chainmail
{

double EnvelopePropagation::Conflict::largest() const
{
  return std::max(*std::max_element(this->tooHigh.begin(), this->tooHigh.end()),
    *std::max_element(this->tooLow.begin(), this->tooLow.end()));
}

EnvelopePropagation::Conflict EnvelopePropagation::conflict() const
{
  Conflict conflict;
  for (int a = 0; a < 3; ++a)
  {
    conflict.tooHigh[a] = this->fixedPoint_.extremes()[2 * a];
    conflict.tooLow[a] = this->fixedPoint_.extremes()[2 * a + 1];
  }
  return conflict;
}

void EnvelopePropagation::start(const std::vector<int>& bricks)
{
  this->poses_ = false;
  this->fixedPoint_.start(bricks);
  if (!this->bricks_.activeRotations() || bricks.empty())
  {
    return;
  }
  Context& context = this->bricks_.context();
  this->bricks_.removeField(this->shift_);
  this->bricks_.addField(this->shift_);
  const std::vector<int> slots = this->bricks_.slotsOf(bricks);
  context.launch(context.kernel("envelope.cl", this->bricks_.definesOfRows(), "beginShifts"), slots.size(),
    this->bricks_.workItems(true), this->list_.holding(context, slots), this->bricks_.pitch(),
    this->bricks_.displacement(), this->bricks_.before().buffer(), this->shift_.buffer);
}

void EnvelopePropagation::startPoses(
  const std::vector<int>& bricks, const Elements& elements, const std::vector<float>& shifts)
{
  constexpr float next = 1e-30f; // negligible but not 0: an element that has only rotated counts as moved
  this->start(bricks);
  this->poses_ = true;
  std::vector<float> values = shifts;
  std::replace(values.begin(), values.end(), 0.0f, next);
  elements.set(this->shift_, values);
}

void EnvelopePropagation::saveRest()
{
  std::vector<char> saved(this->bricks_.states(), 0);
  for (const int slot : this->fixedPoint_.seen())
  {
    saved[slot] = 1;
  }
  std::vector<int> rest;
  for (int slot = 1; slot < this->bricks_.states(); ++slot)
  {
    if (saved[slot] == 0)
    {
      rest.push_back(slot);
    }
  }
  this->bricks_.before().save(rest);
}

void EnvelopePropagation::heldChanged()
{
  this->fixedPoint_.forget(VISIT_FREE | VISIT_HELD);
}

int EnvelopePropagation::run(int iterations, float stopThreshold, const Checkpoint& checkpoint)
{
  const auto touch = [this] { this->bricks_.markDirty(this->fixedPoint_.changed()); };
  try
  {
    const int done = this->fixedPoint_.run(iterations, stopThreshold, checkpoint,
      [this](ArgumentList& own)
      {
        own.add(this->bricks_.before().buffer());
        if (this->bricks_.activeRotations())
        {
          own.add(this->shift_.buffer, static_cast<cl_int>(this->poses_ ? -1 : 0));
        }
      });
    touch();
    return done;
  }
  catch (...)
  {
    touch(); // e.g. after running out of memory: bricks that the wave has changed must be marked as dirty
    throw;
  }
}

}
