#pragma once

#include "Bricks.h"
#include "Types.h"

#include <functional>

namespace chainmail
{

/// Finds where the material of output voxels comes from, box by box (resample.clh and cover.cl say how). It changes no
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

  /// Some bricks of the output that are handled at once.
  struct Batch
  {
    Grid bricks;                 ///< the bricks of the whole output, each as one voxel of this grid
    Index3 firstVoxel;           ///< of the first of these bricks
    std::vector<cl_int4> firsts; ///< the first voxels of the bricks that are handled
    std::vector<int> places;     ///< for each brick of `bricks` its number in `firsts`, or -1
    std::vector<int> sources;    ///< bricks of the grid whose cells may reach them
    std::vector<int> numbers;    ///< for each brick of `bricks` its number in `sources`, or -1
    Grid cells;                  ///< the cells of the box around these bricks
    Index3 firstCell;
  };

private:
  /// Finds the offsets of all voxels of a batch, brick by brick, 3 floats each.
  const cl::Buffer& locate(const Batch& batch);

  Bricks& bricks_;
  Scratch list_{ "the list of bricks" };
  Scratch places_{ "the list of bricks" };
  Scratch firsts_{ "the list of bricks" };
  Scratch numbers_{ "the list of bricks" };
  Scratch claims_{ "resampling" };
  Scratch contested_{ "resampling" };
  Scratch again_{ "resampling" };
  Scratch offsets_{ "resampling" };
};

}
