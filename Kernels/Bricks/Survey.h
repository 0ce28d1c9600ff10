#pragma once

#include "Bricks.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// What is known of a brick with displaced elements (survey.cl).
struct BrickExtent
{
  cl_uint hashes[2]; ///< of its displacements
  float low[3];      ///< the smallest displacement, or 0
  float first[3]; ///< the box of its displaced elements, from its first corner on; infinity to minus infinity without
                  ///< any. One more may be counted in along x.
  float high[3];
  float last[3];

  bool displaced() const { return this->first[0] <= this->last[0]; }
};

/// Tells which bricks are other than at an earlier look. It goes by what they hold, whoever changed it: 64 bits stand
/// for the displacements and cuts of a brick, and what differs has the same bits with a chance of 2^-64.
class Survey
{
public:
  using Look = std::uint64_t;

  explicit Survey(Bricks& bricks);

  /// Looks at all bricks. Returns the number of the look, counted from 1.
  Look look();

  /// The last look that found a brick changed; 0 where all looks found it whole and at rest.
  Look changedAt(int brick) const { return this->changedAt_[brick]; }

  /// The bricks with displaced elements, as of the last look.
  const std::vector<int>& displaced() const { return this->displaced_; }
  /// The extents of these, in the same order.
  const std::vector<BrickExtent>& extents() const { return this->extents_; }

private:
  std::vector<BrickExtent> measure(const std::vector<int>& slots);

  Bricks& bricks_;
  Look look_ = 0;
  std::vector<std::uint64_t> contents_; ///< of each brick, 0 where it is whole and at rest
  std::vector<Look> changedAt_;
  std::vector<int> displaced_;
  std::vector<BrickExtent> extents_;
  Scratch list_{ "the list of bricks" };
  Scratch result_{ "the list of bricks" };
};

}
