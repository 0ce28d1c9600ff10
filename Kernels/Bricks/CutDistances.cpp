#include "CutDistances.h"

#include "cutdistance.clh"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace chainmail
{

void CutDistances::beginSurface()
{
  this->surface_ = this->surface_ % CUT_SURFACES + 1;
}

void CutDistances::set(int i, int j, int k, double distance)
{
  std::vector<std::uint16_t>& values = this->values_[this->table_.brickAt(i, j, k)];
  values.resize(this->table_.elementsPerBrick(), 0);
  std::uint16_t& value = values[this->table_.local(i, j, k)];
  const double most = CUT_ZERO - 1;
  int units = static_cast<int>(std::lround(std::min(std::max(distance * CUT_UNITS, -most), most)));
  units = units == 0 ? (distance < 0.0 ? -1 : 1) : units;
  const int before = value % CUT_SURFACE - CUT_ZERO;
  if (value == 0 || std::abs(units) <= std::abs(before))
  {
    value = static_cast<std::uint16_t>(this->surface_ * CUT_SURFACE + CUT_ZERO + units);
  }
}

void CutDistances::clear()
{
  this->values_.clear();
  this->surface_ = 0;
}

void CutDistances::toDevice(Context& context)
{
  std::vector<cl_int> rows(this->table_.slots(), -1);
  std::vector<std::uint16_t> distances;
  cl_int count = 0;
  for (const auto& [brick, values] : this->values_)
  {
    if (this->table_.slot(brick) > 0)
    {
      rows[this->table_.slot(brick)] = count++;
      distances.insert(distances.end(), values.begin(), values.end());
    }
  }
  distances.resize(std::max<std::size_t>(distances.size(), 1), 0); // there is no buffer of no bytes
  this->rows_.holding(context, rows);
  this->distances_.holding(context, distances);
}

}
