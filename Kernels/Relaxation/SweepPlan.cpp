#include "SweepPlan.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

/// Whether elements rotate in a sweep (relaxrotations.cl): in every third sweep at first, later in every sixth, when
/// displacements hardly change between sweeps. After coarser grids (Range::Near) the remaining error is mostly in the
/// rotations (CoarseToFine), so the first period lasts longer. There the first sweep has no rotations: displacements
/// are still rough, and rotations that followed them would be incompatible with each other.
bool rotatesIn(Range range, int sweep)
{
  const int first = range == Range::Far ? 0 : 1;
  const int opening = range == Range::Far ? 12 : 24;
  return sweep % (sweep <= opening ? 3 : SweepPlan::mostSweepsPerRotation) == first;
}

/// The over-relaxation factors that farOmega() and nearOmega() approach in the opening sweeps.
constexpr double finalOmega = 1.9; // = 2 / (1 + sqrt(1 - rho2))
constexpr double finalNearOmega = 1.93;

/// The divisor of 2 / omega - 1 where tissue resists volumetric strain. There the diagonal of an element exceeds the
/// weights of its links, and errors decay more slowly. Measured on pulled and dragged blocks at Poisson's ratios 0.3
/// and 0.45; a larger divisor gains nothing.
double furtherFor(double poissonRatio)
{
  const double weight = 1.0 + 0.5 * poissonRatio / (1.0 - 2.0 * poissonRatio); // diagonal / weights of links
  return std::min(5.0, weight * std::sqrt(weight));
}

/// Divides 2 / omega - 1 by `times`, which brings the factor closer to 2.
double further(double omega, double times)
{
  return times == 1.0 ? omega : 2.0 / (1.0 + (2.0 / omega - 1.0) / times);
}

/// The over-relaxation factor of a Range::Far sweep, the Chebyshev semi-iterative sequence (G. Golub and R. Varga,
/// Numerische Mathematik 3, 1961):
///
///   omega(0) = 1,   omega(1) = 1 / (1 - rho2 / 2),   omega(s) = 1 / (1 - rho2 omega(s - 1) / 4) for s > 1.
///
/// A factor of 1 is best for the first sweep, in which the energy falls most. The second factor is almost 2, and from
/// there the sequence falls to further(finalOmega, times).
double farOmega(int sweep, double times)
{
  const double last = 2.0 / further(finalOmega, times) - 1.0;
  const double rho2 = 1.0 - last * last;
  double omega = 1.0;
  for (int s = 0; s < sweep && s < 200; ++s)
  {
    omega = s == 0 ? 1.0 / (1.0 - rho2 / 2.0) : 1.0 / (1.0 - rho2 * omega / 4.0);
  }
  return omega;
}

/// The over-relaxation factor of a Range::Near sweep. With a factor near 2, rough displacements stay rough for tens of
/// sweeps. For an error of length L [elements] the best factor is 2 / (1 + sin(pi / L)). Every sweep lengthens the
/// remaining error by about 2 pi, so L = 2 pi (sweep + 1) and omega = 2 / (1 + 0.5 / (sweep + 1)). In thin tissue,
/// which coarser grids do not resolve, errors are long. So the factor ends a little above finalOmega.
double nearOmega(int sweep, double times)
{
  return further(std::min(finalNearOmega, 2.0 / (1.0 + 0.5 / (sweep + 1))), times);
}

/// The number of opening sweeps after coarser grids, in which nearOmega() or rotatingOmega() applies.
constexpr int openingSweeps = 20;

/// After the opening there are active-set steps at fixed intervals of this many sweeps, because some tissue keeps
/// moving long after blocked chains elsewhere have stopped. A group moves about as far per step as an element does per
/// sweep, so seldom steps leave tissue that a handle pulls taut far from the optimum. But a step takes as long as one
/// or two sweeps: with steps every second sweep long pieces of taut tissue end 4 to 13 times nearer after 200 sweeps
/// than with this interval, and a pull in a CT of the heart, where it gains nothing, takes 1.4 times as long.
constexpr int sweepsPerTimedStep = 10;

/// The first round after the opening has this many sweeps, each further one twice as many as the one before.
constexpr int firstRound = 16;

/// The over-relaxation factor of a sweep after the opening, when the remaining errors are long. `longest`: the longest
/// axis of the grid [elements]. A large part of tissue that hangs on few links returns slowly: like an error of length
/// L = 2 timesAsLong `longest`, for which the best factor (nearOmega()) is near 2. Such a factor leaves roughness,
/// which a smaller one removes. So sweeps come in rounds, in which the factor falls to finalNearOmega:
///
///   omega = 2 / (1 + fall / leftInRound),   finalNearOmega <= omega <= longestOmega, the best factor for L.
///
/// The last round ends with the last sweep requested. `left`: the number of sweeps still to come, including this one.
double lateOmega(int sweep, int left, int longest)
{
  constexpr double fall = 0.1;
  constexpr double timesAsLong = 3.0;
  constexpr double pi = 3.14159265358979323846;
  const int leftInRound = std::min(SweepPlan::roundsEnd(sweep) - sweep, left);
  const double longestOmega = 2.0 / (1.0 + std::sin(pi / (2.0 * timesAsLong * std::max(longest, 1))));
  return std::max(finalNearOmega, std::min(longestOmega, 2.0 / (1.0 + fall / leftInRound)));
}

/// The over-relaxation factor of a sweep after coarser grids where elements rotate. Coarser grids leave incompatible
/// rotations behind and, with them, long errors. The first sweeps (`smoothing`) remove roughness; the rest of the
/// opening follows the sequence of farOmega(). In the last sweeps the bound 2 / (1 + fall / left) removes roughness
/// again. `left`: the number of sweeps still to come, including this one.
double rotatingOmega(int sweep, int left, double times)
{
  constexpr int smoothing = 4;
  constexpr double fall = 0.08;
  if (sweep < smoothing)
  {
    return nearOmega(sweep, times);
  }
  const double omega = sweep < openingSweeps ? farOmega(sweep - smoothing, times) : nearOmega(sweep, times);
  return std::min(omega, further(2.0 / (1.0 + fall / left), times));
}

}

SweepPlan::SweepPlan(Range range, bool rotates, double poissonRatio, int longestAxis, int firstSweep, int iterations)
  : range_(range)
  , rotates_(rotates)
  , further_(furtherFor(poissonRatio))
  , first_(firstSweep)
  , iterations_(iterations)
  , longest_(range == Range::Far || rotates ? 0 : longestAxis)
{
}

int SweepPlan::roundsEnd(int sweep)
{
  int end = openingSweeps;
  for (int round = firstRound; end <= sweep; round *= 2)
  {
    end += round;
  }
  return end;
}

bool SweepPlan::rotates(int n) const
{
  return this->rotates_ && rotatesIn(this->range_, this->first_ + n);
}

bool SweepPlan::showsRest(int n) const
{
  return !this->rotates_ || this->rotates(n);
}

float SweepPlan::omega(int n) const
{
  const int sweep = this->first_ + n;
  const int left = this->iterations_ - n;
  const double omega = this->longest_ > 0 && sweep >= openingSweeps ? lateOmega(sweep, left, this->longest_)
                       : this->range_ == Range::Far                 ? farOmega(sweep, this->further_)
                       : this->rotates_                             ? rotatingOmega(sweep, left, this->further_)
                                                                    : nearOmega(sweep, this->further_);
  return static_cast<float>(omega);
}

int SweepPlan::sweepsToTimedStep(int n) const
{
  const int sweep = this->first_ + n;
  const int before = std::max(sweep, openingSweeps); // the next step comes after that sweep
  return this->longest_ > 0 ? before - before % sweepsPerTimedStep + sweepsPerTimedStep - sweep
                            : std::numeric_limits<int>::max();
}

bool SweepPlan::isTimedStepAfter(int n) const
{
  const int sweep = this->first_ + n + 1;
  return this->longest_ > 0 && sweep > openingSweeps && sweep % sweepsPerTimedStep == 0;
}

}
