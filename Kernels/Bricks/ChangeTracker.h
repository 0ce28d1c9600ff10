#pragma once

#include "Bricks.h"
#include "DisplacementSource.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Detects which bricks have changed since an earlier look. It compares their content, whatever has changed it, by a
/// 64-bit hash of the displacements and cuts of each brick. Different contents have the same hash with a probability of
/// 2^-64.
class ChangeTracker
{
public:
  using Revision = std::uint64_t;

  /// `source`: what displaces the bricks; null where something else does.
  ChangeTracker(Bricks& bricks, DisplacementSource* source);

  /// Hashes all bricks. Where the source has no room for all of them, it takes its bounds, and all that may be
  /// displaced counts as changed with the source. Returns the number of this look, counted from 1.
  Revision revise();

  /// The last look that found a brick changed; 0 where all looks found it uncut and at rest.
  Revision changedAt(int brick) const { return this->changedAt_[brick]; }

  /// The bricks with displaced elements, as of the last look.
  const std::vector<int>& displaced() const { return this->displaced_; }
  /// The extents of these, in the same order.
  const std::vector<BrickExtent>& extents() const { return this->extents_; }

private:
  std::vector<BrickExtent> measure(const std::vector<int>& slots);

  Bricks& bricks_;
  DisplacementSource* source_;
  Revision look_ = 0;
  std::vector<std::uint64_t> contents_; ///< the hash of each brick, 0 where it is uncut and at rest
  std::vector<Revision> changedAt_;
  std::vector<int> displaced_;
  std::vector<BrickExtent> extents_;
  Scratch list_{ "the list of bricks" };
  Scratch result_{ "the list of bricks" };
};

}
