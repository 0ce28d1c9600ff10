#include "Relaxation.h"

#include "ActiveConstraints.h"
#include "StillResidual.h"
#include "sweepaccount.clh"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

/// A sweep in which no element moves further than restingMove [fractions of the spacing] has come to rest: at the
/// optimum, or because chains of links at their limits block each other. Then an active-set step moves blocked groups
/// (moveBlockedGroups). Between two such steps there are at least sweepsPerGroupTurn sweeps. Each step at rest that
/// moves nothing doubles this number. In any case there is a step before a relaxation counts as converged.
constexpr float restingMove = 1e-3f;
constexpr int sweepsPerGroupTurn = 8;
constexpr int mostSweepsPerGroupTurn = 1 << 20; // every relaxation of tissue at rest doubles the number

/// In large scenes some tissue keeps moving long after blocked chains elsewhere have stopped. So there are also
/// active-set steps at fixed intervals of this many sweeps, except after the first interval.
constexpr int sweepsPerTimedGroupTurn = 30;

/// Whether elements rotate in a sweep (turn.cl): in every third sweep at first, later in every sixth, when
/// displacements hardly change between sweeps. After coarser grids (Reach::Near) the remaining error is mostly in the
/// rotations (CoarseToFine), so the first period lasts longer. There the first sweep has no rotations: displacements
/// are still rough, and rotations that followed them would be incompatible with each other.
constexpr int mostSweepsPerRotation = 6;
bool turnsIn(Reach reach, int sweep)
{
  const int first = reach == Reach::Far ? 0 : 1;
  const int opening = reach == Reach::Far ? 12 : 24;
  return sweep % (sweep <= opening ? 3 : mostSweepsPerRotation) == first;
}

/// Sweeps in one batch of launches.
constexpr int sweepsPerBatch = 8;

/// The same where a batch is one launch, whose sweeps take less time than reading their results.
constexpr int sweepsPerLaunch = 32;

/// In grids with at most this many elements a sweep takes about as long as launching its passes.
constexpr std::size_t fewElements = 1 << 15;

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

/// The over-relaxation factor of a Reach::Far sweep, the Chebyshev semi-iterative sequence (G. Golub and R. Varga,
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

/// The over-relaxation factor of a Reach::Near sweep. With a factor near 2, rough displacements stay rough for tens of
/// sweeps. For an error of length L [elements] the best factor is 2 / (1 + sin(pi / L)). Every sweep lengthens the
/// remaining error by about 2 pi, so L = 2 pi (sweep + 1) and omega = 2 / (1 + 0.5 / (sweep + 1)). In thin tissue,
/// which coarser grids do not resolve, errors are long. So the factor ends a little above finalOmega.
double nearOmega(int sweep, double times)
{
  return further(std::min(finalNearOmega, 2.0 / (1.0 + 0.5 / (sweep + 1))), times);
}

/// The number of opening sweeps after coarser grids, in which nearOmega() or turningOmega() applies.
constexpr int openingSweeps = 20;

/// The over-relaxation factor of a sweep after the opening, when the remaining errors are long. `longest`: the longest
/// axis of the grid [elements]. A large part of tissue that hangs on few links returns slowly: like an error of length
/// L = 2 timesAsLong `longest`, for which the best factor (nearOmega()) is near 2. Such a factor leaves roughness,
/// which a smaller one removes. So sweeps come in rounds, in which the factor falls to finalNearOmega:
///
///   omega = 2 / (1 + fall / leftInRound),   finalNearOmega <= omega <= longestOmega, the best factor for L.
///
/// The rounds have 50, 100, 200, ... sweeps. The last round ends with the last sweep requested. `late`: the number of
/// sweeps since the opening. `left`: the number of sweeps still to come, including this one.
double lateOmega(int late, int left, int longest)
{
  constexpr int firstRound = 50;
  constexpr double fall = 0.1;
  constexpr double timesAsLong = 3.0;
  constexpr double pi = 3.14159265358979323846;
  int roundsEnd = firstRound;
  for (int round = 2 * firstRound; roundsEnd <= late; round *= 2)
  {
    roundsEnd += round;
  }
  const int leftInRound = std::min(roundsEnd - late, left);
  const double longestOmega = 2.0 / (1.0 + std::sin(pi / (2.0 * timesAsLong * std::max(longest, 1))));
  return std::max(finalNearOmega, std::min(longestOmega, 2.0 / (1.0 + fall / leftInRound)));
}

/// The over-relaxation factor of a sweep after coarser grids where elements rotate. Coarser grids leave incompatible
/// rotations behind and, with them, long errors. The first sweeps (`smoothing`) remove roughness; the rest of the
/// opening follows the sequence of farOmega(). In the last sweeps the bound 2 / (1 + fall / left) removes roughness
/// again. `left`: the number of sweeps still to come, including this one.
double turningOmega(int sweep, int left, double times)
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

/// The over-relaxation factor of a sweep. With `longest` 0 the opening never ends.
float omegaOf(Reach reach, int sweep, int left, int longest, bool turns, double times)
{
  const int late = sweep - openingSweeps;
  if (longest > 0 && late >= 0)
  {
    return static_cast<float>(lateOmega(late, left, longest));
  }
  return static_cast<float>(reach == Reach::Far ? farOmega(sweep, times)
                            : turns             ? turningOmega(sweep, left, times)
                                                : nearOmega(sweep, times));
}

}

Relaxation::Relaxation(Bricks& bricks)
  : bricks_(bricks)
  , schedule_(bricks)
  , batch_(BATCH_ROW, "the list of turns")
{
}

/// Whether a single work-item does all passes of a batch in one launch.
bool Relaxation::isSmall() const
{
  return this->bricks_.workItems(true) == 1 && !this->bricks_.spins() &&
         this->schedule_.groups() * this->bricks_.elementsPerBrick() <= fewElements;
}

void Relaxation::relaxBatch(const RigidClusters& clusters, float still, const Elasticity& elasticity)
{
  Context& context = this->bricks_.context();
  this->batch_.toDevice(context);
  const std::string defines = this->bricks_.definesOfRows() + elasticity.ofLinks() + this->bricks_.ofSoftLinks();
  context.launch(context.kernel("relax.cl", defines, "relaxBatch"), 1, 1, this->schedule_.activity(),
    this->schedule_.log(), this->batch_.buffer(), static_cast<cl_int>(this->batch_.rows()),
    static_cast<cl_int>(this->schedule_.groups()), still, elasticity.slack, static_cast<cl_int>(elasticity.limited),
    this->bricks_.layout(), this->bricks_.state(), clusters.lists(), clusters.softList(), this->bricks_.softLinks());
}

void Relaxation::relaxColour(
  int colour, bool turns, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves)
{
  Context& context = this->bricks_.context();
  if (this->bricks_.spins())
  {
    const cl_int turning = turns ? mostSweepsPerRotation : 0;
    const std::string defines = this->bricks_.definesOfRows() + elasticity.defines() +
                                this->bricks_.ofVolumetricStrain() + this->bricks_.ofSoftLinks();
    context.launch(context.kernel("turn.cl", defines, "relaxTurning"), this->schedule_.groups(),
      this->bricks_.workItems(true), this->schedule_, static_cast<cl_int>(colour), turning, omega, still,
      this->bricks_.layout(), this->bricks_.state(), this->bricks_.spins(), this->bricks_.softLinks());
    return;
  }
  const std::string defines =
    this->bricks_.definesOfRows() + elasticity.ofLinks() + this->bricks_.ofSoftLinks() + (waves ? " -DWAVES" : "");
  context.launch(context.kernel("relax.cl", defines, "relax"), this->schedule_.groups(), this->bricks_.workItems(true),
    this->schedule_, static_cast<cl_int>(colour), omega, still, elasticity.slack,
    static_cast<cl_int>(elasticity.limited), this->bricks_.layout(), this->bricks_.state(), waves,
    this->bricks_.softLinks());
}

/// An active-set step: moves blocked groups (moveBlockedGroups). Returns the largest move.
float Relaxation::turnOfGroups(RigidClusters& clusters, const Elasticity& elasticity, float still, bool atRest)
{
  this->sweepsSinceGroups_ = 0;
  this->schedule_.touch();
  std::vector<int> moved;
  const float largest = moveBlockedGroups(this->bricks_, clusters, elasticity, still, moved);
  if (largest > 0.0f)
  {
    this->groupPeriod_ = sweepsPerGroupTurn;
  }
  else if (atRest)
  {
    this->groupPeriod_ = std::min(2 * this->groupPeriod_, mostSweepsPerGroupTurn);
  }
  this->schedule_.note(moved);
  clusters.refresh();
  return largest;
}

RelaxResult Relaxation::run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves,
  Reach reach, int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint)
{
  this->schedule_.begin(waves ? SweepSchedule::Bodies()
                              : SweepSchedule::Bodies{ [&] { return clusters.inactiveBricks(); },
                                  [&](const std::vector<int>& bricks) { clusters.activate(bricks); } });
  this->bricks_.setTurned(true);
  const float still = stillResidual(tolerance);
  const double times = furtherFor(this->bricks_.turning().poissonRatio);

  if (firstSweep == 0)
  {
    this->groupPeriod_ = this->sweepsSinceGroups_ = sweepsPerGroupTurn;
  }
  // The largest move of a sweep, `sweeps` from now, at which it has come to rest. An active-set step follows it, or it
  // is the last sweep.
  const auto restingMoveAfter = [&](int sweeps)
  {
    const bool groupsMayMove = !waves && this->sweepsSinceGroups_ + sweeps >= this->groupPeriod_;
    return std::max(static_cast<float>(tolerance), groupsMayMove ? restingMove : 0.0f);
  };
  // Where elements rotate, only a sweep with rotations shows whether they are at rest.
  const bool spins = this->bricks_.spins() != nullptr;
  const auto isJudged = [spins, reach](int sweep) { return !spins || turnsIn(reach, sweep); };
  // The opening never ends (0) where elements rotate, while waves are under way, or without coarser grids before.
  const Index3& size = this->bricks_.model().grid().size;
  const int longest = reach == Reach::Far || waves || spins ? 0 : *std::max_element(size.begin(), size.end());
  // The number of sweeps from `sweep` to the next active-set step at fixed intervals.
  const auto sweepsToGroups = [longest](int sweep)
  { return longest > 0 ? sweepsPerTimedGroupTurn - sweep % sweepsPerTimedGroupTurn : sweepsPerLaunch; };
  RelaxResult result;
  int launched = 0;
  while (result.iterations < iterations && !result.converged)
  {
    const bool atOnce = !waves && this->isSmall();
    const int sweeps = std::min({ atOnce ? sweepsPerLaunch : sweepsPerBatch, iterations - result.iterations,
      sweepsToGroups(firstSweep + result.iterations) });
    this->schedule_.beginBatch(sweeps);
    this->batch_.clear(0);
    for (int n = 0; n < sweeps; ++n)
    {
      launched = std::max(launched, result.iterations + n);
      checkpoint(launched);
      const int done = result.iterations + n;
      const float omega = omegaOf(reach, firstSweep + done, iterations - done, longest, spins, times);
      this->schedule_.beginSweep(isJudged(firstSweep + done - 1) ? restingMoveAfter(n) : SweepSchedule::goesOn);
      for (int colour = 0; colour < 2; ++colour)
      {
        if (!this->schedule_.takesTurn(colour))
        {
          continue;
        }
        if (atOnce)
        {
          this->schedule_.addTo(this->batch_, omega);
        }
        else
        {
          this->relaxColour(colour, turnsIn(reach, firstSweep + done), omega, still, elasticity, waves);
        }
      }
      if (!waves && clusters.anyActive() && this->schedule_.takesTurn(SweepSchedule::ofBodies))
      {
        // Without limits, members of a cluster may have different displacements. With a factor of 1 the result does not
        // depend on the current place of the cluster.
        const float ofClusters = elasticity.limited ? omega : 1.0f;
        if (atOnce)
        {
          this->schedule_.addTo(this->batch_, ofClusters);
        }
        else
        {
          clusters.relax(ofClusters, still, elasticity,
            { this->schedule_.activity(), this->schedule_.log(), this->schedule_.turn() });
        }
      }
    }
    if (atOnce)
    {
      this->relaxBatch(clusters, still, elasticity);
    }

    for (const float largest : this->schedule_.endBatch())
    {
      ++result.iterations;
      result.largestMove = largest;
      const int sweep = firstSweep + result.iterations;
      const bool judged = isJudged(sweep - 1);
      const bool atRest = judged && largest <= restingMoveAfter(1);
      const bool timed = longest > 0 && sweep > sweepsPerTimedGroupTurn && sweep % sweepsPerTimedGroupTurn == 0;
      if (!waves && elasticity.limited && (atRest || timed))
      {
        const float ofGroups = this->turnOfGroups(clusters, elasticity, still, atRest);
        result.largestMove = std::max(result.largestMove, static_cast<double>(ofGroups));
      }
      else
      {
        ++this->sweepsSinceGroups_;
      }
      result.converged = judged && result.largestMove <= tolerance;
    }
  }
  this->schedule_.touch();
  return result;
}

}
