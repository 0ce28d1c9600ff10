#pragma once

#include <CL/cl.h>

#include <cstdint>
#include <vector>

namespace chainmail
{

/// Hashes and extent of the displacements of a brick (changetracker.cl).
struct BrickExtent
{
  cl_uint hashes[2]; ///< of its displacements
  float low[3];      ///< the smallest displacement of all places in the brick; 0 in air
  float first[3]; ///< the box of its displaced elements, first to last, counted from the brick's first corner; infinity
                  ///< to minus infinity without any. Along x it may be one element too large at either end.
  float high[3];
  float last[3];

  bool displaced() const { return this->first[0] <= this->last[0]; }
};

/// Makes displacements of bricks when they are needed, where those of all bricks may need too much memory.
class DisplacementSource
{
public:
  virtual ~DisplacementSource() = default;

  /// Displaces all bricks, where there is room for all at once. Returns whether there is.
  virtual bool displaceAll() = 0;

  // Where there is no room:

  /// Changes with the displacements.
  virtual std::uint64_t version() const = 0;
  /// The bricks that may be displaced, ascending, and bounds of their extents.
  virtual const std::vector<int>& displaced() = 0;
  virtual const std::vector<BrickExtent>& extents() = 0;
  /// The number of bricks that may be displaced at once.
  virtual std::size_t room() const = 0;
  /// Displaces these bricks (ascending, at most room()), and makes room for them: no other brick has tissue or a state
  /// then.
  virtual void displace(const std::vector<int>& bricks) = 0;
};

}
