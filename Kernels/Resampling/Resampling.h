#pragma once

#include "BrickExtents.h"
#include "TissuePart.h"
#include "Types.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

namespace chainmail
{

/// Computes where the material of output voxels comes from, box by box (resample.clh and cover.cl). It changes no
/// displacement, but may allocate memory for bricks.
class Resampling
{
public:
  /// `source`: what displaces the bricks; null where something else does.
  Resampling(Bricks& bricks, DisplacementSource* source);

  /// See Simulation::resample().
  Resampled run(const Index3& padding, std::uint64_t since, CutSurfaces cuts, const OutputDetail& detail,
    const std::function<void(double)>& checkpoint, const BoxVisitor& visit);

  /// See Simulation::exportTissue().
  void exportTissue(const Index3& padding, CutSurfaces cuts, std::uint64_t simulation,
    const std::vector<TissueReceiver>& receivers,
    const std::function<void(std::size_t n, const std::vector<char>& message)>& take);
  /// See Simulation::portions().
  std::optional<std::vector<OutputDetail>> portions(const Index3& padding, CutSurfaces cuts, const OutputDetail& part);
  /// See Simulation::sources().
  Sources sources(const Index3& padding, CutSurfaces cuts, const OutputDetail& detail);

  /// A group of output bricks that are processed together.
  struct Batch
  {
    Grid bricks;                 ///< the bricks of the whole output, each as one voxel of this grid
    Index3 firstVoxel;           ///< of the first of these bricks
    std::vector<cl_int4> firsts; ///< first voxels of the bricks in the batch
    std::vector<int> places;     ///< for each brick of `bricks` its number in `firsts`, or -1
    std::vector<int> sources;    ///< bricks of the grid whose cells may reach them
    std::vector<int> tissue;     ///< those of the batch's bricks that are in the grid
    Grid cells;                  ///< box around the cells of `sources`
    Index3 firstCell;
  };

private:
  /// What a receiver of exported tissue got last.
  struct Sent
  {
    TissueVersion version;
    std::vector<int> displaced; ///< ascending
  };

  /// The number of output voxels of a brick.
  std::size_t voxelsPerBrick() const;
  ChangeTracker::Revision look();
  void noteChanges(const OutputFrame& frame);
  bool load(const Batch& batch);
  void locateAll(const OutputFrame& frame, const std::vector<BrickExtents>& reaches,
    std::vector<std::size_t>& wanted, const std::function<void(double)>& checkpoint, const BoxVisitor& visit);
  /// Computes the offsets of all voxels of a batch, brick by brick, 3 floats each. Where cut surfaces are smooth it
  /// also computes their coverage.
  const cl::Buffer& locate(const Batch& batch);

  Bricks& bricks_;
  DisplacementSource* source_;
  bool inParts_ = false; ///< whether the source has no room for all bricks; for the last look
  ChangeTracker changes_;
  ChangeTracker::Revision first_ = 1; ///< first look with the present padding, surfaces and detail
  ChangeTracker::Revision last_ = 0;  ///< last look with these
  Index3 padding_{};
  CutSurfaces cuts_ = CutSurfaces::Stepped;
  OutputDetail detail_;
  bool covers_ = false; ///< whether voxels of this run have a coverage
  Ranges ranges_;       ///< of the last run
  RestElements rest_;   ///< of bricks that were exported
  std::map<int, Sent> sent_;
  /// For each output brick the last look at which its content may have changed.
  std::vector<ChangeTracker::Revision> changedAt_;
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
