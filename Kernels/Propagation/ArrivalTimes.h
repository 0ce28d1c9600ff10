#pragma once

#include "FixedPoint.h"
#include "Handles.h"

namespace chainmail
{

/// When the last wave to reach each element arrived there, and the number of that wave. Kept only where somebody asks.
///
/// The arrival time is the length of the shortest path of links from the probe through elements that the wave moved, as
/// a fraction of the spacing. It is known for the elements that the wave moved and for those linked to one of them.
class ArrivalTimes
{
public:
  explicit ArrivalTimes(Bricks& bricks);
  ~ArrivalTimes();

  /// Keeps the times from now on. Timestamp propagation cannot do without.
  void keep();

  /// Starts wave number `front` with the elements of a probe at time 0.
  void start(const Handle& source, int front);

  /// Finds the times of an envelope wave that has come to its end (arrivals.cl). Bricks::before must still be the state
  /// before that wave, of all bricks with a state. Other bricks may get one.
  void follow(const std::vector<const Handle*>& sources, int front, const Checkpoint& checkpoint);

  void clear();

  /// Both write whole grids, axes() interleaved values a voxel: a time of -1 and a number of 0 where no wave came.
  /// `zeroed` says that all of `out` is 0 already.
  void readTimes(float* out) const;
  void readFronts(int* out, bool zeroed) const;

  const Field& time() const { return this->time_; }
  const Field& front() const { return this->front_; }

private:
  template <typename T> void read(const Field& field, T* out) const;

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field time_;    ///< float [axis][address]
  Field front_;   ///< int [axis][address]; 0 where no wave came, and then `time` means nothing
  Field arrival_; ///< float [axis][address], see arrivals.cl
};

}
