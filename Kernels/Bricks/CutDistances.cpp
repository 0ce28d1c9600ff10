#include "CutDistances.h"

#include "cutdistance.clh"

#include <algorithm>
#include <cmath>

namespace chainmail
{

void CutDistances::Brick::add(std::uint32_t local, double squared, double distance)
{
  constexpr double unitsOfSquares = 8192.0; // the square of `farthest` fits into 16 bits
  const auto square = static_cast<std::uint16_t>(std::min(std::lround(squared * unitsOfSquares), 65535L));
  const double units = distance * CUT_UNITS;
  const int rounded = static_cast<int>(std::lround(units));
  const int stored = CUT_ZERO + (rounded != 0 ? rounded : units < 0.0 ? -1 : 1);
  const auto rank = [](int of, int value) { return std::make_tuple(of, -std::abs(value - CUT_ZERO), value); };
  std::uint16_t& value = this->values_[local];
  if (value == 0 || rank(square, stored) < rank(this->squares_[local], value))
  {
    value = static_cast<std::uint16_t>(stored);
    this->squares_[local] = square;
  }
}

void CutDistances::toDevice(Context& context)
{
  std::vector<cl_int> rows(this->table_.slots(), -1);
  std::vector<std::uint16_t> distances;
  cl_int count = 0;
  for (const auto& [brick, points] : this->bricks_)
  {
    if (this->table_.slot(brick) > 0)
    {
      rows[this->table_.slot(brick)] = count++;
      distances.insert(distances.end(), points.values().begin(), points.values().end());
    }
  }
  distances.resize(std::max<std::size_t>(distances.size(), 1), 0); // a buffer cannot be empty
  this->rows_.holding(context, rows);
  this->distances_.holding(context, distances);
}

}
