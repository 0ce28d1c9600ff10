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
  this->fixedPoint_.start(bricks);
  if (!this->bricks_.turned() || bricks.empty())
  {
    return;
  }
  Context& context = this->bricks_.context();
  this->bricks_.drop(this->shift_);
  this->bricks_.keep(this->shift_);
  std::vector<int> slots;
  for (const int brick : bricks)
  {
    slots.push_back(this->bricks_.slot(brick));
  }
  context.launch(context.kernel("envelope.cl", this->bricks_.definesOfRows(), "beginShifts"), slots.size(),
    this->bricks_.workItems(true), this->list_.holding(context, slots), this->bricks_.pitch(),
    this->bricks_.displacement, this->bricks_.before(), this->shift_.buffer);
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
  this->bricks_.saveBefore(rest);
}

void EnvelopePropagation::heldChanged()
{
  this->fixedPoint_.forget(VISIT_FREE | VISIT_HELD);
}

int EnvelopePropagation::run(int iterations, float enough, const Checkpoint& checkpoint)
{
  const auto touch = [this]
  {
    for (const int slot : this->fixedPoint_.changed())
    {
      this->bricks_.touch(slot);
    }
  };
  try
  {
    const int done = this->fixedPoint_.run(iterations, enough, checkpoint,
      [this](ArgumentList& own)
      {
        own.add(this->bricks_.displacement, this->bricks_.before(), this->bricks_.tissue(), this->bricks_.turned());
        if (this->bricks_.turned())
        {
          own.add(this->shift_.buffer);
        }
      });
    touch();
    return done;
  }
  catch (...)
  {
    touch(); // after running out of memory, say: the tissue that the wave has moved must be known
    throw;
  }
}

}
