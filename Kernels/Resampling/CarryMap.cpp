#include "CarryMap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

// How far outside a cell, and a component's share of it, a position may lie [voxels]: within `strict` the hit is exact,
// within `loose` it ranks lower. This closes gaps from rounding. It also closes the narrow gaps between cells whose
// common corner in air has a different displacement in each.
constexpr double strict = 1e-9;
constexpr double loose = 1e-4;

bool isZero(const Vector3& u)
{
  return u[0] == 0.0 && u[1] == 0.0 && u[2] == 0.0;
}

int nearestCorner(const Vector3& local)
{
  return (local[0] > 0.5 ? 1 : 0) | (local[1] > 0.5 ? 2 : 0) | (local[2] > 0.5 ? 4 : 0);
}

Vector3 plus(const Vector3& a, const Vector3& b)
{
  return { a[0] + b[0], a[1] + b[1], a[2] + b[2] };
}

Vector3 minus(const Vector3& a, const Vector3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

}

CarryMap::CarryMap(const RestModel& model)
  : model_(model)
  , cells_(model)
{
}

const CarryAir& CarryMap::air() const
{
  std::call_once(this->airMade_, [this] { this->air_ = std::make_unique<CarryAir>(this->model_); });
  return *this->air_;
}

const CarryTree& CarryMap::tree() const
{
  std::call_once(this->treeMade_, [this] { this->tree_ = std::make_unique<CarryTree>(this->model_); });
  return *this->tree_;
}

/// The nearest position in the box of voxel centres.
Vector3 CarryMap::inside(const Vector3& place) const
{
  Vector3 inside;
  for (int a = 0; a < 3; ++a)
  {
    inside[a] = std::min(std::max(place[a], 0.0), this->model_.grid.size[a] - 1.0);
  }
  return inside;
}

Index3 CarryMap::cellOf(const Vector3& inside) const
{
  Index3 base;
  for (int a = 0; a < 3; ++a)
  {
    base[a] = std::max(std::min(static_cast<int>(inside[a]), this->model_.grid.size[a] - 2), 0);
  }
  return base;
}

Index3 CarryMap::nearestVoxel(const Vector3& place) const
{
  const Vector3 at = this->inside(place);
  return { static_cast<int>(at[0] + 0.5), static_cast<int>(at[1] + 0.5), static_cast<int>(at[2] + 0.5) };
}

/// Whether a position lies in no voxel of the grid. A flat grid is unbounded across its plane.
bool CarryMap::isOutside(const Vector3& place) const
{
  bool is = false;
  for (int a = 0; a < 3; ++a)
  {
    is = is || (!this->model_.isFlat(a) && !(place[a] >= -0.5 && place[a] <= this->model_.grid.size[a] - 0.5));
  }
  return is;
}

Vector3 CarryMap::forward(const Vector3& rest, std::array<double, 9>* derivatives) const
{
  const Vector3 now = plus(rest, this->displacementAt(rest, derivatives));
  for (int a = 0; a < 3 && derivatives; ++a)
  {
    (*derivatives)[3 * a + a] += 1.0;
  }
  return now;
}

Vector3 CarryMap::displacementAt(const Vector3& rest, std::array<double, 9>* derivatives) const
{
  const Vector3 place = this->inside(rest);
  const CarryCells::Cell cell = this->cells_.cellAt(this->cellOf(place));
  const Vector3 local{ place[0] - cell.base[0], place[1] - cell.base[1], place[2] - cell.base[2] };
  const CarryCells::Corners corners = cell.elements == 0
                                        ? this->cornersInAir(cell.base, place)
                                        : this->cells_.cornersOf(cell, cell.component[nearestCorner(local)]);
  const Vector3 u = CarryCells::interpolate(corners, local, derivatives);
  for (int n = 0; n < 9 && derivatives; ++n)
  {
    const int a = n % 3;
    if (this->model_.isFlat(a) || place[a] != rest[a])
    {
      (*derivatives)[n] = 0.0;
    }
  }
  return u;
}

/// The corners of a cell without elements. Air with elements around it moves with those on the side of a cut that is
/// nearest to the position. Other air takes the displacement of CarryAir.
CarryCells::Corners CarryMap::cornersInAir(const Index3& base, const Vector3& place) const
{
  const auto squareTo = [&](const Index3& at)
  {
    double square = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const double away = (at[a] - place[a]) * this->model_.grid.spacing[a];
      square += away * away;
    }
    return square;
  };
  std::array<unsigned, 8> around;
  std::array<int, 8> nearestOf{}; // the bit of the element around a corner that is nearest to the place
  double least = std::numeric_limits<double>::infinity();
  Index3 nearest{};
  for (int n = 0; n < 8; ++n)
  {
    const Index3 corner = this->cells_.cornerAt(base, n);
    around[n] = this->cells_.elementsAround(corner);
    double leastHere = std::numeric_limits<double>::infinity();
    for (int p = 0; p < 27 && around[n] != 0; ++p)
    {
      const Index3 at{ corner[0] + p % 3 - 1, corner[1] + p / 3 % 3 - 1, corner[2] + p / 9 - 1 };
      const double square = around[n] >> p & 1 ? squareTo(at) : std::numeric_limits<double>::infinity();
      if (square < leastHere)
      {
        leastHere = square;
        nearestOf[n] = p;
      }
      if (square < least)
      {
        least = square;
        nearest = at;
      }
    }
  }
  CarryCells::Corners corners;
  for (int n = 0; n < 8; ++n)
  {
    const Index3 corner = this->cells_.cornerAt(base, n);
    if (around[n] == 0)
    {
      corners[n] = this->air().at(corner);
      continue;
    }
    const Index3 from = { nearest[0] - corner[0] + 1, nearest[1] - corner[1] + 1, nearest[2] - corner[2] + 1 };
    const bool hasNearest = std::all_of(from.begin(), from.end(), [](int d) { return d >= 0 && d < 3; });
    corners[n] =
      this->cells_.meanAround(corner, 1u << (hasNearest ? from[0] + 3 * from[1] + 9 * from[2] : nearestOf[n]));
  }
  return corners;
}

/// Replaces `hit` by a component of a cell, if it covers the position and has priority. Tissue has priority over border
/// air, then the lowest cell, as in resampling.
void CarryMap::cover(const CarryCells::Cell& cell, unsigned component, const CarryCells::Corners& corners,
  const Vector3& now, bool carvedIsGone, Hit& hit) const
{
  const Vector3 target = minus(now, { 1.0 * cell.base[0], 1.0 * cell.base[1], 1.0 * cell.base[2] });
  bool rests = true, mayCover = true;
  for (int a = 0; a < 3; ++a)
  {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int n = 0; n < 8; ++n)
    {
      rests = rests && corners[n][a] == 0.0;
      low = std::min(low, corners[n][a] + (n >> a & 1));
      high = std::max(high, corners[n][a] + (n >> a & 1));
    }
    mayCover = mayCover && (this->model_.isFlat(a) || (target[a] >= low - loose && target[a] <= high + loose));
  }
  Vector3 local;
  if (rests || !mayCover || !this->cells_.invert(corners, target, local))
  {
    return;
  }
  double beyond = 0.0;
  for (int a = 0; a < 3; ++a)
  {
    beyond = std::max({ beyond, -local[a], local[a] - 1.0 });
  }
  const int nearest = nearestCorner(local);
  const auto isShare = [&](int corner)
  { return cell.component[corner] == component && !(carvedIsGone && (cell.carved >> corner & 1)); };
  bool isNearShare = false;
  for (int n = 0; n < 8; ++n)
  {
    bool near = isShare(n);
    for (int a = 0; a < 3; ++a)
    {
      near = near && std::fabs(local[a] - (n >> a & 1)) <= 0.5 + loose;
    }
    isNearShare = isNearShare || near;
  }
  if (beyond > loose || !isNearShare)
  {
    return;
  }
  const bool isStrict = beyond <= strict && isShare(nearest);
  const int rank = (cell.elements >> nearest & 1 ? Hit::tissue : Hit::border) + (isStrict ? 0 : 1);
  const std::size_t key = 8 * this->model_.grid.at(cell.base[0], cell.base[1], cell.base[2]) + component;
  if (rank < hit.rank || (rank == hit.rank && key < hit.key))
  {
    hit.rank = rank;
    hit.key = key;
    const Vector3 u = CarryCells::interpolate(corners, local);
    for (int a = 0; a < 3; ++a)
    {
      hit.rest[a] = this->model_.isFlat(a) ? now[a] - u[a] : cell.base[a] + local[a];
    }
  }
}

/// Tries all components of a cell as in cover().
void CarryMap::coverCell(const Index3& base, const Vector3& now, bool carvedIsGone, Hit& hit) const
{
  const CarryCells::Cell cell = this->cells_.cellAt(base);
  for (unsigned component = 0; component < 8; ++component)
  {
    if (cell.hasOwn(component))
    {
      this->cover(cell, component, this->cells_.cornersOf(cell, component), now, carvedIsGone, hit);
    }
  }
}

/// Tries the eight cells of a whole leaf, which share their 27 corners.
void CarryMap::coverWholeLeaf(const Index3& first, const Vector3& now, bool carvedIsGone, Hit& hit) const
{
  std::array<Vector3, 27> displacements;
  for (int p = 0; p < 27; ++p)
  {
    displacements[p] = this->model_.displacementAt({ first[0] + p % 3, first[1] + p / 3 % 3, first[2] + p / 9 });
  }
  CarryCells::Cell cell;
  cell.elements = 255;
  cell.component.fill(0);
  for (int c = 0; c < 8; ++c)
  {
    cell.base = { first[0] + (c & 1), first[1] + (c >> 1 & 1), first[2] + (c >> 2) };
    CarryCells::Corners corners;
    for (int n = 0; n < 8; ++n)
    {
      corners[n] = displacements[(c & 1) + (n & 1) + 3 * ((c >> 1 & 1) + (n >> 1 & 1)) + 9 * ((c >> 2) + (n >> 2))];
    }
    this->cover(cell, 0, corners, now, carvedIsGone, hit);
  }
}

/// The material that covers a position now. The priorities are: moved tissue, tissue at rest, border of moved tissue,
/// border of tissue at rest.
CarryMap::Hit CarryMap::find(const Vector3& now, bool carvedIsGone) const
{
  Hit hit;
  this->tree().visitMovedAt(now,
    [&](const Index3& first, bool isWhole)
    {
      if (isWhole)
      {
        this->coverWholeLeaf(first, now, carvedIsGone, hit);
        return;
      }
      for (int n = 0; n < 8; ++n)
      {
        Index3 base;
        bool isCell = true;
        for (int a = 0; a < 3; ++a)
        {
          base[a] = first[a] + (n >> a & 1);
          isCell = isCell && base[a] <= std::max(this->model_.grid.size[a] - 2, 0);
        }
        if (isCell)
        {
          this->coverCell(base, now, carvedIsGone, hit);
        }
      }
    });
  if (hit.rank == Hit::tissue || this->isOutside(now))
  {
    return hit;
  }
  const Vector3 place = this->inside(now);
  const CarryCells::Cell cell = this->cells_.cellAt(this->cellOf(place));
  const int nearest = nearestCorner({ place[0] - cell.base[0], place[1] - cell.base[1], place[2] - cell.base[2] });
  if (cell.elements == 0 || (carvedIsGone && (cell.carved >> nearest & 1)))
  {
    return hit;
  }
  const CarryCells::Corners corners = this->cells_.cornersOf(cell, cell.component[nearest]);
  const int rank = (cell.elements >> nearest & 1 ? Hit::tissue : Hit::border) + Hit::atRest;
  if (rank < hit.rank && std::all_of(corners.begin(), corners.end(), isZero))
  {
    hit.rank = rank;
    hit.rest = now;
  }
  return hit;
}

/// Solves forward(rest) = now by Newton's method, starting from `rest`. Returns whether it converged.
bool CarryMap::solve(const Vector3& now, Vector3& rest) const
{
  Vector3 place = rest;
  for (int step = 0; step < 40; ++step)
  {
    std::array<double, 9> derivatives;
    Vector3 away = minus(this->forward(place, &derivatives), now);
    const double worst = std::max({ std::fabs(away[0]), std::fabs(away[1]), std::fabs(away[2]) });
    if (worst < 1e-9)
    {
      rest = place;
      return true;
    }
    if (!(worst < 1e6) || !CarryCells::solve(derivatives, away))
    {
      return false;
    }
    place = minus(place, away);
  }
  return false;
}

Vector3 CarryMap::backward(const Vector3& now) const
{
  const Hit hit = this->find(now, false);
  Index3 element;
  if (hit.rank != Hit::none)
  {
    return hit.rest;
  }
  if (!this->tree().findNearest(now, element))
  {
    return now;
  }
  const Vector3 along = minus(now, this->model_.displacementAt(element));
  Vector3 rest = along;
  if (this->solve(now, rest))
  {
    return rest;
  }
  rest = now;
  return this->solve(now, rest) ? rest : along;
}

/// An image of a single slice ignores displacements across it.
CarryMap::Shown CarryMap::materialOf(const Vector3& place, Vector3 from) const
{
  for (int a = 0; a < 3; ++a)
  {
    from[a] = this->model_.isFlat(a) ? place[a] : from[a];
  }
  return { Shown::What::Material, from };
}

CarryMap::Shown CarryMap::shownNow(const Vector3& now) const
{
  const Hit hit = this->find(now, true);
  if (hit.rank != Hit::none)
  {
    return hit.rests() ? Shown{} : this->materialOf(now, hit.rest);
  }
  if (this->isOutside(now))
  {
    return {};
  }
  const Index3 voxel = this->nearestVoxel(now);
  if (this->model_.isCarved(voxel))
  {
    return { Shown::What::Nothing, {} };
  }
  if (this->model_.isElement(voxel))
  {
    return isZero(this->model_.displacementAt(voxel)) ? Shown{} : Shown{ Shown::What::Nothing, {} };
  }
  // Air beside tissue, displaced by less than a voxel on each axis, takes its scalars along, so no seam opens there.
  const Vector3 u = this->cells_.elementsAround(voxel) != 0 ? this->displacementAt(now, nullptr) : Vector3{};
  if (isZero(u))
  {
    return {};
  }
  const bool isNear = std::all_of(u.begin(), u.end(), [](double d) { return std::fabs(d) < 1.0; });
  return isNear ? this->materialOf(now, minus(now, u)) : Shown{ Shown::What::Nothing, {} };
}

CarryMap::Shown CarryMap::shownAtRest(const Vector3& rest) const
{
  const Index3 voxel = this->nearestVoxel(rest);
  if (!this->isOutside(rest))
  {
    if (this->model_.isCarved(voxel))
    {
      return { Shown::What::Nothing, {} };
    }
    if (this->cells_.elementsAround(voxel) != 0)
    {
      const Vector3 u = this->displacementAt(rest, nullptr);
      return isZero(u) ? Shown{} : this->materialOf(rest, plus(rest, u));
    }
  }
  // Air that moved tissue covers now is air again at rest.
  return this->find(rest, true).isMovedTissue() ? Shown{ Shown::What::Nothing, {} } : Shown{};
}

}
