#include "Handles.h"

#include "ElementRule.h"
#include "Error.h"
#include "ProbeSelection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
#include <unordered_set>

namespace chainmail
{

namespace
{

// [voxels] Displacements much larger than this could become infinite in float32, and their waves would never end.
constexpr double farthest = 1e9;

// [full rotates] A wave rotates by some degrees at most, so this bounds the number of waves of an update.
constexpr double mostTurns = 100.0;
constexpr double pi = 3.14159265358979323846;

bool isFinite(const Vector3& v)
{
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

double length(const Vector3& v)
{
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// Whether a probe requests another displacement or rotation than before.
bool isMoved(const Probe& before, const Probe& now)
{
  return before.displacement != now.displacement ||
         (now.rotates && (before.rotation != now.rotation || before.centre != now.centre));
}

}

void Handles::check(const Probe& probe, std::size_t number) const
{
  const auto refuse = [&](const char* problem) { throw ProbeError(number, nameOf(probe, number), problem); };
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  if (!isFinite(probe.position))
  {
    refuse("has a position that is not finite.");
  }
  if (!(probe.radius >= 0.0) || !std::isfinite(probe.radius))
  {
    refuse("has a radius that is negative or not finite.");
  }
  if (!(probe.tolerance >= 0.0) || !std::isfinite(probe.tolerance))
  {
    refuse("has a tolerance that is negative or not finite. Set 0 for a probe that is not soft.");
  }
  if (probe.anchor)
  {
    return;
  }
  if (!isFinite(probe.displacement))
  {
    refuse("has a displacement that is not finite.");
  }
  for (int a = 0; a < 3; ++a)
  {
    if (!(std::fabs(probe.displacement[a] / spacing[a]) < farthest))
    {
      refuse("has a displacement of a billion voxels or more. Move its target nearer.");
    }
  }
  if (!probe.rotates)
  {
    return;
  }
  if (!this->bricks_.rotations())
  {
    refuse("prescribes a rotation, which needs Rotations. Switch Rotations on.");
  }
  if (this->bricks_.model().axes() != 1)
  {
    refuse(
      "prescribes a rotation, but its tissue has a constraint for each axis. Use a ConstraintArray of 1 component.");
  }
  if (!isFinite(probe.rotation) || !isFinite(probe.centre))
  {
    refuse("has a rotation or a centre that is not finite.");
  }
  if (!(length(probe.rotation) <= mostTurns * 2.0 * pi))
  {
    refuse("has a rotation of more than 100 full turns. Subtract full turns.");
  }
  for (int a = 0; a < 3; ++a)
  {
    if (!(std::fabs(probe.centre[a] / spacing[a]) < farthest))
    {
      refuse("has a centre that is a billion voxels away or more. Move the centre nearer.");
    }
  }
}

std::vector<float> Handle::displacedBy(const std::array<float, 3>& to) const
{
  std::vector<float> values = this->grabbed;
  for (std::size_t n = 0; n < values.size(); ++n)
  {
    values[n] += to[n % 3];
  }
  return values;
}

std::vector<float> Handle::displacedBy(const Pose& to, const Vector3& spacing) const
{
  const Quaternion rotation = rotationBy(to.rotation);
  std::vector<float> values(this->grabbed.size());
  for (std::size_t n = 0; n < values.size(); n += 3)
  {
    const double* place = &this->placesGrabbed[n];
    const Vector3 arm{ place[0] - this->probe.centre[0], place[1] - this->probe.centre[1],
      place[2] - this->probe.centre[2] };
    const Vector3 after = rotated(rotation, arm);
    for (std::size_t a = 0; a < 3; ++a)
    {
      values[n + a] = static_cast<float>(this->grabbed[n + a] + (after[a] - arm[a] + to.shift[a]) / spacing[a]);
    }
  }
  return values;
}

std::vector<float> Handle::rotationsIn(const Pose& to) const
{
  const Quaternion rotation = rotationBy(to.rotation);
  std::vector<float> values(this->rotationsGrabbed.size());
  for (std::size_t n = 0; n < values.size(); n += 3)
  {
    const float* before = &this->rotationsGrabbed[n];
    const Vector3 spin = spinOf(product(rotation, rotationOfSpin({ before[0], before[1], before[2] })));
    std::transform(spin.begin(), spin.end(), values.begin() + static_cast<std::ptrdiff_t>(n),
      [](double part) { return static_cast<float>(part); });
  }
  return values;
}

/// Sets all other members of handles whose probe and voxels are set. `places`: for each handle an element in or near it
/// (Handle::place).
void Handles::fill(const std::vector<Pointer>& handles, const std::vector<std::size_t>& places)
{
  const Grid& grid = this->bricks_.model().grid();
  const std::size_t axes = static_cast<std::size_t>(this->bricks_.model().axes());
  const auto brickOf = [&](std::size_t voxel)
  {
    const Index3 at = grid.indexOf(voxel);
    return this->bricks_.brickAt(at[0], at[1], at[2]);
  };
  std::vector<int> needed;
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    std::vector<int>& bricks = handles[n]->bricks;
    for (const std::size_t voxel : handles[n]->voxels)
    {
      bricks.push_back(brickOf(voxel));
    }
    std::sort(bricks.begin(), bricks.end());
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    needed.insert(needed.end(), bricks.begin(), bricks.end());
    needed.push_back(brickOf(places[n]));
  }
  std::sort(needed.begin(), needed.end());
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  this->bricks_.makeUpdatable(needed);

  Elements all(this->bricks_);
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    Handle& handle = *handles[n];
    handle.constraints.resize(axes * handle.voxels.size());
    for (std::size_t m = 0; m < handle.voxels.size(); ++m)
    {
      const Index3 at = grid.indexOf(handle.voxels[m]);
      handle.elements.add(at);
      this->bricks_.row(at[0], at[1], at[2], 1, handle.constraints.data() + axes * m);
    }
    handle.place = places[n];
    all.add(handle.elements);
    all.add(handle.place);
  }
  const std::vector<float> displacements = all.displacements();
  auto from = displacements.begin();
  for (const Pointer& handle : handles)
  {
    const auto end = from + 3 * handle->elements.size();
    handle->grabbed.assign(from, end);
    std::copy_n(end, 3, handle->placeGrabbed.begin());
    from = end + 3;
    if (handle->probe.rotates)
    {
      handle->rotationsGrabbed = handle->elements.rotations();
      for (std::size_t n = 0; n < handle->voxels.size(); ++n)
      {
        const Index3 at = grid.indexOf(handle->voxels[n]);
        for (std::size_t a = 0; a < 3; ++a)
        {
          handle->placesGrabbed.push_back(
            this->origin_[a] + (at[a] + static_cast<double>(handle->grabbed[3 * n + a])) * grid.spacing[a]);
        }
      }
    }
  }
}

/// Marks the elements of these handles on the device as held or not held.
void Handles::mark(const std::vector<Pointer>& handles)
{
  Elements elements(this->bricks_);
  std::vector<float> constraints;
  for (const Pointer& handle : handles)
  {
    if (handle->isSoft())
    {
      continue; // it holds no elements, but others may hold those it has
    }
    elements.add(handle->elements);
    for (const float c : handle->constraints)
    {
      constraints.push_back(rule::asHeld(c, handle->held));
    }
  }
  elements.setConstraints(constraints);
}

bool Handles::isAnchored(std::size_t voxel) const
{
  const Index3 at = this->bricks_.model().grid().indexOf(voxel);
  float c[3];
  this->bricks_.row(at[0], at[1], at[2], 1, c);
  return std::signbit(c[0]);
}

/// Makes the handles of new probes. `taken`: the voxels that other handles hold; those of the new ones are added. An
/// element has one holder: the handle that already has it, else an anchor, else the first probe that grabs it. Other
/// probes that grab it get only the rest of their elements. They are compatible with its holder only if the links in
/// between allow it. Soft probes hold nothing and get all elements that they grab.
std::vector<Handles::Pointer> Handles::make(
  const std::vector<Probe>& probes, const std::vector<Grabbed>& grabbed, std::unordered_set<std::size_t>& taken)
{
  std::vector<Pointer> made(probes.size());
  std::vector<std::size_t> places(probes.size());
  for (const bool anchors : { true, false })
  {
    for (std::size_t m = 0; m < made.size(); ++m)
    {
      if (probes[m].anchor != anchors)
      {
        continue;
      }
      const bool soft = probes[m].isSoft();
      made[m] = std::make_shared<Handle>(this->bricks_);
      made[m]->probe = probes[m];
      made[m]->share = grabbed[m].share;
      for (const std::size_t voxel : grabbed[m].elements)
      {
        if (soft || (!this->isAnchored(voxel) && taken.insert(voxel).second))
        {
          made[m]->voxels.push_back(voxel);
        }
      }
      places[m] = made[m]->voxels.empty() ? grabbed[m].elements.front() : made[m]->voxels.front();
      made[m]->held = !soft;
    }
  }
  this->fill(made, places);
  this->mark(made);
  return made;
}

namespace
{

/// A copy of a handle without some of its elements. `isGone(n)`: whether its n-th element is left out.
template <typename F> Handle without(const Handle& handle, Bricks& bricks, const F& isGone)
{
  std::vector<std::size_t> stay;
  for (std::size_t n = 0; n < handle.voxels.size(); ++n)
  {
    if (!isGone(n))
    {
      stay.push_back(n);
    }
  }
  const auto keep = [&stay](auto& values, std::size_t each)
  {
    std::size_t to = 0;
    for (const std::size_t n : stay)
    {
      for (std::size_t a = 0; !values.empty() && a < each; ++a)
      {
        values[to++] = values[each * n + a];
      }
    }
    values.resize(to);
  };
  Handle kept = handle;
  keep(kept.voxels, 1);
  kept.elements = Elements(bricks, kept.voxels);
  keep(kept.constraints, static_cast<std::size_t>(bricks.model().axes()));
  keep(kept.grabbed, 3);
  keep(kept.placesGrabbed, 3);
  keep(kept.rotationsGrabbed, 3);
  return kept;
}

}

/// The handle of a probe that has become soft, or has ceased to be soft. It is a new handle, because a wave may still
/// need the old one. It has the same tissue, and its displacement is counted from the same place.
Handles::Pointer Handles::changed(const Probe& probe, const Handle& before, std::unordered_set<std::size_t>& taken)
{
  const auto after = std::make_shared<Handle>(without(before, this->bricks_,
    [&](std::size_t n)
    { return !probe.isSoft() && (this->isAnchored(before.voxels[n]) || !taken.insert(before.voxels[n]).second); }));
  after->probe = probe;
  after->held = !probe.isSoft();
  after->waits = after->moves = false;
  if (!after->voxels.empty())
  {
    after->place = after->voxels.front();
    std::copy_n(after->grabbed.begin(), 3, after->placeGrabbed.begin());
    if (after->rotates())
    {
      this->follow(*after, Elements(this->bricks_, { after->place }).displacements().data());
    }
  }
  this->mark({ after });
  return after;
}

Handles::Change Handles::take(const std::vector<Probe>& probes)
{
  // Everything that can fail because of the caller's data comes first.
  const auto placeOf = [](const Probe& probe)
  { return std::make_tuple(probe.position, probe.radius, probe.rotates, probe.body); };
  std::multimap<decltype(placeOf(Probe())), Pointer> left;
  for (const Pointer& handle : this->handles_)
  {
    left.emplace(placeOf(handle->probe), handle);
  }
  std::vector<Pointer> next(probes.size());
  std::vector<Probe> newProbes;
  std::vector<std::size_t> newNumbers;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    this->check(probes[n], n);
    const auto place = placeOf(probes[n]);
    const auto same = left.lower_bound(place); // the first of several alike
    if (same != left.end() && same->first == place)
    {
      next[n] = same->second;
      left.erase(same);
    }
    else
    {
      newProbes.push_back(probes[n]);
      newNumbers.push_back(n);
    }
  }
  const std::vector<Grabbed> grabbed = this->grab_(newProbes, newNumbers);

  Change change;
  const auto release = [&change](const Pointer& handle)
  {
    change.soft = change.soft || handle->isSoft();
    if (!handle->isSoft())
    {
      change.released.push_back(handle);
    }
  };
  std::for_each(left.begin(), left.end(), [&](const auto& entry) { release(entry.second); });
  std::unordered_set<std::size_t> taken;
  std::vector<char> grabs(probes.size(), 0);
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    grabs[n] = !next[n] || next[n]->isSoft() != probes[n].isSoft() ? 1 : 0;
    if (!grabs[n] && !next[n]->isSoft())
    {
      taken.insert(next[n]->voxels.begin(), next[n]->voxels.end());
    }
  }
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    if (next[n] && grabs[n])
    {
      const Pointer before = next[n];
      next[n] = this->changed(probes[n], *before, taken);
      release(before);
    }
  }
  const std::vector<Pointer> made = this->make(newProbes, grabbed, taken);
  for (std::size_t m = 0; m < made.size(); ++m)
  {
    next[newNumbers[m]] = made[m];
  }

  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    const Probe before = next[n]->probe;
    const bool moves = grabs[n] || before.anchor != probes[n].anchor || isMoved(before, probes[n]);
    if (probes[n].isSoft())
    {
      change.soft = change.soft || moves || before.tolerance != probes[n].tolerance;
    }
    else if (!probes[n].anchor && moves)
    {
      change.moved.push_back(next[n]);
    }
    if (probes[n].rotates && before.centre != probes[n].centre)
    {
      // The same rigid motion, expressed about the new centre: its shift is the displacement of that centre.
      const Vector3 now = next[n]->pose.of(probes[n].centre, before.centre);
      for (int a = 0; a < 3; ++a)
      {
        next[n]->pose.shift[a] = now[a] - probes[n].centre[a];
      }
    }
    next[n]->probe = probes[n];
  }
  this->handles_ = std::move(next);
  return change;
}

Handles::Pointer Handles::join(const std::vector<std::size_t>& voxels, const std::vector<Pointer>& handles)
{
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  std::vector<double> now; // of the elements that the probes hold [mm], 3 values each
  std::vector<double> asked;
  for (const Pointer& handle : handles)
  {
    const std::vector<float> u = handle->elements.displacements();
    for (std::size_t n = 0; n < u.size(); ++n)
    {
      const std::size_t a = n % 3;
      const Index3 at = this->bricks_.model().grid().indexOf(handle->voxels[n / 3]);
      now.push_back(this->origin_[a] + (at[a] + static_cast<double>(u[n])) * spacing[a]);
      asked.push_back(
        now.back() + handle->probe.displacement[a] + (static_cast<double>(handle->grabbed[n]) - u[n]) * spacing[a]);
    }
  }
  constexpr double rounding = 1e-5;
  double longest = 0.0;
  double apart = 0.0;
  for (std::size_t n = 0; n < now.size(); ++n)
  {
    longest = std::max(longest, std::fabs(asked[n] - now[n]));
    apart = std::max(apart, std::fabs((asked[n] - now[n]) - (asked[n % 3] - now[n % 3])));
  }
  if (apart <= rounding * longest)
  {
    return nullptr;
  }
  Vector3 centre{};
  Vector3 goal{};
  const double count = static_cast<double>(now.size() / 3);
  for (std::size_t n = 0; n < now.size(); ++n)
  {
    centre[n % 3] += now[n] / count;
    goal[n % 3] += asked[n] / count;
  }
  for (std::size_t n = 0; n < now.size(); ++n)
  {
    now[n] -= centre[n % 3];
    asked[n] -= goal[n % 3];
  }
  const auto joined = std::make_shared<Handle>(this->bricks_);
  joined->probe.rotates = true;
  joined->probe.centre = centre;
  joined->probe.rotation = rotationVectorOf(nearestRotation(now, asked));
  for (int a = 0; a < 3; ++a)
  {
    joined->probe.displacement[a] = goal[a] - centre[a];
  }
  joined->voxels = voxels;
  this->fill({ joined }, { voxels.front() });
  this->joined_.push_back(joined);
  return joined;
}

void Handles::part(const std::vector<Pointer>& joined)
{
  this->letGo(joined);
  for (const Pointer& handle : joined)
  {
    this->joined_.erase(std::remove(this->joined_.begin(), this->joined_.end(), handle), this->joined_.end());
  }
}

void Handles::letGo(const std::vector<Pointer>& released)
{
  if (released.empty())
  {
    return;
  }
  for (const Pointer& handle : released)
  {
    handle->held = false;
  }
  this->mark(released);
  std::vector<Pointer> others;
  std::copy_if(this->handles_.begin(), this->handles_.end(), std::back_inserter(others),
    [](const Pointer& handle) { return handle->held; });
  this->mark(others);
}

void Handles::clear()
{
  this->setHeld([](const Handle&) { return false; });
  this->handles_.clear();
  this->joined_.clear();
}

void Handles::forget(const std::vector<std::size_t>& voxels)
{
  const std::unordered_set<std::size_t> carved(voxels.begin(), voxels.end());
  for (const Pointer& handle : this->handles_)
  {
    Handle kept = without(*handle, this->bricks_, [&](std::size_t n) { return carved.count(handle->voxels[n]) > 0; });
    const bool placeCarved = carved.count(handle->place) > 0;
    if (placeCarved && kept.voxels.empty())
    {
      kept.placeGrabbed.fill(0.0f); // a carved element has the displacement 0
    }
    else if (placeCarved)
    {
      kept.place = kept.voxels.front();
      std::copy_n(kept.grabbed.begin(), 3, kept.placeGrabbed.begin());
    }
    *handle = std::move(kept);
  }
}

std::vector<std::size_t> Handles::voxels() const
{
  std::vector<std::size_t> voxels;
  for (const Pointer& handle : this->handles_)
  {
    if (!handle->isSoft())
    {
      voxels.insert(voxels.end(), handle->voxels.begin(), handle->voxels.end());
    }
  }
  return voxels;
}

std::vector<std::size_t> Handles::rotatingVoxels() const
{
  std::vector<std::size_t> voxels;
  for (const Pointer& handle : this->handles_)
  {
    if (handle->rotates())
    {
      voxels.insert(voxels.end(), handle->voxels.begin(), handle->voxels.end());
    }
  }
  return voxels;
}

/// Recomputes the pose of a handle with a prescribed rotation if a later probe has dragged its tissue along
/// (ConflictPolicy::Latest). `displacement`: the current one of the element Handle::place.
void Handles::follow(Handle& handle, const float* displacement)
{
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  const std::vector<float> expected = handle.displacedBy(handle.pose, spacing);
  const auto own = std::find(handle.voxels.begin(), handle.voxels.end(), handle.place);
  if (own == handle.voxels.end() ||
      std::equal(displacement, displacement + 3, expected.begin() + 3 * (own - handle.voxels.begin())))
  {
    return;
  }
  const std::vector<float> u = handle.elements.displacements();
  const double count = static_cast<double>(handle.elements.size());
  std::vector<double> rest = handle.placesGrabbed;
  std::vector<double> now = handle.placesGrabbed;
  Vector3 restMean{};
  Vector3 nowMean{};
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    now[n] += (static_cast<double>(u[n]) - handle.grabbed[n]) * spacing[n % 3];
    restMean[n % 3] += rest[n] / count;
    nowMean[n % 3] += now[n] / count;
  }
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    rest[n] -= restMean[n % 3];
    now[n] -= nowMean[n % 3];
  }
  handle.pose.rotation = rotationVectorOf(nearestRotation(rest, now, rotationBy(handle.pose.rotation)));
  handle.pose.shift = {};
  const Vector3 rotatedMean = handle.pose.of(restMean, handle.probe.centre);
  for (int a = 0; a < 3; ++a)
  {
    handle.pose.shift[a] = nowMean[a] - rotatedMean[a];
  }
}

std::vector<ProbeResult> Handles::reached()
{
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  Elements elements(this->bricks_);
  std::vector<float> grabbed;
  std::vector<std::size_t> ends;
  for (const Pointer& handle : this->handles_)
  {
    if (handle->isSoft() && !handle->voxels.empty())
    {
      elements.add(handle->elements);
      grabbed.insert(grabbed.end(), handle->grabbed.begin(), handle->grabbed.end());
    }
    else
    {
      elements.add(handle->place);
      grabbed.insert(grabbed.end(), handle->placeGrabbed.begin(), handle->placeGrabbed.end());
    }
    ends.push_back(elements.size());
  }
  const std::vector<float> displacements = elements.displacements();
  std::vector<ProbeResult> results(this->handles_.size());
  std::size_t m = 0;
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    Handle& handle = *this->handles_[n];
    results[n].elements = handle.voxels.size();
    if (handle.rotates() && !handle.probe.anchor)
    {
      this->follow(handle, &displacements[3 * m]);
      results[n].reached = handle.pose.shift;
      results[n].rotated = handle.pose.rotation;
      m = ends[n];
      continue;
    }
    const double count = static_cast<double>(ends[n] - m);
    for (; m < ends[n]; ++m)
    {
      for (int a = 0; a < 3; ++a)
      {
        results[n].reached[a] +=
          (static_cast<double>(displacements[3 * m + a]) - grabbed[3 * m + a]) * spacing[a] / count;
      }
    }
  }
  return results;
}

// --- Soft probes

/// The displacements of the elements of a soft probe at which its links cost no energy.
std::vector<float> Handles::softPlaces(const Handle& handle) const
{
  if (handle.probe.rotates && !handle.probe.anchor)
  {
    return handle.displacedBy(handle.asked(), this->bricks_.model().grid().spacing);
  }
  std::array<float, 3> to{};
  for (int a = 0; a < 3 && !handle.probe.anchor; ++a)
  {
    to[a] = static_cast<float>(handle.probe.displacement[a] / this->bricks_.model().grid().spacing[a]);
  }
  return handle.displacedBy(to);
}

/// The weight of each link of a soft probe (SoftLink).
double Handles::softWeight(const Handle& handle) const
{
  constexpr double least = 1e-6; // as small as WEIGHT_EPSILON, so that the weight stays finite
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  return handle.share / std::max(handle.probe.tolerance / std::cbrt(spacing[0] * spacing[1] * spacing[2]), least);
}

std::vector<SoftLink> Handles::softLinks() const
{
  const cl_float4 proportions = proportionsOf(this->bricks_.model().grid());
  std::vector<SoftLink> links;
  for (const Pointer& handle : this->handles_)
  {
    const std::vector<float> places = handle->isSoft() ? this->softPlaces(*handle) : std::vector<float>();
    for (std::size_t n = 0; n < places.size() / 3; ++n)
    {
      SoftLink link;
      link.voxel = handle->voxels[n];
      link.weight = this->softWeight(*handle);
      std::copy_n(places.begin() + 3 * static_cast<std::ptrdiff_t>(n), 3, link.place.begin());
      links.push_back(link);
    }
  }
  std::stable_sort(
    links.begin(), links.end(), [](const SoftLink& one, const SoftLink& other) { return one.voxel < other.voxel; });
  std::vector<SoftLink> sums;
  for (const SoftLink& link : links)
  {
    if (sums.empty() || sums.back().voxel != link.voxel)
    {
      sums.push_back(link);
      continue;
    }
    // Links of weights w and v to the places p and q are equivalent to one link of weight w + v to their weighted mean,
    // plus a constant energy of w v / (w + v) |p - q|^2 (`least`).
    SoftLink& sum = sums.back();
    const double weight = sum.weight + link.weight;
    for (int a = 0; a < 3; ++a)
    {
      const double way = link.place[a] - sum.place[a];
      const double length = way * proportions.s[a];
      sum.least += sum.weight * link.weight / weight * length * length;
      sum.place[a] += link.weight / weight * way;
    }
    sum.weight = weight;
  }
  return sums;
}

Vector3 Handles::softForce(const Handle& handle)
{
  const cl_float4 proportions = proportionsOf(this->bricks_.model().grid());
  const std::vector<float> places = this->softPlaces(handle);
  const std::vector<float> now = handle.elements.displacements();
  Vector3 force{};
  for (std::size_t n = 0; n < places.size(); ++n)
  {
    const double way = static_cast<double>(places[n]) - now[n];
    force[n % 3] += 2.0 * this->softWeight(handle) * way * proportions.s[n % 3];
  }
  return force;
}

}
