#pragma once

#include "FixedPoint.h"
#include "Handles.h"

namespace chainmail
{

/// When the last wave came to each element, and its number. Kept only where somebody wants to know.
///
/// The time is the length of the shortest path of links from the probe through elements that the wave moved, in
/// fractions of the spacing. It is known where the wave moved an element, and for those linked to one.
class ArrivalTimes
{
public:
  explicit ArrivalTimes(Bricks& bricks);
  ~ArrivalTimes();

  /// From now on; Timestamp needs it.
  void keep();

  /// Puts the elements of a probe at time 0 of a wave.
  void start(const Handle& source, int front);

  /// The times of an envelope wave that has come to its end (arrivals.cl): Bricks::before is the state in front of it.
  void follow(const std::vector<const Handle*>& sources, int front, const Checkpoint& checkpoint);

  void clear();

  /// Whole grids, axes() interleaved values a voxel: -1 and 0 where no wave came. `zeroed`: all of `out` is 0 already.
  void readTimes(float* out) const;
  void readFronts(int* out, bool zeroed) const;

  const Field& time() const { return this->time_; }
  const Field& front() const { return this->front_; }

private:
  template <typename T> void read(const Field& field, T* out) const;

  Bricks& bricks_;
  FixedPoint fixedPoint_;
  Field time_;    ///< float [axis][address]
  Field front_;   ///< int [axis][address], 0: no wave came, `time` means nothing
  Field arrival_; ///< float [axis][address], see arrivals.cl
};

}
