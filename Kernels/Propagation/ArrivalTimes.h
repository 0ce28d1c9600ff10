#pragma once

#include "FixedPoint.h"
#include "Handles.h"

namespace chainmail
{

/// The propagation time and the id of the last wave that reached each element. Stored only on request (allocate()).
///
/// The propagation time is the length of the shortest path of links from the probe through elements that the wave
/// moved, as a fraction of the spacing. It is defined for elements that the wave moved and for those linked to one.
class ArrivalTimes
{
public:
  explicit ArrivalTimes(Bricks& bricks);
  ~ArrivalTimes();

  /// Stores the times from now on. Timestamp propagation requires them.
  void allocate();

  /// Starts the wave with id `front`, with the elements of a probe at time 0.
  void start(const Handle& source, int front);

  /// Computes the times of an envelope wave that has ended (arrivals.cl). Bricks::before() must still be the state
  /// before that wave, for all bricks with a state. Other bricks may get a state.
  void computeTimes(const std::vector<const Handle*>& sources, int front, const Checkpoint& checkpoint);

  void clear();

  /// Both write the values of a box, axes() interleaved ones an element: a time of -1 and a wave id of 0 where no wave
  /// came. `zeroed`: all of `out` is 0 already.
  void readTimes(const VoxelBox& box, float* out) const;
  void readFronts(const VoxelBox& box, int* out, bool zeroed) const;

  const Field& time() const { return this->time_; }
  const Field& front() const { return this->front_; }

private:
  template <typename T> void read(const Field& field, const VoxelBox& box, T* out) const;

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field time_;    ///< float [axis][address]
  Field front_;   ///< int [axis][address], the wave id; 0 where no wave came and the time is undefined
  Field arrival_; ///< float [axis][address], see arrivals.cl
};

}
