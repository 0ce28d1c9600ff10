#include "FixedPoint.h"

#include "Error.h"
#include "Pass.h"
#include "fixedpointaccount.clh"

#include <algorithm>
#include <limits>

namespace chainmail
{

namespace
{

/// Iterations in the first batch of launches, and the most in a later one. The first batch takes less time than waiting
/// for its results, even where one iteration would suffice. A batch is shorter after one that reached a brick that was
/// not updatable.
constexpr int fewestPerBatch = 4;
constexpr int mostPerBatch = 16;

/// A brick is postponed while the excess of its changes is below this share of the largest (fixedpoint.clh). The bounds
/// of pulls at random in a CT of the chest (Feasibility) took 0.87 times as long with 0.2 as with 0, and 0.77 times as
/// long with 0.4.
constexpr float leastShare = 0.4f;

/// The number of iterations in which bricks are postponed, which is far more than scans need. Only without postponed
/// bricks there is a proven limit to the number of iterations, see FixedPoint::run().
constexpr std::size_t mostPostponing = 500;

}

FixedPoint::FixedPoint(Bricks& bricks, const char* file, const char* kernel, int extremes)
  : bricks_(bricks)
  , file_(file)
  , name_(kernel)
  , visits_(VISIT_ROW, "the list of active bricks")
  , log_(LOG_ROW + extremes, "the list of active bricks")
  , extremes_(extremes, 0.0f)
{
}

int FixedPoint::parityOf(int brick) const
{
  const Index3 size = this->bricks_.size();
  const Index3 origin = this->bricks_.origin(brick);
  return (origin[0] / size[0] + origin[1] / size[1] + origin[2] / size[2]) & 1;
}

/// Makes rows for all slots, flags the updatable bricks, and copies the table to the device.
void FixedPoint::fit()
{
  this->visits_.resize(this->bricks_.slots());
  this->bricks_.applyExchanges(this->visits_, this->exchangesApplied_);
  for (int slot = 1; slot < this->visits_.rows(); ++slot)
  {
    this->visits_[slot][VISIT_STATE] |= this->bricks_.isUpdatable(this->bricks_.brick(slot)) ? VISIT_READY : 0;
  }
  this->visits_.toDevice(this->bricks_.context());
}

void FixedPoint::start(const std::vector<int>& bricks)
{
  constexpr float notMeasured = std::numeric_limits<float>::infinity();
  this->bricks_.makeUpdatable(bricks);
  this->visits_.clear(this->bricks_.slots());
  this->bricks_.applyExchanges(this->visits_, this->exchangesApplied_);
  for (const int brick : bricks)
  {
    this->visits_[this->bricks_.slot(brick)][VISIT_DUE] = VISIT_ANY;
    this->visits_[this->bricks_.slot(brick)][VISIT_STATE] = VISIT_SEEN;
    this->visits_.setReal(this->bricks_.slot(brick), VISIT_EXCESS, notMeasured);
    // Elements that changed in this brick may have neighbours in the bricks beyond its faces.
    for (int d = 0; d < 6; ++d)
    {
      const int slot = this->bricks_.slot(this->bricks_.neighbour(brick, d));
      this->visits_[slot][VISIT_DUE] |= 1 << Bricks::opposite(d);
      this->visits_.setReal(slot, VISIT_EXCESS, notMeasured);
    }
  }
  this->visits_[0][VISIT_DUE] = 0;
  this->finished_ = true;
  for (int slot = 1; slot < this->visits_.rows(); ++slot)
  {
    this->finished_ = this->finished_ && this->visits_[slot][VISIT_DUE] == 0;
  }
  this->fit();
  this->goesOn_[0] = this->goesOn_[1] = false;
  this->parity_ = 0;
  this->waited_ = false;
  this->postponed_[0] = this->postponed_[1] = 0.0f;
  this->passed_ = 0.0f;
  this->iterations_ = 0;
  std::fill(this->extremes_.begin(), this->extremes_.end(), 0.0f);
  this->ofPass_.assign(this->extremes_.size(), 0.0f);
}

bool FixedPoint::isBeyond(float stopThreshold) const
{
  return std::any_of(
    this->extremes_.begin(), this->extremes_.end(), [&](float value) { return value > stopThreshold; });
}

void FixedPoint::launch(
  const std::vector<ParityPass>& passes, float stopThreshold, const Checkpoint& checkpoint, const OwnArguments& own)
{
  Context& context = this->bricks_.context();
  this->log_.clear(1 + static_cast<int>(passes.size()));
  this->log_.setReal(0, LOG_POSTPONED, std::max(this->postponed_[0], this->postponed_[1]));
  this->log_.setReal(0, LOG_PASSED, this->passed_);
  for (std::size_t m = 0; m < this->ofPass_.size(); ++m)
  {
    this->log_.setReal(0, LOG_ROW + static_cast<int>(m), this->ofPass_[m]);
  }
  this->log_.toDevice(context);
  const Index3 size = this->bricks_.size();
  const float share = this->iterations_ < mostPostponing ? leastShare : 0.0f;
  const Kernel kernel =
    context.kernel(this->file_, this->bricks_.definesOfRows(this->bricks_.activeRotations()), this->name_);
  for (std::size_t n = 0; n < passes.size(); ++n)
  {
    if (passes[n].parity == 0 || n == 0)
    {
      checkpoint();
    }
    const cl_int4 numbers{ { static_cast<cl_int>(n) + 1, passes[n].parity, passes[n].waited ? 1 : 0,
      size[0] + size[1] + size[2] } };
    launchPass(this->bricks_, kernel, static_cast<std::size_t>(this->visits_.rows()) - 1, this->bricks_.workItems(true),
      this->visits_.buffer(), this->log_.buffer(), numbers, stopThreshold, share,
      this->bricks_.state(this->bricks_.activeRotations()), own);
  }
  this->log_.fromDevice(context);
}

int FixedPoint::run(int iterations, float stopThreshold, const Checkpoint& checkpoint, const OwnArguments& own)
{
  Context& context = this->bricks_.context();
  int done = 0;
  int batch = fewestPerBatch;
  while (!this->finished_ && !this->isBeyond(stopThreshold) && (iterations == 0 || done < iterations))
  {
    if (!this->bricks_.isUpToDate(this->visits_, this->exchangesApplied_)) // other code may have allocated bricks
    {
      this->visits_.fromDevice(context);
      this->fit();
    }
    std::vector<ParityPass> passes;
    for (int n = 0; n < (iterations == 0 ? batch : std::min(batch, iterations - done)); ++n)
    {
      for (int parity = n == 0 ? this->parity_ : 0; parity < 2; ++parity)
      {
        passes.push_back({ parity, passes.empty() && this->waited_ });
      }
    }
    this->launch(passes, stopThreshold, checkpoint, own);

    batch = std::min(2 * batch, mostPerBatch);
    this->parity_ = 0;
    this->waited_ = false;
    for (std::size_t n = 0; n < passes.size() && !this->finished_; ++n)
    {
      const int parity = passes[n].parity;
      const int row = static_cast<int>(n) + 1;
      const int flags = this->log_[row][LOG_FLAGS];
      this->postponed_[parity] = this->log_.real(row, LOG_POSTPONED);
      this->passed_ = this->log_.real(row, LOG_PASSED);
      for (std::size_t m = 0; m < this->extremes_.size(); ++m)
      {
        this->ofPass_[m] = std::max(this->ofPass_[m], this->log_.real(row, LOG_ROW + static_cast<int>(m)));
      }
      if (!passes[n].waited)
      {
        this->goesOn_[parity] = false;
      }
      this->goesOn_[parity] = this->goesOn_[parity] || (flags & LOG_GOES_AGAIN) != 0;
      // A brick of parity 1 that changes its neighbours, of parity 0, leaves work for the next iteration.
      this->goesOn_[0] = this->goesOn_[0] || (parity == 1 && (flags & LOG_PASSED_ON) != 0);
      if (flags & LOG_CALLED_OFF)
      {
        this->parity_ = parity;
        this->waited_ = true;
        batch = 1;
        std::vector<int> bricks;
        this->visits_.fromDevice(context);
        for (int slot = 1; slot < this->visits_.rows(); ++slot)
        {
          const int brick = this->bricks_.brick(slot);
          if ((this->visits_[slot][VISIT_DUE] & (VISIT_AGAIN - 1)) != 0 &&
              (this->visits_[slot][VISIT_STATE] & VISIT_READY) == 0 && this->parityOf(brick) == parity)
          {
            bricks.push_back(brick);
          }
        }
        this->bricks_.makeUpdatable(bricks);
        this->fit();
        break;
      }
      for (std::size_t m = 0; m < this->extremes_.size(); ++m)
      {
        this->extremes_[m] = std::max(this->extremes_[m], this->ofPass_[m]);
        this->ofPass_[m] = 0.0f;
      }
      const bool beyond = this->isBeyond(stopThreshold);
      if (parity == 1 || beyond)
      {
        ++done;
        ++this->iterations_;
      }
      this->finished_ = parity == 1 && !this->goesOn_[0] && !this->goesOn_[1];
      // A caller that limits the iterations expects that there may be no fixed point, with rotations.
      if (iterations == 0 && !this->finished_ &&
          this->iterations_ > mostPostponing + this->bricks_.model().grid().voxels())
      {
        throw Error(std::string("An error of the engine: ") + this->name_ + " of " + this->file_ +
                    " does not end. Reset the tissue, and please report this error.");
      }
      if (beyond)
      {
        break;
      }
    }
  }
  return done;
}

void FixedPoint::forget(int flags)
{
  this->visits_.fromDevice(this->bricks_.context());
  for (int slot = 0; slot < this->visits_.rows(); ++slot)
  {
    this->visits_[slot][VISIT_STATE] &= ~flags;
  }
  this->visits_.toDevice(this->bricks_.context());
}

std::vector<int> FixedPoint::slotsWith(int flags)
{
  this->visits_.fromDevice(this->bricks_.context());
  std::vector<int> slots;
  for (int slot = 1; slot < this->visits_.rows(); ++slot)
  {
    if (this->visits_[slot][VISIT_STATE] & flags)
    {
      slots.push_back(slot);
    }
  }
  return slots;
}

std::vector<int> FixedPoint::seen()
{
  return this->slotsWith(VISIT_SEEN);
}

std::vector<int> FixedPoint::changed()
{
  return this->slotsWith(VISIT_CHANGED);
}

}
