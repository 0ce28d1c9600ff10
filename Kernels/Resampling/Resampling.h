#pragma once

#include "BrickReach.h"
#include "Types.h"

#include <cstdint>
#include <functional>

namespace chainmail
{

/// Finds where the material of output voxels comes from, box by box (resample.clh and cover.cl say how). It changes no
/// displacement, but may give memory to bricks.
class Resampling
{
public:
  explicit Resampling(Bricks& bricks);

  /// See Simulation::resample().
  Resampled run(const Index3& padding, std::uint64_t since, CutSurfaces cuts, const OutputDetail& detail,
    const std::function<void(double)>& checkpoint, const BoxVisitor& visit);

  /// Some bricks of the output that are handled at once.
  struct Batch
  {
    Grid bricks;                 ///< the bricks of the whole output, each as one voxel of this grid
    Index3 firstVoxel;           ///< of the first of these bricks
    std::vector<cl_int4> firsts; ///< the first voxels of the bricks that are handled
    std::vector<int> places;     ///< for each brick of `bricks` its number in `firsts`, or -1
    std::vector<int> sources;    ///< bricks of the grid whose cells may reach them
    Grid cells;                  ///< the cells of the box around these bricks
    Index3 firstCell;
  };

private:
  /// Output voxels of a brick.
  std::size_t voxelsPerBrick() const;
  void noteChanges(const OutputFrame& frame);
  void locateAll(const OutputFrame& frame, const std::vector<BrickReach>& reaches,
    const std::vector<std::size_t>& wanted, const std::function<void(double)>& checkpoint, const BoxVisitor& visit);
  /// Finds the offsets of all voxels of a batch, brick by brick, 3 floats each, and their coverage, where cut surfaces
  /// are smooth.
  const cl::Buffer& locate(const Batch& batch);

  Bricks& bricks_;
  Survey survey_;
  Survey::Look first_ = 1; ///< of the looks with the present padding,
  Survey::Look last_ = 0;  ///< and the last
  Index3 padding_{};
  CutSurfaces cuts_ = CutSurfaces::Stepped;
  OutputDetail detail_;
  bool covers_ = false; ///< whether voxels of this run have a coverage
  Ranges ranges_;       ///< as of the last run
  /// For each brick of the output the last look that found that it may show something else than at the look before.
  std::vector<Survey::Look> changedAt_;
  Scratch list_{ "the list of bricks" };
  Scratch places_{ "the list of bricks" };
  Scratch firsts_{ "the list of bricks" };
  Scratch claims_{ "resampling" };
  Scratch disputed_{ "resampling" };
  Scratch disputes_{ "resampling" };
  Scratch offsets_{ "resampling" };
  Scratch coverage_{ "resampling" };
  Scratch behind_{ "resampling" };
};

}
