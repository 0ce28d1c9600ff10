#include "Handles.h"

#include "ElementRule.h"
#include "Error.h"
#include "Grasp.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <unordered_set>

namespace chainmail
{

namespace
{

// [voxels] A float32 displacement much larger than this would be infinite, and its wave would never end.
constexpr double farthest = 1e9;

void check(const Probe& probe, std::size_t number, const Vector3& spacing)
{
  for (int a = 0; a < 3; ++a)
  {
    if (!std::isfinite(probe.position[a]))
    {
      throw ProbeError(number, nameOf(probe, number), "has a position that is not finite.");
    }
    if (!probe.anchor && !std::isfinite(probe.displacement[a]))
    {
      throw ProbeError(number, nameOf(probe, number), "has a displacement that is not finite.");
    }
    if (!probe.anchor && !(std::fabs(probe.displacement[a] / spacing[a]) < farthest))
    {
      throw ProbeError(
        number, nameOf(probe, number), "has a displacement of a billion voxels or more: move its target nearer.");
    }
  }
  if (!(probe.radius >= 0.0) || !std::isfinite(probe.radius))
  {
    throw ProbeError(number, nameOf(probe, number), "has a radius that is negative or not finite.");
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

/// Completes handles that have their probes and voxels. `places` gives an element near each of them.
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
  this->bricks_.require(needed);

  std::vector<std::uint32_t> addresses;
  for (std::size_t n = 0; n < handles.size(); ++n)
  {
    Handle& handle = *handles[n];
    handle.constraints.resize(axes * handle.voxels.size());
    for (std::size_t m = 0; m < handle.voxels.size(); ++m)
    {
      const Index3 at = grid.indexOf(handle.voxels[m]);
      handle.addresses.push_back(this->bricks_.address(at[0], at[1], at[2]));
      this->bricks_.row(at[0], at[1], at[2], 1, handle.constraints.data() + axes * m);
    }
    const Index3 at = grid.indexOf(places[n]);
    handle.place = this->bricks_.address(at[0], at[1], at[2]);
    addresses.insert(addresses.end(), handle.addresses.begin(), handle.addresses.end());
    addresses.push_back(handle.place);
  }
  const std::vector<float> displacements = this->bricks_.displacements(addresses);
  auto from = displacements.begin();
  for (const Pointer& handle : handles)
  {
    const auto end = from + 3 * handle->addresses.size();
    handle->grabbed.assign(from, end);
    std::copy_n(end, 3, handle->placeGrabbed.begin());
    from = end + 3;
  }
}

/// Marks the elements of these handles on the device as held or not held.
void Handles::mark(const std::vector<Pointer>& handles)
{
  std::vector<std::uint32_t> addresses;
  std::vector<float> constraints;
  for (const Pointer& handle : handles)
  {
    addresses.insert(addresses.end(), handle->addresses.begin(), handle->addresses.end());
    for (const float c : handle->constraints)
    {
      constraints.push_back(rule::asHeld(c, handle->held));
    }
  }
  this->bricks_.setConstraints(addresses, constraints);
}

/// Makes the handles of new probes. `goingOn`: the handles that stay, null for new probes. An element has one holder:
/// the handle that has it already, else an anchor, else the first probe that grabs it. Other probes take the rest, and
/// are compatible with the holder only if the links between them allow it.
std::vector<Handles::Pointer> Handles::make(const std::vector<Probe>& probes,
  const std::vector<std::vector<std::size_t>>& grabbed, const std::vector<Pointer>& goingOn)
{
  std::unordered_set<std::size_t> taken;
  for (const Pointer& handle : goingOn)
  {
    if (handle)
    {
      taken.insert(handle->voxels.begin(), handle->voxels.end());
    }
  }
  const Grid& grid = this->bricks_.model().grid();
  const auto isAnchored = [&](std::size_t voxel)
  {
    const Index3 at = grid.indexOf(voxel);
    float c[3];
    this->bricks_.row(at[0], at[1], at[2], 1, c);
    return std::signbit(c[0]);
  };
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
      made[m] = std::make_shared<Handle>();
      made[m]->probe = probes[m];
      for (const std::size_t voxel : grabbed[m])
      {
        if (!isAnchored(voxel) && taken.insert(voxel).second)
        {
          made[m]->voxels.push_back(voxel);
        }
      }
      places[m] = made[m]->voxels.empty() ? grabbed[m].front() : made[m]->voxels.front();
      made[m]->held = true;
    }
  }
  this->fill(made, places);
  this->mark(made);
  return made;
}

Handles::Change Handles::take(const std::vector<Probe>& probes)
{
  // Everything that the caller's data can make fail comes first.
  using Place = std::pair<Vector3, double>;
  std::multimap<Place, Pointer> left;
  for (const Pointer& handle : this->handles_)
  {
    left.emplace(Place(handle->probe.position, handle->probe.radius), handle);
  }
  std::vector<Pointer> next(probes.size());
  std::vector<Probe> newProbes;
  std::vector<std::size_t> newNumbers;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    check(probes[n], n, this->bricks_.model().grid().spacing);
    const Place place(probes[n].position, probes[n].radius);
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
  const std::vector<std::vector<std::size_t>> grabbed = this->grab_(newProbes, newNumbers);

  const std::vector<Pointer> made = this->make(newProbes, grabbed, next);
  for (std::size_t m = 0; m < made.size(); ++m)
  {
    next[newNumbers[m]] = made[m];
  }

  Change change;
  std::transform(
    left.begin(), left.end(), std::back_inserter(change.released), [](const auto& entry) { return entry.second; });
  auto isNew = newNumbers.begin();
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    const Probe before = next[n]->probe;
    const bool grabs = isNew != newNumbers.end() && *isNew == n;
    isNew += grabs ? 1 : 0;
    if (!probes[n].anchor && (grabs || before.anchor || before.displacement != probes[n].displacement))
    {
      change.moved.push_back(next[n]);
    }
    next[n]->probe = probes[n];
  }
  this->handles_ = std::move(next);
  return change;
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
}

void Handles::forget(const std::vector<std::size_t>& voxels)
{
  const Grid& grid = this->bricks_.model().grid();
  const std::ptrdiff_t axes = this->bricks_.model().axes();
  std::unordered_set<std::uint32_t> carved;
  for (const std::size_t voxel : voxels)
  {
    const Index3 at = grid.indexOf(voxel);
    carved.insert(this->bricks_.address(at[0], at[1], at[2]));
  }
  for (const Pointer& handle : this->handles_)
  {
    Handle kept = *handle;
    kept.voxels.clear();
    kept.addresses.clear();
    kept.constraints.clear();
    kept.grabbed.clear();
    for (std::size_t n = 0; n < handle->voxels.size(); ++n)
    {
      if (carved.count(handle->addresses[n]) == 0)
      {
        kept.voxels.push_back(handle->voxels[n]);
        kept.addresses.push_back(handle->addresses[n]);
        const auto c = handle->constraints.begin() + axes * static_cast<std::ptrdiff_t>(n);
        kept.constraints.insert(kept.constraints.end(), c, c + axes);
        kept.grabbed.insert(kept.grabbed.end(), handle->grabbed.begin() + 3 * n, handle->grabbed.begin() + 3 * n + 3);
      }
    }
    const bool placeCarved = carved.count(handle->place) > 0;
    if (placeCarved && kept.voxels.empty())
    {
      kept.placeGrabbed.fill(0.0f); // a carved element has the displacement 0
    }
    else if (placeCarved)
    {
      kept.place = kept.addresses.front();
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
    voxels.insert(voxels.end(), handle->voxels.begin(), handle->voxels.end());
  }
  return voxels;
}

std::vector<ProbeResult> Handles::reached()
{
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  std::vector<std::uint32_t> addresses;
  for (const Pointer& handle : this->handles_)
  {
    addresses.push_back(handle->place);
  }
  const std::vector<float> displacements = this->bricks_.displacements(addresses);
  std::vector<ProbeResult> results(this->handles_.size());
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    results[n].elements = this->handles_[n]->voxels.size();
    for (int a = 0; a < 3; ++a)
    {
      results[n].reached[a] =
        (static_cast<double>(displacements[3 * n + a]) - this->handles_[n]->placeGrabbed[a]) * spacing[a];
    }
  }
  return results;
}

}
