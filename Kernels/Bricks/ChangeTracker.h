#pragma once

#include "Bricks.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Hashes and extent of the displacements of a brick (changetracker.cl).
struct BrickExtent
{
  cl_uint hashes[2]; ///< of its displacements
  float low[3];      ///< the smallest displacement, or 0
  float first[3]; ///< the box of its displaced elements, first to last, counted from the brick's first corner; infinity
                  ///< to minus infinity without any. Along x it may be one element too large at either end.
  float high[3];
  float last[3];

  bool displaced() const { return this->first[0] <= this->last[0]; }
};

/// Detects which bricks have changed since an earlier look. It compares their content, whatever has changed it, by a
/// 64-bit hash of the displacements and cuts of each brick. Different contents have the same hash with a probability of
/// 2^-64.
class ChangeTracker
{
public:
  using Revision = std::uint64_t;

  explicit ChangeTracker(Bricks& bricks);

  /// Hashes all bricks. Returns the number of this look, counted from 1.
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
  Revision look_ = 0;
  std::vector<std::uint64_t> contents_; ///< the hash of each brick, 0 where it is uncut and at rest
  std::vector<Revision> changedAt_;
  std::vector<int> displaced_;
  std::vector<BrickExtent> extents_;
  Scratch list_{ "the list of bricks" };
  Scratch result_{ "the list of bricks" };
};

}
