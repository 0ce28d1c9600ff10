#include "Waves.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// Two holds that strain a link by less than this are compatible: float rounding of displacements of this size.
float rounding(float displacement)
{
  return 2e-6f * std::max(1.0f, std::fabs(displacement));
}

/// A probe that still does not fit after so many attempts stays where it is.
constexpr int mostAttempts = 50;

bool contains(const std::vector<Holds::Pointer>& holds, const Holds::Pointer& hold)
{
  return std::find(holds.begin(), holds.end(), hold) != holds.end();
}

}

Waves::Waves(Bricks& bricks, Holds& holds)
  : bricks_(bricks)
  , holds_(holds)
  , propagation_(bricks)
  , arrivals_(bricks)
  , timestamps_(bricks, this->arrivals_)
  , repair_(bricks)
{
}

void Waves::configure(PropagationMethod method, ConflictPolicy policy)
{
  this->method_ = method;
  this->policy_ = policy;
}

void Waves::clear()
{
  this->holds_.letGo(this->released_);
  this->released_.clear();
  this->queue_.clear();
  this->inTurn_ = 0;
  this->wave_.reset();
  this->disturbed_ = false;
  this->latest_.reset();
  this->front_ = 0;
  this->timestamps_.clear();
  this->arrivals_.clear();
}

void Waves::add(const Holds::Change& change)
{
  for (const Holds::Pointer& hold : change.released)
  {
    const auto queued = std::find(this->queue_.begin(), this->queue_.end(), hold);
    if (queued != this->queue_.end())
    {
      this->inTurn_ -= static_cast<std::size_t>(queued - this->queue_.begin()) < this->inTurn_ ? 1 : 0;
      this->queue_.erase(queued);
    }
  }
  this->released_.insert(this->released_.end(), change.released.begin(), change.released.end());
  if (!this->underWay())
  {
    this->holds_.letGo(this->released_);
    this->released_.clear();
  }
  for (const Holds::Pointer& hold : change.moved)
  {
    if (std::find(this->queue_.begin(), this->queue_.end(), hold) == this->queue_.end())
    {
      this->queue_.push_back(hold);
    }
  }
}

PropagateResult Waves::run(int iterations, const Checkpoint& checkpoint)
{
  PropagateResult result;
  if (!this->underWay())
  {
    return result;
  }
  result.iterations = this->method_ == PropagationMethod::Envelope ? this->runEnvelopes(iterations, checkpoint)
                                                                   : this->runTimestamps(iterations, checkpoint);
  for (const Holds::Pointer& hold : this->holds_.all())
  {
    this->holds_.setHeld(*hold, true);
  }
  result.finished = !this->underWay();
  if (result.finished)
  {
    this->holds_.letGo(this->released_);
    this->released_.clear();
  }
  return result;
}

/// While a wave travels, only what it must not move is held: anchors, its own probes and, unless the latest prevails,
/// all probes but those that wait for their turn.
void Waves::markHeld(const std::vector<Holds::Pointer>& movers)
{
  for (const Holds::Pointer& hold : this->holds_.all())
  {
    const bool waits = std::find(this->queue_.begin(), this->queue_.end(), hold) != this->queue_.end();
    this->holds_.setHeld(
      *hold, hold->probe.anchor || contains(movers, hold) || (this->policy_ == ConflictPolicy::Limit && !waits));
  }
}

void Waves::place(const Hold& hold, const std::vector<float>& values)
{
  this->bricks_.setDisplacements(hold.addresses, values);
  for (const int brick : hold.bricks)
  {
    this->bricks_.touch(this->bricks_.slot(brick));
  }
}

// --- Envelopes -------------------------------------------------------------------------------------------------------

int Waves::runEnvelopes(int iterations, const Checkpoint& checkpoint)
{
  if (this->wave_)
  {
    this->markHeld(this->wave_->holds);
  }
  int done = 0;
  while (this->underWay() && (iterations == 0 || done < iterations))
  {
    if (!this->wave_)
    {
      this->beginNext();
      continue;
    }
    done += this->propagation_.run(iterations == 0 ? 0 : iterations - done, this->wave_->enough, checkpoint);
    const bool stopped = this->propagation_.conflict().largest() > this->wave_->enough;
    if ((stopped || this->propagation_.finished()) && this->settled())
    {
      if (this->times_)
      {
        std::vector<const Hold*> sources;
        for (const Holds::Pointer& hold : this->wave_->holds)
        {
          sources.push_back(hold.get());
        }
        this->arrivals_.follow(sources, ++this->front_, checkpoint);
      }
      this->wave_.reset();
    }
  }
  return done;
}

/// All that wait together, else one by one.
void Waves::beginNext()
{
  const std::size_t count = this->inTurn_ > 0 ? 1 : this->queue_.size();
  this->inTurn_ -= this->inTurn_ > 0 ? 1 : 0;
  std::vector<Holds::Pointer> holds;
  for (std::size_t n = 0; n < count; ++n)
  {
    if (!this->queue_.front()->probe.anchor && !this->queue_.front()->addresses.empty())
    {
      holds.push_back(this->queue_.front());
    }
    this->queue_.pop_front();
  }
  if (!holds.empty())
  {
    this->begin(std::move(holds));
  }
}

void Waves::begin(std::vector<Holds::Pointer> holds)
{
  this->wave_.emplace();
  Wave& wave = *this->wave_;
  wave.holds = std::move(holds);
  this->markHeld(wave.holds);
  this->bricks_.saveBefore();
  for (const Holds::Pointer& hold : wave.holds)
  {
    wave.before.push_back(this->bricks_.displacements(hold->addresses));
  }
  for (int a = 0; a < 3; ++a)
  {
    const Probe& probe = wave.holds.front()->probe;
    wave.to[a] = static_cast<float>(probe.displacement[a] / this->bricks_.model().grid().spacing[a]);
  }
  this->attempt();
}

/// Where the elements of a wave's hold are to go.
std::vector<float> Waves::target(std::size_t n) const
{
  const Hold& hold = *this->wave_->holds[n];
  std::array<float, 3> to = this->wave_->to;
  for (int a = 0; n > 0 && a < 3; ++a)
  {
    to[a] = static_cast<float>(hold.probe.displacement[a] / this->bricks_.model().grid().spacing[a]);
  }
  std::vector<float> values = hold.displacedBy(to);
  for (std::size_t m = 0; m < values.size(); ++m)
  {
    values[m] = this->wave_->stays[m % 3] ? this->wave_->before[n][m] : values[m];
  }
  return values;
}

void Waves::attempt()
{
  Wave& wave = *this->wave_;
  std::vector<int> bricks;
  std::array<float, 3> furthest{};
  for (std::size_t n = 0; n < wave.holds.size(); ++n)
  {
    const std::vector<float> values = this->target(n);
    this->place(*wave.holds[n], values);
    for (std::size_t m = 0; m < values.size(); ++m)
    {
      furthest[m % 3] = std::max(furthest[m % 3], std::fabs(values[m]));
    }
    bricks.insert(bricks.end(), wave.holds[n]->bricks.begin(), wave.holds[n]->bricks.end());
  }
  wave.enough = 0.0f;
  for (int a = 0; a < 3; ++a)
  {
    wave.tolerance[a] = rounding(furthest[a]);
    wave.enough = std::max(wave.enough, wave.tolerance[a]);
  }
  if (wave.holds.size() == 1)
  {
    // A wave that is much too long would run through all tissue: it ends where it meets a large conflict.
    for (int a = 0; a < 3; ++a)
    {
      wave.enough = std::max(wave.enough, 0.2f * std::fabs(wave.to[a]));
    }
  }
  ++wave.attempts;
  this->propagation_.start(bricks);
}

/// Whether the wave is done: everything is compatible, or its probe cannot move. Else another attempt has begun, or its
/// probes wait for their turns. Where a wave met held tissue, the conflict is by how much its probe went too far, or
/// less if it has not yet come the shortest way. On an axis on which others hold the probe's elements too far apart to
/// be in one place, they stay where they are.
bool Waves::settled()
{
  Wave& wave = *this->wave_;
  const Propagation::Conflict conflict = this->propagation_.conflict();
  bool compatible = true;
  for (int a = 0; a < 3; ++a)
  {
    compatible = compatible && std::max(conflict.tooHigh[a], conflict.tooLow[a]) <= wave.tolerance[a];
  }
  if (compatible)
  {
    return true;
  }
  this->bricks_.restoreBefore();
  if (wave.holds.size() > 1)
  {
    this->queue_.insert(this->queue_.begin(), wave.holds.begin(), wave.holds.end());
    this->inTurn_ = wave.holds.size();
    this->wave_.reset();
    return false;
  }
  for (int a = 0; a < 3; ++a)
  {
    const bool tooHigh = conflict.tooHigh[a] > wave.tolerance[a];
    const bool tooLow = conflict.tooLow[a] > wave.tolerance[a];
    if (tooHigh && tooLow)
    {
      wave.stays[a] = true;
      continue;
    }
    const int way = tooHigh ? -1 : tooLow ? 1 : 0;
    const bool little = (tooHigh ? conflict.tooHigh[a] : conflict.tooLow[a]) <= 4.0 * wave.tolerance[a];
    if (little && way * wave.lastWay[a] < 0)
    {
      // To and fro: all that is left between those that hold against the probe is rounding.
      wave.stays[a] = true;
    }
    else if (way != 0)
    {
      // The conflict of a long wave is known less exactly, so a large step stops short of it.
      const double excess = tooHigh ? conflict.tooHigh[a] : conflict.tooLow[a];
      const double step = excess - (!little && excess > 0.1 * std::fabs(wave.to[a]) ? wave.tolerance[a] : 0.0);
      wave.to[a] = static_cast<float>(wave.to[a] + (tooHigh ? -step : step));
      wave.to[a] = std::fabs(wave.to[a]) <= wave.tolerance[a] ? 0.0f : wave.to[a];
      wave.lastWay[a] = little ? way : 0;
    }
  }
  if (wave.attempts == mostAttempts)
  {
    return true; // feasible because nothing moves
  }
  this->attempt();
  return false;
}

// --- Timestamps ------------------------------------------------------------------------------------------------------

int Waves::runTimestamps(int iterations, const Checkpoint& checkpoint)
{
  int done = 0;
  while (this->underWay())
  {
    // The published method lets waves overlap. That can leave links beyond their limits for good: the later wave took
    // the tissue over before the earlier one had repaired it.
    while (!this->queue_.empty() && (this->timestamps_.finished() || this->policy_ == ConflictPolicy::Latest))
    {
      const Holds::Pointer hold = this->queue_.front();
      this->queue_.pop_front();
      if (!hold->probe.anchor && !hold->addresses.empty())
      {
        this->disturbed_ = this->disturbed_ || !this->timestamps_.finished();
        this->startTimestamps(hold, checkpoint);
      }
    }
    // A source needs no mark: no other wave moves it, unless the latest prevails.
    this->markHeld({});
    done += this->timestamps_.run(iterations == 0 ? 0 : iterations - done, checkpoint);
    if (iterations != 0 && done >= iterations)
    {
      break;
    }
  }
  if (this->disturbed_ && !this->underWay())
  {
    // The latest probe may have taken others along so far that they are not compatible with each other any more.
    const bool all = this->policy_ == ConflictPolicy::Limit;
    this->repair(all ? this->holds_.all() : std::vector<Holds::Pointer>{ this->latest_ }, checkpoint);
  }
  return done;
}

void Waves::repair(const std::vector<Holds::Pointer>& held, const Checkpoint& checkpoint)
{
  this->markHeld(held);
  this->repair_.run(this->propagation_, checkpoint);
  this->disturbed_ = false;
}

/// Finds out by an envelope wave how far the probe can go, and starts there.
void Waves::startTimestamps(const Holds::Pointer& hold, const Checkpoint& checkpoint)
{
  this->begin({ hold });
  do
  {
    this->propagation_.run(0, this->wave_->enough, checkpoint);
  } while (!this->settled());
  const std::vector<float> values = this->bricks_.displacements(hold->addresses);
  this->bricks_.restoreBefore();
  this->wave_.reset();
  this->place(*hold, values);
  this->latest_ = hold;
  this->timestamps_.start(*hold, ++this->front_);
  // The earliest arrival binds only where all elements of the probe are displaced alike.
  for (std::size_t n = 3; n < values.size(); ++n)
  {
    this->disturbed_ = this->disturbed_ || values[n] != values[n % 3];
  }
}

const WavesUnderWay* Waves::relaxable()
{
  return this->method_ == PropagationMethod::Timestamp ? &this->timestamps_.underWay() : nullptr;
}

}
