#include "CarryCells.h"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace chainmail
{

namespace
{

// Masks of those of 3 x 3 x 3 voxels that are not the last ones along x, y and z.
constexpr unsigned notLast[3] = { 0x36DB6DB, 0x0FC7E3F, 0x00003FFFF };

}

Vector3 RestModel::displacementAt(const Index3& at) const
{
  constexpr double negligible = 1e-6; // brick.clh
  const float* u = this->displacement + 3 * this->grid.at(at[0], at[1], at[2]);
  const double* m = this->toVoxels.data();
  const Vector3 voxels = { m[0] * u[0] + m[1] * u[1] + m[2] * u[2], m[3] * u[0] + m[4] * u[1] + m[5] * u[2],
    m[6] * u[0] + m[7] * u[1] + m[8] * u[2] };
  const bool moved =
    std::fabs(voxels[0]) >= negligible || std::fabs(voxels[1]) >= negligible || std::fabs(voxels[2]) >= negligible;
  return moved ? voxels : Vector3{ 0.0, 0.0, 0.0 };
}

/// Whether an element is linked to the next voxel along an axis, which must be an element, too.
bool CarryCells::isLinked(const Index3& from, int axis) const
{
  const RestModel& m = this->model_;
  return !m.links || (m.links[m.grid.at(from[0], from[1], from[2])] >> (2 * axis + 1) & 1) != 0;
}

CarryCells::Cell CarryCells::cellAt(const Index3& base) const
{
  Cell cell;
  cell.base = base;
  bool isCut = false;
  for (int n = 0; n < 8; ++n)
  {
    const Index3 at = this->cornerAt(base, n);
    const std::size_t voxel = this->model_.grid.at(at[0], at[1], at[2]);
    const bool element = this->model_.element[voxel] != 0;
    cell.elements |= element ? 1u << n : 0;
    if (this->model_.links)
    {
      const unsigned links = this->model_.links[voxel];
      cell.carved |= links & RestModel::carved ? 1u << n : 0;
      for (int a = 0; a < 3; ++a)
      {
        isCut = isCut || (!(n >> a & 1) && !this->model_.isFlat(a) && !(links >> (2 * a + 1) & 1));
      }
    }
    cell.component[n] = element ? static_cast<std::uint8_t>(n) : none;
  }
  if (cell.elements == 0)
  {
    return cell;
  }
  if (cell.elements == 255 && !isCut) // nearly all cells
  {
    cell.component.fill(0);
    return cell;
  }
  for (int pass = 0; pass < 4; ++pass)
  {
    for (int n = 0; n < 8; ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        const int m = n | 1 << a;
        const bool both = m != n && (cell.elements >> n & cell.elements >> m & 1);
        if (both && (this->model_.isFlat(a) || this->isLinked(this->cornerAt(base, n), a)))
        {
          const std::uint8_t lowest = std::min(cell.component[n], cell.component[m]);
          cell.component[n] = lowest;
          cell.component[m] = lowest;
        }
      }
    }
  }
  for (int n = 0; n < 8; ++n)
  {
    int fewest = 4;
    for (int m = 0; m < 8 && !(cell.elements >> n & 1); ++m)
    {
      const int steps = static_cast<int>(std::bitset<3>(static_cast<unsigned>(n ^ m)).count());
      if ((cell.elements >> m & 1) && steps < fewest)
      {
        cell.component[n] = cell.component[m];
        fewest = steps;
      }
    }
  }
  return cell;
}

unsigned CarryCells::elementsAround(const Index3& voxel) const
{
  unsigned bits = 0;
  for (int p = 0; p < 27; ++p)
  {
    const Index3 at{ voxel[0] + p % 3 - 1, voxel[1] + p / 3 % 3 - 1, voxel[2] + p / 9 - 1 };
    bits |= this->model_.isElement(at) ? 1u << p : 0;
  }
  return bits;
}

Vector3 CarryCells::meanAround(const Index3& voxel, unsigned seeds) const
{
  const unsigned elements = this->elementsAround(voxel);
  const int steps[3] = { 1, 3, 9 };
  unsigned links[3];
  for (int a = 0; a < 3; ++a)
  {
    links[a] = elements & elements >> steps[a] & notLast[a];
    for (int p = 0; p < 27 && this->model_.links; ++p)
    {
      const Index3 at{ voxel[0] + p % 3 - 1, voxel[1] + p / 3 % 3 - 1, voxel[2] + p / 9 - 1 };
      if ((links[a] >> p & 1) && !this->isLinked(at, a))
      {
        links[a] &= ~(1u << p);
      }
    }
  }
  unsigned joined = seeds & elements;
  for (unsigned before = 0; before != joined;)
  {
    before = joined;
    for (int a = 0; a < 3; ++a)
    {
      joined |= (joined & links[a]) << steps[a] | (joined >> steps[a] & links[a]);
    }
  }
  Vector3 sum{};
  int count = 0;
  for (int p = 0; p < 27; ++p)
  {
    if (joined >> p & 1)
    {
      const Vector3 u =
        this->model_.displacementAt({ voxel[0] + p % 3 - 1, voxel[1] + p / 3 % 3 - 1, voxel[2] + p / 9 - 1 });
      if (p == 13) // the voxel itself, connected around the end of a cut
      {
        return u;
      }
      for (int a = 0; a < 3; ++a)
      {
        sum[a] += u[a];
      }
      ++count;
    }
  }
  for (int a = 0; a < 3 && count > 0; ++a)
  {
    sum[a] /= count;
  }
  return sum;
}

CarryCells::Corners CarryCells::cornersOf(const Cell& cell, unsigned component) const
{
  Corners corners;
  unsigned own = 0;
  for (int n = 0; n < 8; ++n)
  {
    own |= (cell.elements >> n & 1) && cell.component[n] == component ? 1u << n : 0;
  }
  for (int n = 0; n < 8; ++n)
  {
    const Index3 corner = this->cornerAt(cell.base, n);
    if (own >> n & 1)
    {
      corners[n] = this->model_.displacementAt(corner);
      continue;
    }
    unsigned seeds = 0;
    for (int m = 0; m < 8; ++m)
    {
      const Index3 from = this->cornerAt(cell.base, m);
      seeds |=
        (own >> m & 1) << (from[0] - corner[0] + 1 + 3 * (from[1] - corner[1] + 1) + 9 * (from[2] - corner[2] + 1));
    }
    corners[n] = this->meanAround(corner, seeds);
  }
  return corners;
}

Vector3 CarryCells::interpolate(const Corners& corners, const Vector3& local, std::array<double, 9>* derivatives)
{
  Vector3 value{};
  if (derivatives)
  {
    derivatives->fill(0.0);
  }
  for (int n = 0; n < 8; ++n)
  {
    double weight[3];
    for (int a = 0; a < 3; ++a)
    {
      weight[a] = n >> a & 1 ? local[a] : 1.0 - local[a];
    }
    const double whole = weight[0] * weight[1] * weight[2];
    for (int b = 0; b < 3; ++b)
    {
      value[b] += whole * corners[n][b];
      for (int a = 0; a < 3 && derivatives; ++a)
      {
        const double others = weight[(a + 1) % 3] * weight[(a + 2) % 3];
        (*derivatives)[3 * b + a] += (n >> a & 1 ? others : -others) * corners[n][b];
      }
    }
  }
  return value;
}

bool CarryCells::invert(const Corners& corners, const Vector3& target, Vector3& local) const
{
  for (int a = 0; a < 3; ++a)
  {
    local[a] = this->model_.isFlat(a) ? 0.0 : 0.5;
  }
  for (int step = 0; step < 30; ++step)
  {
    std::array<double, 9> j;
    const Vector3 u = interpolate(corners, local, &j);
    Vector3 rest;
    double worst = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      rest[a] = local[a] + u[a] - target[a];
      j[3 * a + a] += 1.0;
      if (this->model_.isFlat(a))
      {
        rest[a] = 0.0;
        for (int b = 0; b < 3; ++b)
        {
          j[3 * a + b] = j[3 * b + a] = a == b ? 1.0 : 0.0;
        }
      }
      worst = std::max(worst, std::fabs(rest[a]));
    }
    if (worst < 1e-11)
    {
      return true;
    }
    if (!solve(j, rest))
    {
      return false;
    }
    for (int a = 0; a < 3; ++a)
    {
      local[a] -= rest[a];
      if (!(std::fabs(local[a]) < 16.0)) // diverged, or NaN
      {
        return false;
      }
    }
  }
  return false;
}

bool CarryCells::solve(const std::array<double, 9>& m, Vector3& v)
{
  const double c[3] = { m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6] };
  const double det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
  if (!(std::fabs(det) > 1e-12))
  {
    return false;
  }
  v = { (c[0] * v[0] + (m[2] * m[7] - m[1] * m[8]) * v[1] + (m[1] * m[5] - m[2] * m[4]) * v[2]) / det,
    (c[1] * v[0] + (m[0] * m[8] - m[2] * m[6]) * v[1] + (m[2] * m[3] - m[0] * m[5]) * v[2]) / det,
    (c[2] * v[0] + (m[1] * m[6] - m[0] * m[7]) * v[1] + (m[0] * m[4] - m[1] * m[3]) * v[2]) / det };
  return true;
}

}
