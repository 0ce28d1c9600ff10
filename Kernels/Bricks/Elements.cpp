#include "Elements.h"

#include <algorithm>

namespace chainmail
{

Elements::Elements(Bricks& bricks, const std::vector<std::size_t>& voxels)
  : bricks_(&bricks)
{
  this->addresses_.reserve(voxels.size());
  for (const std::size_t voxel : voxels)
  {
    this->add(voxel);
  }
}

void Elements::setRotations(const std::vector<float>& values) const
{
  Rotations& rotations = *this->bricks_->rotations_;
  this->set(rotations.spin, values);
  rotations.any = rotations.any || std::any_of(values.begin(), values.end(), [](float value) { return value != 0.0f; });
}

}
