#include "KernelOptions.h"

#include <algorithm>

namespace chainmail
{

Index3 defaultBrickSize(const DeviceInfo& device)
{
  // CPUs: a vector of 16 or two of 8 for each row and colour, and bricks that fit the second-level cache. GPUs: two
  // elements of a colour for each of 256 work-items.
  return device.takesManyItems() ? Index3{ 16, 8, 8 } : Index3{ 32, 8, 8 };
}

KernelOptions::KernelOptions(const DeviceInfo& device, const Index3& brickSize, int axes)
  : takesManyItems_(device.takesManyItems())
  , floatsAtOnce_(device.floatsAtOnce)
  , size_(brickSize)
  , axes_(axes)
{
}

int KernelOptions::width(bool vectors) const
{
  return vectors && !this->takesManyItems_ ? std::min(8, this->size_[0] / 2) : 1;
}

int KernelOptions::widthOfRows() const
{
  const int longest = this->floatsAtOnce_ < 16 ? this->width(true) : 16;
  return this->takesManyItems_ ? 1 : std::min(longest, this->size_[0] / 2);
}

std::size_t KernelOptions::workItems(bool vectors) const
{
  if (vectors && !this->takesManyItems_)
  {
    return 1; // vectors are wide enough; a single work-item has all registers and needs neither atomics nor barriers
  }
  // 256 fits the local memory that measure.cl needs and the limits of all usual devices.
  const int elements = this->size_[0] * this->size_[1] * this->size_[2];
  return std::min(256, elements / 2 / this->width(vectors));
}

std::size_t KernelOptions::sharesOfBrick(int elements) const
{
  const int all = this->size_[0] * this->size_[1] * this->size_[2];
  return this->takesManyItems_ ? std::max(1, all / (elements * static_cast<int>(this->workItems(true)))) : 1;
}

std::string KernelOptions::defines(int width, bool cuts, bool rotations) const
{
  return "-DBX=" + std::to_string(this->size_[0]) + " -DBY=" + std::to_string(this->size_[1]) +
         " -DBZ=" + std::to_string(this->size_[2]) + " -DWIDTH=" + std::to_string(width) +
         " -DAXES=" + std::to_string(this->axes_) + " -DSKEW=" + std::to_string(skew) + (cuts ? " -DCUTS" : "") +
         (rotations ? " -DROTATIONS" : "");
}

}
