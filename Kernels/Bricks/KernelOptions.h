#pragma once

#include "Device.h"
#include "Types.h"

#include <cstddef>
#include <string>

namespace chainmail
{

/// The -D options and the work-group sizes of kernels that include brick.clh. They depend on the device and on the size
/// of bricks.
class KernelOptions
{
public:
  /// `axes`: the number of constraints of an element, 1 or 3.
  KernelOptions(const DeviceInfo& device, const Index3& brickSize, int axes);

  /// The elements of a row that a kernel handles at once: its WIDTH. With `vectors` as many as suits the device,
  /// else 1.
  int width(bool vectors) const;
  /// The same for a kernel that benefits from the longest vectors of the device, up to a row.
  int widthOfRows() const;
  /// Work-items for one colour of a brick.
  std::size_t workItems(bool vectors) const;
  /// How many groups of workItems(true) share a brick, so that each work-item has about `elements` elements; 1 where a
  /// single work-item has a whole brick.
  std::size_t sharesOfBrick(int elements) const;

  /// The options for a WIDTH. `cuts`: whether any link may be cut. `rotations`: whether the kernel gets rotations.
  std::string defines(int width, bool cuts, bool rotations) const;

  /// Extra elements after each run of a field, see BrickStorage.
  static constexpr int skew = 272;

private:
  bool takesManyItems_;
  int floatsAtOnce_;
  Index3 size_;
  int axes_;
};

/// The best brick size for a device.
Index3 defaultBrickSize(const DeviceInfo& device);

}
