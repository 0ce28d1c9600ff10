#include "SweepSchedule.h"

#include "VolumetricStrain.h"
#include "sweepaccount.clh"

#include <algorithm>
#include <limits>
#include <utility>

namespace chainmail
{

namespace
{

/// A sweep number before all others: moves in it no longer count.
constexpr int never = std::numeric_limits<int>::min();

}

SweepSchedule::SweepSchedule(Bricks& bricks)
  : bricks_(bricks)
  , activity_(SWEEP_ROW, "the list of active bricks")
  , log_(SWEEP_LOG, "the list of active bricks")
{
}

/// Adds rows for new slots and stores which bricks are updatable.
void SweepSchedule::fit()
{
  int slot = this->activity_.rows();
  this->activity_.resize(this->bricks_.slots());
  for (; slot < this->activity_.rows(); ++slot)
  {
    this->activity_[slot][SWEEP_NOTED] = never;
  }
  this->bricks_.applyExchanges(this->activity_, this->exchangesApplied_);
  for (slot = 1; slot < this->activity_.rows(); ++slot)
  {
    this->activity_[slot][SWEEP_READY] = this->bricks_.isUpdatable(this->bricks_.brick(slot)) ? 1 : 0;
  }
  if (this->bodies_.asleep)
  {
    for (const int brick : this->bodies_.asleep())
    {
      this->activity_[this->bricks_.slot(brick)][SWEEP_READY] = 0;
      for (int d = 0; d < 6; ++d)
      {
        this->activity_[this->bricks_.slot(this->bricks_.neighbour(brick, d))][SWEEP_READY] = 0;
      }
    }
  }
}

void SweepSchedule::begin(Bodies bodies)
{
  this->bodies_ = std::move(bodies);
  this->sweep_ = 0;
  this->resume_ = 0;
  this->waited_ = false;
  this->largest_ = 0.0f;
  this->activity_.clear(0);
  this->fit();
  const std::vector<int> touched = this->bricks_.dirtySlots();
  for (const int slot : touched)
  {
    this->activity_[slot][SWEEP_NOTED] = -1;
  }
  this->makeReady(this->bricks_.slotsAround(touched));
  updatePressureAround(this->bricks_, touched, &this->activity(), -1);
}

void SweepSchedule::beginBatch(int sweeps)
{
  if (!this->bricks_.isUpToDate(this->activity_, this->exchangesApplied_)) // other code may have allocated bricks
  {
    this->activity_.fromDevice(this->bricks_.context());
    this->fit();
    this->activity_.toDevice(this->bricks_.context());
  }
  this->log_.clear(1 + 3 * sweeps);
  this->log_.setReal(0, SWEEP_LARGEST, this->largest_);
  this->log_.toDevice(this->bricks_.context());
  this->passes_.clear();
  this->begun_ = 0;
}

void SweepSchedule::beginSweep(float stopThreshold)
{
  this->before_ = this->first_;
  this->first_ = this->begun_ == 0 && this->waited_ ? 0 : static_cast<int>(this->passes_.size()) + 1;
  this->stopThreshold_ = this->begun_ == 0 ? goesOn : stopThreshold;
  ++this->begun_;
}

bool SweepSchedule::takesPass(int kind)
{
  if (this->begun_ == 1 && kind < this->resume_)
  {
    return false;
  }
  this->passes_.push_back({ this->sweep_ + this->begun_ - 1, kind, this->stopThreshold_ });
  this->stopThreshold_ = goesOn;
  return true;
}

cl_int4 SweepSchedule::numbers() const
{
  const int launch = static_cast<int>(this->passes_.size());
  return { { launch, this->before_, this->passes_.back().sweep, launch == 1 && this->waited_ ? 1 : 0 } };
}

void SweepSchedule::addTo(SharedTable& batch, float omega) const
{
  static_assert(ofBodies == SWEEP_OF_BODIES, "the device knows it by this number");
  const int row = batch.rows();
  batch.resize(row + 1);
  const cl_int4 numbers = this->numbers();
  std::copy(numbers.s, numbers.s + 4, batch[row]);
  batch[row][BATCH_KIND] = this->passes_.back().kind;
  batch.setReal(row, BATCH_STOP_THRESHOLD, this->passes_.back().stopThreshold);
  batch.setReal(row, BATCH_OMEGA, omega);
}

std::vector<float> SweepSchedule::endBatch()
{
  this->log_.fromDevice(this->bricks_.context());
  std::vector<float> done;
  std::size_t n = 0;
  for (; n < this->passes_.size(); ++n)
  {
    if (!done.empty() && done.back() <= this->passes_[n].stopThreshold)
    {
      break;
    }
    const int launch = static_cast<int>(n) + 1;
    this->largest_ = std::max(this->largest_, this->log_.real(launch, SWEEP_LARGEST));
    if (this->log_[launch][SWEEP_CALLED_OFF] != 0)
    {
      break;
    }
    if (n + 1 == this->passes_.size() || this->passes_[n + 1].sweep != this->passes_[n].sweep)
    {
      done.push_back(this->largest_);
      this->largest_ = 0.0f;
    }
  }
  this->sweep_ += static_cast<int>(done.size());
  this->resume_ = 0;
  this->waited_ = false;
  if (n < this->passes_.size())
  {
    this->markDirty();
    std::vector<int> slots;
    for (int slot = 1; slot < this->activity_.rows(); ++slot)
    {
      if (this->activity_[slot][this->passes_[n].kind] & SWEEP_WAITS)
      {
        slots.push_back(slot);
      }
    }
    if (!slots.empty())
    {
      this->resume_ = this->passes_[n].kind;
      this->waited_ = true;
      this->makeReady(slots);
    }
  }
  return done;
}

void SweepSchedule::makeReady(const std::vector<int>& slots)
{
  std::vector<int> bricks;
  std::vector<int> around;
  for (const int slot : slots)
  {
    if (this->activity_[slot][SWEEP_READY] != 0)
    {
      continue;
    }
    const int brick = this->bricks_.brick(slot);
    bricks.push_back(brick);
    around.push_back(brick);
    for (int d = 0; d < 6; ++d)
    {
      around.push_back(this->bricks_.neighbour(brick, d));
    }
  }
  if (!bricks.empty())
  {
    this->bricks_.makeUpdatable(bricks);
    if (this->bodies_.awaken)
    {
      this->bodies_.awaken(around);
    }
    this->fit();
  }
  this->activity_.toDevice(this->bricks_.context());
}

void SweepSchedule::note(const std::vector<int>& bricks)
{
  if (bricks.empty())
  {
    return;
  }
  this->activity_.fromDevice(this->bricks_.context());
  this->fit();
  for (const int brick : bricks)
  {
    this->bricks_.markDirty(this->bricks_.slot(brick));
    this->activity_[this->bricks_.slot(brick)][SWEEP_NOTED] = this->sweep_ - 1;
  }
  if (this->bricks_.ofVolumetricStrain().empty())
  {
    this->activity_.toDevice(this->bricks_.context());
    return;
  }
  // For all dirty slots, because this also resets the carry of elements (`carried` in numbers.cl). If only the moved
  // bricks were reset, results would depend on the size of bricks.
  const std::vector<int> touched = this->bricks_.dirtySlots();
  this->makeReady(this->bricks_.slotsAround(touched));
  updatePressureAround(this->bricks_, touched, &this->activity(), this->sweep_ - 1);
}

void SweepSchedule::markDirty()
{
  this->activity_.fromDevice(this->bricks_.context());
  for (int slot = 1; slot < this->activity_.rows(); ++slot)
  {
    const cl_int* row = this->activity_[slot];
    if (((row[0] | row[1]) & SWEEP_EVER) != 0 || row[SWEEP_NOTED] >= 0)
    {
      this->bricks_.markDirty(slot);
    }
  }
}

}
