#pragma once

#include "Bricks.h"
#include "Types.h"

#include <functional>

namespace chainmail
{

/// Finds where the material of output voxels comes from, box by box (resample.clh says how). It changes no
/// displacement, but may give memory to bricks.
class Resampling
{
public:
  explicit Resampling(Bricks& bricks)
    : bricks_(bricks)
  {
  }

  void run(const Index3& padding, const std::function<void(double)>& checkpoint,
    const std::function<void(const ResampledBox&)>& visit);

private:
  Bricks& bricks_;
  Scratch list_{ "the list of bricks" };
  Scratch places_{ "the list of bricks" };
  Scratch firsts_{ "the list of bricks" };
};

}
