#pragma once

namespace chainmail
{

/// What the sweeps of a relaxation are for.
enum class Range
{
  Far, ///< to propagate the displacements of handles through the tissue
  Near ///< to smooth rough errors: coarser grids have reduced the others
};

/// What each sweep of a relaxation does. The plan depends on the kind of the scene and on numbers of sweeps, not on the
/// displacements. Sweeps of a run count from 0.
class SweepPlan
{
public:
  /// While elements rotate, they do so at least in every sixth sweep (relaxrotations.cl).
  static constexpr int mostSweepsPerRotation = 6;

  /// `rotates`: whether elements rotate. `longestAxis`: of the grid [elements]; 0 while waves are under way.
  /// `firstSweep`: the number of sweeps of this relaxation that were done before the run. `iterations`: the most sweeps
  /// of the run.
  SweepPlan(Range range, bool rotates, double poissonRatio, int longestAxis, int firstSweep, int iterations);

  /// The sweep with which a round ends, of those after coarser grids (Range::Near, without rotations). `sweep`: a sweep
  /// of the round. Both count from the first sweep of this relaxation. At the end of a round roughness is removed.
  static int roundsEnd(int sweep);

  /// Whether elements rotate in sweep `n`.
  bool rotates(int n) const;

  /// Whether sweep `n` shows if elements are at rest: where elements rotate, only a sweep with rotations does.
  bool showsRest(int n) const;

  /// The over-relaxation factor of sweep `n`.
  float omega(int n) const;

  /// How many sweeps there are, after the first `n`, up to the next active-set step at fixed intervals.
  int sweepsToTimedStep(int n) const;

  /// Whether such a step follows sweep `n`.
  bool isTimedStepAfter(int n) const;

private:
  Range range_;
  bool rotates_;
  double further_; ///< see further() in SweepPlan.cpp
  int first_;
  int iterations_;
  int longest_; ///< 0 where the opening never ends: where elements rotate, waves are under way, or no coarser grids
                ///< went before
};

}
