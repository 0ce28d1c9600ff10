#include "Waves.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace chainmail
{

namespace
{

/// Two handles are compatible if they strain a link beyond its limit by less than this, which is the float rounding of
/// displacements of this size.
float rounding(float displacement)
{
  return 2e-6f * std::max(1.0f, std::fabs(displacement));
}

/// After so many attempts a probe that still does not fit stays where it is.
constexpr int mostAttempts = 50;

/// After so many sign changes of its correction a probe has no place between the handles on both sides that limit it,
/// or only one as small as rounding.
constexpr int mostSignChanges = 3;

/// Up to so many incompatible probes are split into halves, unless the policy is to share. More probes share, since
/// they would take a wave each.
constexpr std::size_t mostInHalves = 32;

/// Probes of one wave share at most so often: again only where rounding leaves a conflict.
constexpr int mostShares = 3;

/// The largest rotation of a probe in one wave [rad], since the tissue around it rotates only when it relaxes. And the
/// most attempts to shorten a wave of such probes.
constexpr double longestRotation = 0.131;
constexpr int mostShortenings = 12;
constexpr float farTooFar = 0.25f; // a larger conflict ends such a wave early; as a fraction of Wave::way
}

Waves::Waves(Bricks& bricks, Handles& handles, Handles::SharedBodies sharedBodies)
  : bricks_(bricks)
  , handles_(handles)
  , sharedBodies_(std::move(sharedBodies))
  , propagation_(bricks)
  , arrivals_(bricks)
  , timestamps_(bricks, this->arrivals_)
  , feasibility_(bricks)
  , sharing_(bricks)
{
}

void Waves::configure(PropagationMethod method, ConflictPolicy policy)
{
  this->method_ = method;
  this->policy_ = policy;
}

void Waves::clear()
{
  this->letGo();
  for (const Group& group : this->queue_)
  {
    for (const Handles::Pointer& handle : group)
    {
      handle->waits = false;
    }
  }
  this->queue_.clear();
  this->end();
  this->disturbed_ = false;
  this->latest_.reset();
  this->lastWaveId_ = 0;
  this->timestamps_.clear();
  this->arrivals_.clear();
  this->bricks_.before().release();
  this->propagation_.release();
}

void Waves::letGo()
{
  this->handles_.letGo(this->released_);
  this->released_.clear();
}

void Waves::add(const Handles::Change& change)
{
  for (const Handles::Pointer& handle : change.released)
  {
    handle->waits = false;
  }
  for (Group& group : this->queue_)
  {
    group.erase(
      std::remove_if(group.begin(), group.end(), [](const Handles::Pointer& handle) { return !handle->waits; }),
      group.end());
  }
  this->queue_.erase(std::remove(this->queue_.begin(), this->queue_.end(), Group()), this->queue_.end());
  this->released_.insert(this->released_.end(), change.released.begin(), change.released.end());
  if (!this->underWay())
  {
    this->letGo();
  }
  Group moved;
  std::copy_if(change.moved.begin(), change.moved.end(), std::back_inserter(moved),
    [](const Handles::Pointer& handle) { return !handle->waits; });
  this->enqueue(std::move(moved), false);
}

/// Puts a group at the front or the back of the queue.
void Waves::enqueue(Group handles, bool first)
{
  if (handles.empty())
  {
    return;
  }
  for (const Handles::Pointer& handle : handles)
  {
    handle->waits = true;
  }
  this->queue_.insert(first ? this->queue_.begin() : this->queue_.end(), std::move(handles));
}

PropagateResult Waves::run(int iterations, const Checkpoint& checkpoint)
{
  PropagateResult result;
  if (!this->underWay())
  {
    return result;
  }
  this->numberShared_ = 0;
  result.iterations = this->method_ == PropagationMethod::Envelope ? this->runEnvelopes(iterations, checkpoint)
                                                                   : this->runTimestamps(iterations, checkpoint);
  this->handles_.setHeld([](const Handle&) { return true; });
  result.finished = !this->underWay();
  result.shared = this->numberShared_;
  if (result.finished)
  {
    this->letGo();
    this->bricks_.before().release();
    this->propagation_.release();
  }
  return result;
}

/// During a wave only the handles that it must not move are held: anchors, its own probes and, unless the policy is
/// Latest, all other probes except those whose wave waits. Unless the policy is Latest, waiting probes that prescribe a
/// rotation are held, too, since the wave would move their tissue without rotating it.
void Waves::markHeld()
{
  this->handles_.setHeld(
    [this](const Handle& handle)
    {
      return handle.probe.anchor || handle.moves ||
             (this->policy_ != ConflictPolicy::Latest && (!handle.waits || handle.rotates()));
    });
}

void Waves::place(const Elements& elements, const std::vector<int>& bricks, const std::vector<float>& values)
{
  elements.setDisplacements(values);
  for (const int brick : bricks)
  {
    this->bricks_.markDirty(this->bricks_.slot(brick));
  }
}

// --- Envelopes

int Waves::runEnvelopes(int iterations, const Checkpoint& checkpoint)
{
  if (this->wave_)
  {
    this->markHeld();
    this->propagation_.heldChanged();
  }
  int done = 0;
  while (this->underWay() && (iterations == 0 || done < iterations))
  {
    if (!this->wave_)
    {
      this->beginNext();
      continue;
    }
    done += this->propagation_.run(iterations == 0 ? 0 : iterations - done, this->wave_->stopThreshold, checkpoint);
    const bool stopped = this->propagation_.conflict().largest() > this->wave_->stopThreshold;
    if ((stopped || this->propagation_.finished()) && this->endAttempt(checkpoint))
    {
      if (this->times_)
      {
        this->propagation_.saveRest();
        std::vector<const Handle*> sources;
        for (const Handles::Pointer& handle : this->wave_->handles)
        {
          sources.push_back(handle.get());
        }
        this->arrivals_.computeTimes(sources, ++this->lastWaveId_, checkpoint);
      }
      this->countShared();
      this->end();
    }
  }
  return done;
}

void Waves::beginNext()
{
  Group handles = std::move(this->queue_.front());
  this->queue_.pop_front();
  for (const Handles::Pointer& handle : handles)
  {
    handle->waits = false;
  }
  handles.erase(std::remove_if(handles.begin(), handles.end(),
                  [](const Handles::Pointer& handle) { return handle->probe.anchor || handle->voxels.empty(); }),
    handles.end());
  if (!handles.empty())
  {
    this->begin(std::move(handles));
  }
}

void Waves::begin(Group handles)
{
  this->wave_.emplace(this->bricks_);
  Wave& wave = *this->wave_;
  wave.handles = std::move(handles);
  this->joinBodies();
  for (const Handles::Pointer& handle : wave.handles)
  {
    handle->moves = true;
    wave.elements.add(handle->elements);
    wave.bricks.insert(wave.bricks.end(), handle->bricks.begin(), handle->bricks.end());
  }
  std::sort(wave.bricks.begin(), wave.bricks.end());
  wave.bricks.erase(std::unique(wave.bricks.begin(), wave.bricks.end()), wave.bricks.end());
  this->markHeld();
  this->bricks_.before().save(this->bricks_.slotsOf(wave.bricks));
  wave.before = wave.elements.displacements();
  for (const Handles::Pointer& handle : wave.handles)
  {
    if (handle->rotates())
    {
      wave.rotates = true;
      wave.largestFraction = std::min(wave.largestFraction, 1.0 / wavesFor(*handle));
      wave.rotating.add(handle->elements);
    }
  }
  wave.fraction = wave.largestFraction;
  if (wave.rotates)
  {
    wave.rotationsBefore = wave.rotating.rotations();
  }
  for (int a = 0; a < 3; ++a)
  {
    const Probe& probe = wave.handles.front()->probe;
    wave.to[a] = static_cast<float>(probe.displacement[a] / this->bricks_.model().grid().spacing[a]);
  }
  this->attempt();
}

/// Replaces the probes of the wave that hold the same rigid body by one handle. It moves the body by the rigid motion
/// that is, or comes nearest to, what these probes request (Handles::join). Each probe by itself would only translate
/// the body; none could rotate it.
void Waves::joinBodies()
{
  Wave& wave = *this->wave_;
  if (!this->bricks_.rotations() || this->policy_ == ConflictPolicy::Share || wave.handles.size() < 2 ||
      wave.handles.size() > mostInHalves)
  {
    return;
  }
  const std::vector<Handles::Pointer> all(wave.handles.begin(), wave.handles.end());
  for (const Handles::SharedBody& body : this->sharedBodies_(all))
  {
    Group own;
    for (const std::size_t n : body.handles)
    {
      own.push_back(all[n]);
    }
    const Handles::Pointer joined = this->handles_.join(body.voxels, { own.begin(), own.end() });
    if (!joined)
    {
      continue;
    }
    for (const Handles::Pointer& handle : own)
    {
      handle->moves = true;
      wave.handles.erase(std::find(wave.handles.begin(), wave.handles.end(), handle));
    }
    wave.handles.push_back(joined);
    wave.joined.emplace_back(joined, std::move(own));
  }
}

void Waves::end()
{
  if (this->wave_)
  {
    std::vector<Handles::Pointer> joined;
    for (const auto& [handle, own] : this->wave_->joined)
    {
      joined.push_back(handle);
      for (const Handles::Pointer& one : own)
      {
        one->moves = false;
        one->rotatesBody = true;
        one->isOnItsWay = handle->isOnItsWay;
      }
    }
    this->handles_.part(joined);
    for (const Handles::Pointer& handle : this->wave_->handles)
    {
      handle->moves = false;
    }
    this->wave_.reset();
  }
}

/// The target displacements of the elements of the wave's handles in this attempt.
std::vector<float> Waves::target() const
{
  const Wave& wave = *this->wave_;
  if (!wave.shared.empty())
  {
    return wave.shared;
  }
  std::vector<float> values;
  values.reserve(wave.before.size());
  std::array<float, 3> to = wave.to;
  for (const Handles::Pointer& handle : wave.handles)
  {
    const Vector3& spacing = this->bricks_.model().grid().spacing;
    for (int a = 0; wave.handles.size() > 1 && a < 3; ++a)
    {
      to[a] = static_cast<float>(handle->probe.displacement[a] / spacing[a]);
    }
    const std::vector<float> displaced =
      handle->rotates() ? handle->displacedBy(between(handle->pose, handle->asked(), wave.fraction), spacing)
                        : handle->displacedBy(to);
    values.insert(values.end(), displaced.begin(), displaced.end());
  }
  for (std::size_t m = 0; m < values.size(); ++m)
  {
    values[m] = wave.stays[m % 3] ? wave.before[m] : values[m];
  }
  return values;
}

void Waves::attempt()
{
  Wave& wave = *this->wave_;
  const std::vector<float> values = this->target();
  this->place(wave.elements, wave.bricks, values);
  std::array<float, 3> furthest{};
  for (std::size_t m = 0; m < values.size(); ++m)
  {
    furthest[m % 3] = std::max(furthest[m % 3], std::fabs(values[m]));
  }
  wave.stopThreshold = 0.0f;
  for (int a = 0; a < 3; ++a)
  {
    wave.tolerance[a] = rounding(furthest[a]);
    wave.stopThreshold = std::max(wave.stopThreshold, wave.tolerance[a]);
  }
  if (wave.rotates)
  {
    std::vector<float> rotations;
    for (const Handles::Pointer& handle : wave.handles)
    {
      if (handle->rotates())
      {
        const std::vector<float> more = handle->rotationsIn(between(handle->pose, handle->asked(), wave.fraction));
        rotations.insert(rotations.end(), more.begin(), more.end());
      }
    }
    wave.rotating.setRotations(rotations);
    this->bricks_.setRotated(true);
    wave.way = 0.0f;
    for (std::size_t m = 0; m < values.size(); ++m)
    {
      wave.way = std::max(wave.way, std::fabs(values[m] - wave.before[m]));
    }
    wave.stopThreshold = std::max(wave.stopThreshold, farTooFar * wave.way);
  }
  else if (wave.handles.size() == 1)
  {
    // A wave that is much too long would run through all tissue, so a large conflict ends it early.
    for (int a = 0; a < 3; ++a)
    {
      wave.stopThreshold = std::max(wave.stopThreshold, 0.2f * std::fabs(wave.to[a]));
    }
  }
  ++wave.attempts;
  if (!wave.rotates)
  {
    this->propagation_.start(wave.bricks);
    return;
  }
  std::vector<float> shifts = values;
  for (std::size_t m = 0; m < shifts.size(); ++m)
  {
    shifts[m] -= wave.before[m];
  }
  this->propagation_.startPoses(wave.bricks, wave.elements, shifts);
}

/// Whether the wave is done: everything is compatible, or its probe cannot move. Otherwise another attempt has begun,
/// in which the wave's probes may share, or they wait in the queue as two halves. The probes moved first are in front,
/// so the others are limited by them. A conflict with held tissue is the length by which the probe went too far, or a
/// lower bound of it if the wave has not yet arrived by the shortest path. Where, on an axis, other handles hold the
/// probe's elements too far apart for a common displacement, these elements stay where they are.
bool Waves::endAttempt(const Checkpoint& checkpoint)
{
  Wave& wave = *this->wave_;
  const EnvelopePropagation::Conflict conflict = this->propagation_.conflict();
  bool compatible = true;
  for (int a = 0; a < 3; ++a)
  {
    compatible = compatible && std::max(conflict.tooHigh[a], conflict.tooLow[a]) <= wave.tolerance[a];
  }
  if (compatible)
  {
    if (wave.rotates)
    {
      this->place(wave.elements, wave.bricks, this->target()); // exactly, without the rounding of shifts
    }
    for (const Handles::Pointer& handle : wave.handles)
    {
      if (handle->rotates())
      {
        handle->isOnItsWay = wave.fraction == wave.largestFraction && wave.fraction < 1.0;
        handle->pose = between(handle->pose, handle->asked(), wave.fraction);
      }
    }
    return true;
  }
  this->takeBack();
  if (wave.rotates ? this->shorten(conflict) : this->share(checkpoint))
  {
    return false;
  }
  if (wave.handles.size() > 1)
  {
    Group handles = wave.handles;
    for (const auto& [joined, own] : wave.joined)
    {
      const auto at = std::find(handles.begin(), handles.end(), joined);
      handles.insert(handles.erase(at), own.begin(), own.end());
    }
    const auto half = handles.begin() + static_cast<std::ptrdiff_t>(handles.size() / 2);
    this->end();
    this->enqueue(Group(half, handles.end()), true);
    this->enqueue(Group(handles.begin(), half), true);
    return false;
  }
  if (wave.rotates)
  {
    wave.handles.front()->isOnItsWay = false;
    return true; // it stays where it is
  }
  for (int a = 0; a < 3; ++a)
  {
    const bool tooHigh = conflict.tooHigh[a] > wave.tolerance[a];
    const bool tooLow = conflict.tooLow[a] > wave.tolerance[a];
    const int way = tooHigh ? -1 : tooLow ? 1 : 0;
    wave.signChanges[a] += way * wave.lastWay[a] < 0 ? 1 : 0;
    wave.lastWay[a] = way == 0 ? wave.lastWay[a] : way;
    if ((tooHigh && tooLow) || wave.signChanges[a] == mostSignChanges)
    {
      wave.stays[a] = true;
    }
    else if (way != 0)
    {
      // The conflict of a long wave is less exact, so a large correction is shorter than it by the tolerance.
      const double excess = tooHigh ? conflict.tooHigh[a] : conflict.tooLow[a];
      const bool large = excess > 4.0 * wave.tolerance[a] && excess > 0.1 * std::fabs(wave.to[a]);
      const double step = excess - (large ? wave.tolerance[a] : 0.0);
      wave.to[a] = static_cast<float>(wave.to[a] + (tooHigh ? -step : step));
      wave.to[a] = std::fabs(wave.to[a]) <= wave.tolerance[a] ? 0.0f : wave.to[a];
    }
  }
  if (wave.attempts == mostAttempts)
  {
    return true; // feasible, because nothing moves
  }
  this->attempt();
  return false;
}

int Waves::wavesFor(const Handle& handle)
{
  return handle.rotates()
           ? std::max(1, static_cast<int>(std::ceil(angleBetween(handle.pose, handle.asked()) / longestRotation)))
           : 1;
}

/// Restores the displacements and rotations from before the wave.
void Waves::takeBack()
{
  this->propagation_.takeBack();
  if (this->wave_->rotates)
  {
    this->wave_->rotating.setRotations(this->wave_->rotationsBefore);
  }
}

/// Begins another attempt in which the probes that prescribe rotations go a smaller share of their motions. Returns
/// false after mostShortenings, or where the share would be 0. To first order, the conflict of a wave that ran to its
/// end is the length by which it went too far.
bool Waves::shorten(const EnvelopePropagation::Conflict& conflict)
{
  Wave& wave = *this->wave_;
  if (wave.attempts > mostShortenings)
  {
    return false;
  }
  const double excess = conflict.largest() / wave.way;
  // A little shorter than the conflict says. From the third attempt on at least a tenth shorter, so the attempts end.
  constexpr double margin = 1.02;
  const double most = wave.attempts > 2 ? 0.9 : 1.0;
  const double share = wave.fraction * (excess > farTooFar ? 0.5 : std::min(most, 1.0 - margin * excess));
  // Rounded down to a few values, so that float rounding, which depends on the bricks, makes no difference.
  constexpr double stepsOfLongest = 64.0;
  wave.fraction = std::floor(share / wave.largestFraction * stepsOfLongest) / stepsOfLongest * wave.largestFraction;
  if (wave.fraction <= 0.0)
  {
    return false;
  }
  this->attempt();
  return true;
}

/// Begins another attempt in which the wave's probes share, if they are to share and their targets change. Returns
/// whether it did.
bool Waves::share(const Checkpoint& checkpoint)
{
  Wave& wave = *this->wave_;
  if ((this->policy_ != ConflictPolicy::Share && wave.handles.size() <= mostInHalves) || wave.attempts > mostShares)
  {
    wave.shared.clear();
    return false;
  }
  this->handles_.setHeld([this](const Handle& handle)
    { return !handle.moves && (handle.probe.anchor || (this->policy_ != ConflictPolicy::Latest && !handle.waits)); });
  const std::vector<float> asked = this->target();
  std::vector<float> shared = this->sharing_.run(wave.elements, wave.bricks, asked, checkpoint);
  this->markHeld();
  wave.shared.clear();
  if (shared == asked)
  {
    return false;
  }
  wave.shared = std::move(shared);
  this->attempt();
  return true;
}

/// Counts the probes of a wave that got other displacements than requested because they share.
void Waves::countShared()
{
  Wave& wave = *this->wave_;
  const std::vector<float> got = std::move(wave.shared);
  wave.shared.clear();
  if (got.empty() || wave.handles.size() == 1)
  {
    return;
  }
  const std::vector<float> asked = this->target();
  std::size_t m = 0;
  for (const Handles::Pointer& handle : wave.handles)
  {
    const std::size_t end = m + handle->grabbed.size();
    bool differs = false;
    for (; m < end; ++m)
    {
      differs = differs || std::fabs(got[m] - asked[m]) > wave.tolerance[m % 3];
    }
    this->numberShared_ += differs ? 1 : 0;
  }
}

// --- Timestamps

int Waves::runTimestamps(int iterations, const Checkpoint& checkpoint)
{
  int done = 0;
  while (this->underWay())
  {
    // In the published method waves overlap. That can leave links beyond their limits for good: where the later wave
    // took tissue over before the earlier one had corrected it.
    while (!this->queue_.empty() && (this->timestamps_.finished() || this->policy_ == ConflictPolicy::Latest))
    {
      Group& group = this->queue_.front();
      const Handles::Pointer handle = group.front();
      handle->waits = false;
      group.pop_front();
      if (group.empty())
      {
        this->queue_.pop_front();
      }
      if (!handle->probe.anchor && !handle->voxels.empty())
      {
        this->disturbed_ = this->disturbed_ || !this->timestamps_.finished();
        this->startTimestamps(handle, checkpoint);
      }
    }
    // Unless the policy is Latest, this also holds the probes of the waves under way, which no longer wait. With Latest
    // only anchors are held, so a later wave may move the probe of an earlier one.
    this->markHeld();
    done += this->timestamps_.run(iterations == 0 ? 0 : iterations - done, checkpoint);
    if (iterations != 0 && done >= iterations)
    {
      break;
    }
  }
  if (this->disturbed_ && !this->underWay())
  {
    // The latest probe may have dragged others so far that they are no longer compatible with each other.
    this->projectToFeasible([this](const Handle& handle)
      { return handle.probe.anchor || this->policy_ != ConflictPolicy::Latest || &handle == this->latest_.get(); },
      checkpoint);
  }
  return done;
}

void Waves::projectToFeasible(const Checkpoint& checkpoint)
{
  this->projectToFeasible([](const Handle&) { return true; }, checkpoint);
}

template <typename F> void Waves::projectToFeasible(const F& isHeld, const Checkpoint& checkpoint)
{
  this->handles_.setHeld(isHeld);
  this->feasibility_.run(this->propagation_, checkpoint);
  this->disturbed_ = false;
}

/// An envelope wave determines how far the probe can go. The published wave then starts from there.
void Waves::startTimestamps(const Handles::Pointer& handle, const Checkpoint& checkpoint)
{
  this->begin({ handle });
  do
  {
    this->propagation_.run(0, this->wave_->stopThreshold, checkpoint);
  } while (!this->endAttempt(checkpoint));
  const std::vector<float> values = handle->elements.displacements();
  this->takeBack();
  this->end();
  this->place(handle->elements, handle->bricks, values);
  this->latest_ = handle;
  this->timestamps_.start(*handle, ++this->lastWaveId_);
  // The earliest time gives an element correct bounds only where all elements of the probe have the same displacement.
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
