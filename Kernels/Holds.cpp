#include "Holds.h"

#include "Error.h"
#include "Measurement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <unordered_set>

namespace chainmail
{

namespace
{

std::string text(const Vector3& v)
{
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), "(%.6g, %.6g, %.6g)", v[0], v[1], v[2]);
  return buffer;
}

std::string nameOf(const Probe& probe, std::size_t number)
{
  return "Probe " + std::to_string(number) + " at " + text(probe.position) + " mm along the image's axes";
}

// [voxels] Elements keep float32: far more than that is infinite there, and a wave of it would never end.
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

/// Finds the elements around a probe one by one.
class Grasp
{
public:
  Grasp(const Probe& probe, const Grid& grid)
    : probe_(probe)
    , spacing_(grid.spacing)
  {
    // The nearest element is one within reach of the voxel's own corners.
    for (int a = 0; a < 3; ++a)
    {
      this->reach2_ += 0.25 * grid.spacing[a] * grid.spacing[a];
    }
    this->reach2_ *= 1.0 + 1e-9;
    this->radius2_ = probe.radius * probe.radius * (1.0 + 1e-9);
  }

  /// Elements further from the probe than this do not matter [mm].
  double farthest() const { return std::sqrt(std::max(this->reach2_, this->radius2_)); }

  /// An element at a place in voxels.
  void offer(std::size_t voxel, double x, double y, double z)
  {
    const double dx = x * this->spacing_[0] - this->probe_.position[0];
    const double dy = y * this->spacing_[1] - this->probe_.position[1];
    const double dz = z * this->spacing_[2] - this->probe_.position[2];
    const double distance2 = dx * dx + dy * dy + dz * dz;
    if (this->probe_.radius > 0.0 && distance2 <= this->radius2_)
    {
      this->within_.push_back(voxel);
    }
    if (distance2 < this->nearest2_ || (distance2 == this->nearest2_ && voxel < this->nearest_))
    {
      this->nearest2_ = distance2;
      this->nearest_ = voxel;
    }
  }

  /// What the probe grabs, ascending; empty where nothing is near.
  std::vector<std::size_t> grabbed()
  {
    if (this->within_.empty() && this->nearest2_ <= this->reach2_)
    {
      return { this->nearest_ };
    }
    std::sort(this->within_.begin(), this->within_.end());
    return this->within_;
  }

private:
  const Probe& probe_;
  Vector3 spacing_;
  double reach2_ = 0.0;
  double radius2_ = 0.0;
  std::vector<std::size_t> within_;
  std::size_t nearest_ = 0;
  double nearest2_ = std::numeric_limits<double>::infinity();
};

/// The voxels of one axis whose places can lie within `farthest` of `position`, first to last, when each is displaced
/// by something from `low` to `high` voxels.
void clampRange(
  double position, double farthest, double spacing, double low, double high, int begin, int end, int& first, int& last)
{
  first = static_cast<int>(
    std::min(std::max(std::ceil((position - farthest) / spacing - high), static_cast<double>(begin)), end + 0.0));
  last =
    static_cast<int>(std::max(std::min(std::floor((position + farthest) / spacing - low), end - 1.0), begin - 1.0));
}

}

std::vector<float> Hold::displacedBy(const std::array<float, 3>& to) const
{
  std::vector<float> values = this->grabbed;
  for (std::size_t n = 0; n < values.size(); ++n)
  {
    values[n] += to[n % 3];
  }
  return values;
}

std::vector<std::size_t> elementsAround(Bricks& bricks, const Probe& probe, std::size_t number)
{
  const Grid& grid = bricks.model().grid();
  const int axes = bricks.model().axes();
  Grasp grasp(probe, grid);
  const double farthest = grasp.farthest();
  std::vector<float> row;

  // Tissue that has moved, brick by brick.
  std::unordered_set<int> displaced;
  const std::vector<BrickFigures> figures =
    bricks.touchedSlots().empty() ? std::vector<BrickFigures>() : measureBricks(bricks);
  const Index3 size = bricks.size();
  const std::size_t count = bricks.elementsPerBrick();
  std::vector<float> u;
  for (std::size_t n = 0; n < figures.size(); ++n)
  {
    if (figures[n].displaced == 0.0f)
    {
      continue;
    }
    const int slot = static_cast<int>(n) + 1;
    const int brick = bricks.brick(slot);
    displaced.insert(brick);
    const Index3 origin = bricks.origin(brick);
    Index3 first;
    Index3 last;
    bool near = true;
    for (int a = 0; a < 3; ++a)
    {
      clampRange(probe.position[a], farthest, grid.spacing[a], figures[n].low[a], figures[n].high[a], origin[a],
        std::min(origin[a] + size[a], grid.size[a]), first[a], last[a]);
      near = near && first[a] <= last[a];
    }
    if (!near)
    {
      continue;
    }
    bricks.readSlot(slot, u);
    row.resize(static_cast<std::size_t>(last[0] - first[0] + 1) * axes);
    for (int k = first[2]; k <= last[2]; ++k)
    {
      for (int j = first[1]; j <= last[1]; ++j)
      {
        bricks.row(first[0], j, k, last[0] - first[0] + 1, row.data());
        for (int i = first[0]; i <= last[0]; ++i)
        {
          if (!std::isinf(row[static_cast<std::size_t>(i - first[0]) * axes]))
          {
            const std::uint32_t at = bricks.local(i, j, k);
            grasp.offer(grid.at(i, j, k), static_cast<double>(i) + u[at], static_cast<double>(j) + u[count + at],
              static_cast<double>(k) + u[2 * count + at]);
          }
        }
      }
    }
  }

  // Tissue at rest.
  Index3 first;
  Index3 last;
  for (int a = 0; a < 3; ++a)
  {
    clampRange(probe.position[a], farthest, grid.spacing[a], 0.0, 0.0, 0, grid.size[a], first[a], last[a]);
  }
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1] && first[0] <= last[0]; ++j)
    {
      row.resize(static_cast<std::size_t>(last[0] - first[0] + 1) * axes);
      bricks.row(first[0], j, k, last[0] - first[0] + 1, row.data());
      for (int i = first[0]; i <= last[0]; ++i)
      {
        if (!std::isinf(row[static_cast<std::size_t>(i - first[0]) * axes]) &&
            (displaced.empty() || displaced.count(bricks.brickAt(i, j, k)) == 0))
        {
          grasp.offer(grid.at(i, j, k), i, j, k);
        }
      }
    }
  }

  std::vector<std::size_t> grabbed = grasp.grabbed();
  if (grabbed.empty())
  {
    throw ProbeError(number, nameOf(probe, number),
      "holds no tissue: there is none within its radius of " + std::to_string(probe.radius) +
        " mm. Move it onto tissue, enlarge its radius, or lower the tissue threshold.");
  }
  return grabbed;
}

/// `mine` of all that the probe grabbed are its own.
void Holds::fill(Hold& hold, const std::vector<std::size_t>& mine, const std::vector<std::size_t>& grabbed)
{
  const Grid& grid = this->bricks_.model().grid();
  const auto addressesOf = [&](const std::vector<std::size_t>& voxels, std::vector<int>& bricks)
  {
    std::vector<Index3> places;
    for (const std::size_t voxel : voxels)
    {
      places.push_back(grid.indexOf(voxel));
      bricks.push_back(this->bricks_.brickAt(places.back()[0], places.back()[1], places.back()[2]));
    }
    std::sort(bricks.begin(), bricks.end());
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    this->bricks_.require(bricks);
    std::vector<std::uint32_t> addresses;
    for (const Index3& at : places)
    {
      addresses.push_back(this->bricks_.address(at[0], at[1], at[2]));
    }
    return addresses;
  };
  hold.voxels = mine;
  hold.addresses = addressesOf(mine, hold.bricks);
  hold.grabbed = this->bricks_.displacements(hold.addresses);
  std::vector<int> bricks;
  hold.place = addressesOf({ mine.empty() ? grabbed.front() : mine.front() }, bricks).front();
  const std::vector<float> at = this->bricks_.displacements({ hold.place });
  std::copy(at.begin(), at.end(), hold.placeGrabbed.begin());
}

Holds::Change Holds::take(const std::vector<Probe>& probes)
{
  // First all that can fail for the caller's sake.
  std::vector<Pointer> next(probes.size());
  std::vector<std::vector<std::size_t>> grabbed(probes.size());
  std::vector<Pointer> left = this->holds_;
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    check(probes[n], n, this->bricks_.model().grid().spacing);
    const auto same = std::find_if(left.begin(), left.end(),
      [&](const Pointer& hold)
      { return hold && hold->probe.position == probes[n].position && hold->probe.radius == probes[n].radius; });
    if (same != left.end())
    {
      next[n] = *same;
      *same = nullptr;
    }
    else
    {
      grabbed[n] = this->grab_(probes[n], n);
    }
  }

  Change change;
  std::copy_if(left.begin(), left.end(), std::back_inserter(change.released), [](const Pointer& h) { return h; });

  // An element has one holder: whoever has it already, else an anchor, else the first probe that grabs it. The others
  // take what is left, and are compatible with its holder only if the links between allow it.
  std::vector<std::size_t> taken;
  const auto take = [&taken](const std::vector<std::size_t>& voxels)
  {
    std::vector<std::size_t> both;
    std::set_union(taken.begin(), taken.end(), voxels.begin(), voxels.end(), std::back_inserter(both));
    taken.swap(both);
  };
  for (const Pointer& hold : next)
  {
    if (hold)
    {
      take(hold->voxels);
    }
  }
  const Grid& grid = this->bricks_.model().grid();
  for (const bool anchors : { true, false })
  {
    for (std::size_t n = 0; n < probes.size(); ++n)
    {
      if (next[n] || probes[n].anchor != anchors)
      {
        continue;
      }
      std::vector<std::size_t> mine;
      std::set_difference(grabbed[n].begin(), grabbed[n].end(), taken.begin(), taken.end(), std::back_inserter(mine));
      mine.erase(std::remove_if(mine.begin(), mine.end(),
                   [&](std::size_t voxel)
                   {
                     const Index3 at = grid.indexOf(voxel);
                     float c[3];
                     this->bricks_.row(at[0], at[1], at[2], 1, c);
                     return std::signbit(c[0]);
                   }),
        mine.end());
      take(mine);
      next[n] = std::make_shared<Hold>();
      next[n]->probe = probes[n];
      this->fill(*next[n], mine, grabbed[n]);
      this->setHeld(*next[n], true);
      if (!probes[n].anchor)
      {
        change.moved.push_back(next[n]);
      }
    }
  }
  for (std::size_t n = 0; n < probes.size(); ++n)
  {
    Probe& before = next[n]->probe;
    if (!probes[n].anchor && (before.anchor || before.displacement != probes[n].displacement))
    {
      change.moved.push_back(next[n]);
    }
    before = probes[n];
  }
  const auto place = [&next](const Pointer& hold) { return std::find(next.begin(), next.end(), hold); };
  std::sort(
    change.moved.begin(), change.moved.end(), [&](const Pointer& a, const Pointer& b) { return place(a) < place(b); });
  this->holds_ = std::move(next);
  return change;
}

void Holds::letGo(const std::vector<Pointer>& released)
{
  for (const Pointer& hold : released)
  {
    this->setHeld(*hold, false);
  }
  for (const Pointer& hold : this->holds_)
  {
    if (!released.empty() && hold->held)
    {
      hold->held = false;
      this->setHeld(*hold, true);
    }
  }
}

void Holds::clear()
{
  for (const Pointer& hold : this->holds_)
  {
    this->setHeld(*hold, false);
  }
  this->holds_.clear();
}

void Holds::forget(const std::vector<std::size_t>& voxels)
{
  for (const Pointer& hold : this->holds_)
  {
    Hold kept = *hold;
    kept.voxels.clear();
    kept.addresses.clear();
    kept.grabbed.clear();
    for (std::size_t n = 0; n < hold->voxels.size(); ++n)
    {
      if (!std::binary_search(voxels.begin(), voxels.end(), hold->voxels[n]))
      {
        kept.voxels.push_back(hold->voxels[n]);
        kept.addresses.push_back(hold->addresses[n]);
        kept.grabbed.insert(kept.grabbed.end(), hold->grabbed.begin() + 3 * n, hold->grabbed.begin() + 3 * n + 3);
      }
    }
    const bool placeCarved = std::any_of(voxels.begin(), voxels.end(),
      [&](std::size_t voxel)
      {
        const Index3 at = this->bricks_.model().grid().indexOf(voxel);
        return this->bricks_.address(at[0], at[1], at[2]) == hold->place;
      });
    if (placeCarved && kept.voxels.empty())
    {
      kept.placeGrabbed.fill(0.0f); // carved tissue is at 0
    }
    else if (placeCarved)
    {
      kept.place = kept.addresses.front();
      std::copy_n(kept.grabbed.begin(), 3, kept.placeGrabbed.begin());
    }
    *hold = std::move(kept);
  }
}

void Holds::setHeld(Hold& hold, bool held)
{
  if (hold.held == held)
  {
    return;
  }
  hold.held = held;
  const Grid& grid = this->bricks_.model().grid();
  const int axes = this->bricks_.model().axes();
  std::vector<float> values(hold.voxels.size() * axes);
  for (std::size_t n = 0; n < hold.voxels.size(); ++n)
  {
    const Index3 at = grid.indexOf(hold.voxels[n]);
    float* c = values.data() + n * axes;
    this->bricks_.row(at[0], at[1], at[2], 1, c);
    for (int a = 0; held && a < axes; ++a)
    {
      c[a] = -std::fabs(c[a]);
    }
  }
  this->bricks_.setConstraints(hold.addresses, values);
}

std::vector<std::size_t> Holds::voxels() const
{
  std::vector<std::size_t> voxels;
  for (const Pointer& hold : this->holds_)
  {
    voxels.insert(voxels.end(), hold->voxels.begin(), hold->voxels.end());
  }
  return voxels;
}

std::vector<ProbeResult> Holds::reached()
{
  const Vector3& spacing = this->bricks_.model().grid().spacing;
  std::vector<std::uint32_t> addresses;
  for (const Pointer& hold : this->holds_)
  {
    addresses.push_back(hold->place);
  }
  const std::vector<float> displacements = this->bricks_.displacements(addresses);
  std::vector<ProbeResult> results(this->holds_.size());
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    results[n].elements = this->holds_[n]->voxels.size();
    for (int a = 0; a < 3; ++a)
    {
      results[n].reached[a] =
        (static_cast<double>(displacements[3 * n + a]) - this->holds_[n]->placeGrabbed[a]) * spacing[a];
    }
  }
  return results;
}

}
