#include "Rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace chainmail
{

namespace
{

constexpr std::int64_t voxel = static_cast<std::int64_t>(unitsPerVoxel);
constexpr std::int64_t anywhere = std::int64_t(1) << 61; // beyond all positions

/// Whether all corners are on the same side of a position along an axis: a quick test that excludes most triangles of a
/// column.
bool beside(const ExactTriangle& triangle, const Fixed3& place, int axis)
{
  const std::int64_t at = place[axis];
  const bool below = triangle.corner[0][axis] < at && triangle.corner[1][axis] < at && triangle.corner[2][axis] < at;
  const bool above = triangle.corner[0][axis] > at && triangle.corner[1][axis] > at && triangle.corner[2][axis] > at;
  return below || above;
}

}

Rays::Rays(const ClosedSurface& surface)
  : Rays(surface, { -anywhere, -anywhere, -anywhere }, { anywhere, anywhere, anywhere })
{
}

Rays::Rays(const ClosedSurface& surface, const Fixed3& low, const Fixed3& high)
  : alternating_(surface.alternating)
  , alternates_(std::any_of(surface.alternating.begin(), surface.alternating.end(), [](int sign) { return sign != 0; }))
{
  Fixed3 first{ anywhere, anywhere, anywhere };
  Fixed3 last{ -anywhere, -anywhere, -anywhere };
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
  {
    const std::array<int, 3>& ids = surface.triangles[t];
    const Triangle triangle(
      { surface.points[ids[0]], surface.points[ids[1]], surface.points[ids[2]] }, surface.part[t]);
    for (const Fixed3& corner : triangle.corner)
    {
      for (int a = 0; a < 3; ++a)
      {
        first[a] = std::min(first[a], corner[a]);
        last[a] = std::max(last[a], corner[a]);
      }
    }
    // A ray along x meets no triangle that is parallel to it, not even when all tissue is shifted (ExactGeometry.h).
    if (triangle.normal[0] != 0)
    {
      this->triangles_.push_back(triangle);
    }
  }
  constexpr std::int64_t mostColumns = 1024;
  for (int a = 0; a < 3; ++a)
  {
    this->low_[a] = std::max(low[a], first[a]);
    this->high_[a] = std::min(high[a], last[a]);
    if (this->low_[a] > this->high_[a])
    {
      this->triangles_.clear();
      return;
    }
    const std::int64_t extent = this->high_[a] - this->low_[a] + 1;
    this->width_[a] = std::max(voxel, (extent + mostColumns - 1) / mostColumns);
    this->counts_[a] = (extent + this->width_[a] - 1) / this->width_[a];
  }

  this->ends_.assign(static_cast<std::size_t>(this->counts_[1] * this->counts_[2]) + 1, 0);
  for (const Triangle& triangle : this->triangles_)
  {
    this->forColumns(triangle, [&](std::size_t column) { ++this->ends_[column]; });
  }
  std::partial_sum(this->ends_.begin(), this->ends_.end(), this->ends_.begin());
  this->inColumn_.resize(this->ends_.back());
  // Filling each column backwards turns its end in ends_ into its begin.
  for (std::size_t n = 0; n < this->triangles_.size(); ++n)
  {
    this->forColumns(this->triangles_[n],
      [&](std::size_t column) { this->inColumn_[--this->ends_[column]] = static_cast<std::uint32_t>(n); });
  }
}

std::int64_t Rays::columnOf(double at, int axis) const
{
  return static_cast<std::int64_t>(
    std::floor((at - static_cast<double>(this->low_[axis])) / static_cast<double>(this->width_[axis])));
}

template <typename F> void Rays::forColumns(const ExactTriangle& triangle, F&& f) const
{
  // Doubles are rounded, so each range is one unit wider than the exact one on every side.
  const auto range = std::minmax({ triangle.corner[0][2], triangle.corner[1][2], triangle.corner[2][2] });
  const std::int64_t firstZ = std::max<std::int64_t>(this->columnOf(static_cast<double>(range.first) - 1.0, 2), 0);
  const std::int64_t lastZ = std::min(this->columnOf(static_cast<double>(range.second) + 1.0, 2), this->counts_[2] - 1);
  for (std::int64_t z = firstZ; z <= lastZ; ++z)
  {
    const double from = static_cast<double>(this->low_[2] + z * this->width_[2]) - 1.0;
    const double to = from + static_cast<double>(this->width_[2]) + 2.0;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (int e = 0; e < 3; ++e)
    {
      const double ay = static_cast<double>(triangle.corner[e][1]);
      const double az = static_cast<double>(triangle.corner[e][2]);
      const double by = static_cast<double>(triangle.corner[(e + 1) % 3][1]);
      const double bz = static_cast<double>(triangle.corner[(e + 1) % 3][2]);
      if (std::max(az, bz) < from || std::min(az, bz) > to)
      {
        continue;
      }
      for (const double limit : { from, to })
      {
        const double t = az == bz ? (limit == from ? 0.0 : 1.0) : std::clamp((limit - az) / (bz - az), 0.0, 1.0);
        lowest = std::min(lowest, ay + t * (by - ay));
        highest = std::max(highest, ay + t * (by - ay));
      }
    }
    const std::int64_t firstY = std::max<std::int64_t>(this->columnOf(lowest - 1.0, 1), 0);
    const std::int64_t lastY = std::min(this->columnOf(highest + 1.0, 1), this->counts_[1] - 1);
    for (std::int64_t y = firstY; lowest <= highest && y <= lastY; ++y)
    {
      f(static_cast<std::size_t>(y + this->counts_[1] * z));
    }
  }
}

bool Rays::contains(const Vector3& place) const
{
  for (int a = 0; a < 3; ++a)
  {
    // This also rejects positions that are too far away to be rounded to an integer.
    const double rounded = std::round(place[a] * unitsPerVoxel);
    if (!(rounded >= static_cast<double>(this->low_[a]) && rounded <= static_cast<double>(this->high_[a])))
    {
      return false;
    }
  }
  char result = 0;
  this->row(fixed(place), 1, &result);
  return result != 0;
}

void Rays::row(const Fixed3& first, int count, char* inside) const
{
  std::vector<int> winding(count, 0);
  for (const Crossing& crossing : this->crossings(first, count))
  {
    for (int i = 0; i < crossing.before; ++i)
    {
      winding[i] += crossing.sign;
    }
  }
  std::transform(winding.begin(), winding.end(), inside, [](int n) { return static_cast<char>(n != 0); });
}

int Rays::winding(const Fixed3& place, const std::vector<int>& weights) const
{
  for (int a = 0; a < 3; ++a)
  {
    if (place[a] < this->low_[a] || place[a] > this->high_[a])
    {
      return 0;
    }
  }
  int sum = 0;
  for (const Crossing& crossing : this->crossings(place, 1))
  {
    sum += crossing.sign * weights[crossing.part];
  }
  return sum;
}

std::vector<Rays::Crossing> Rays::crossings(const Fixed3& first, int count) const
{
  std::vector<Crossing> found;
  const std::size_t column = static_cast<std::size_t>(
    (first[1] - this->low_[1]) / this->width_[1] + this->counts_[1] * ((first[2] - this->low_[2]) / this->width_[2]));
  for (std::uint64_t n = this->ends_[column]; n < this->ends_[column + 1]; ++n)
  {
    const Triangle& triangle = this->triangles_[this->inColumn_[n]];
    if (beside(triangle, first, 1) || beside(triangle, first, 2) || !triangle.meetsLine(first, { 1, 0, 0 }))
    {
      continue;
    }
    // The triangle is ahead of the positions that are not on the same side as the far end of the row. They come first
    // in the row, so a binary search counts them.
    const int beyond = triangle.normal[0] > 0 ? 1 : -1;
    int before = 0;
    for (int after = count; before < after;)
    {
      const int middle = (before + after) / 2;
      const bool ahead = triangle.side({ first[0] + middle * voxel, first[1], first[2] }) != beyond;
      before = ahead ? middle + 1 : before;
      after = ahead ? after : middle;
    }
    if (before > 0)
    {
      found.push_back({ triangle.part, beyond, before });
    }
  }
  if (this->alternates_)
  {
    // Even-odd rule: from the far end of the row, the crossings of an alternating part lead into it and out of it in
    // turn.
    std::sort(found.begin(), found.end(),
      [](const Crossing& a, const Crossing& b) { return a.part != b.part ? a.part < b.part : a.before > b.before; });
    for (std::size_t n = 0; n < found.size(); ++n)
    {
      const int sign = this->alternating_[found[n].part];
      const bool isFirst = n == 0 || found[n - 1].part != found[n].part;
      found[n].sign = sign == 0 ? found[n].sign : isFirst ? sign : -found[n - 1].sign;
    }
  }
  return found;
}

}
