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

/// Sweeps in which no element moves further than this [fractions of the spacing] have come to rest, either at the
/// optimum or because chains of links at their limits block each other. Blocked groups then get a turn: at most once in
/// sweepsPerGroupTurn sweeps, half as often after each turn in which none could move, and always before a relaxation
/// counts as converged.
constexpr float restingMove = 1e-3f;
constexpr int sweepsPerGroupTurn = 8;
constexpr int mostSweepsPerGroupTurn = 1 << 20; // tissue that stays at rest doubles them in every relaxation

/// Where much tissue is to settle, some of it is in motion for long while chains elsewhere block each other. So after
/// many sweeps groups also get a turn every so often.
constexpr int sweepsPerTimedGroupTurn = 30;

/// Whether elements turn in a sweep (turn.cl): in every third of the first, and in every sixth in the end, when
/// displacements hardly change from sweep to sweep. Where coarser grids went before, spins are what they had to leave
/// behind most of all (CoarseToFine), so that elements turn more often for longer; but not in the first sweep, since
/// displacements are rough there and spins that follow these would contradict each other.
constexpr int mostSweepsPerRotation = 6;
bool turnsIn(Reach reach, int sweep)
{
  const int first = reach == Reach::Far ? 0 : 1;
  const int opening = reach == Reach::Far ? 12 : 24;
  return sweep % (sweep <= opening ? 3 : mostSweepsPerRotation) == first;
}

/// Sweeps in one batch of launches.
constexpr int sweepsPerBatch = 8;

/// The same where a batch is one launch, whose sweeps take less time than looking at what they did.
constexpr int sweepsPerLaunch = 32;

/// In grids of no more elements than this a sweep takes about as long as launching its turns does.
constexpr std::size_t fewElements = 1 << 15;

/// The over-relaxation factors that the opening sweeps come to.
constexpr double finalOmega = 1.9; // = 2 / (1 + sqrt(1 - rho2))
constexpr double finalNearOmega = 1.93;

/// Where tissue resists swelling an element weighs more than its links, and errors live longer: how many times as far
/// factors go towards 2. Measured on pulled and dragged blocks at Poisson's ratios 0.3 and 0.45; more gains nothing.
double furtherFor(double poissonRatio)
{
  const double weight = 1.0 + 0.5 * poissonRatio / (1.0 - 2.0 * poissonRatio); // that of elements, by that of links
  return std::min(5.0, weight * std::sqrt(weight));
}

/// Takes a factor so many times as far towards 2.
double further(double omega, double times)
{
  return times == 1.0 ? omega : 2.0 / (1.0 + (2.0 / omega - 1.0) / times);
}

/// The over-relaxation factor of a sweep that reaches far: the Chebyshev semi-iterative sequence (G. Golub and R.
/// Varga, Numerische Mathematik 3, 1961). It starts at 1, best for the first sweep, in which most energy goes, leaps to
/// almost 2 and falls to finalOmega.
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

/// The over-relaxation factor of a sweep that reaches less far. With a factor near 2, rough displacements stay rough
/// for tens of sweeps. For an error `length` elements long the best factor is 2 / (1 + sin(pi / length)), and every
/// sweep leaves an error that is longer by about 2 pi. Errors are long in thin tissue, which coarser grids do not see,
/// so the factor ends a little above finalOmega.
double nearOmega(int sweep, double times)
{
  return further(std::min(finalNearOmega, 2.0 / (1.0 + 0.5 / (sweep + 1))), times);
}

/// Sweeps that reach less far open with the factors of nearOmega().
constexpr int openingSweeps = 20;

/// The over-relaxation factor of a sweep after the opening. What is left is long: much tissue that hangs on little goes
/// back as slowly as an error a few times as long as the grid's `longest` axis. It takes a factor near 2, which leaves
/// roughness, which a smaller one takes away. So sweeps come in rounds of 50, 100, 200, ..., in which the factor falls
/// to what the opening came to; the last round ends with the last of the sweeps that are asked for. `late` counts
/// the sweeps since the opening, `left` those that are still to come, with this one.
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

/// The over-relaxation factor of a sweep that follows coarser grids where elements turn. Spins that contradict each
/// other are left behind there, and with them errors that are long: once the first sweeps have smoothed what is rough,
/// the others open as sweeps that reach far. The last ones take roughness away again. `left` counts the sweeps that are
/// still to come, with this one.
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

/// Whether a single work-item takes all turns of a batch in one launch.
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
    const std::string defines =
      this->bricks_.definesOfRows() + elasticity.defines() + this->bricks_.ofSwelling() + this->bricks_.ofSoftLinks();
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

/// Gives blocked groups their turn. Returns the largest move of any.
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
  // A sweep that moves nothing by more than this, `sweeps` from now, is followed by a turn of blocked groups or is the
  // last.
  const auto restingMoveAfter = [&](int sweeps)
  {
    const bool groupsMayMove = !waves && this->sweepsSinceGroups_ + sweeps >= this->groupPeriod_;
    return std::max(static_cast<float>(tolerance), groupsMayMove ? restingMove : 0.0f);
  };
  // A sweep in which elements did not turn tells nothing about whether they are at rest.
  const bool spins = this->bricks_.spins() != nullptr;
  const auto isJudged = [spins, reach](int sweep) { return !spins || turnsIn(reach, sweep); };
  // Where elements turn, or no coarser grids went before, sweeps go on as they open.
  const Index3& size = this->bricks_.model().grid().size;
  const int longest = reach == Reach::Far || waves || spins ? 0 : *std::max_element(size.begin(), size.end());
  // How many sweeps there are, after so many, to the next timed turn of blocked groups.
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
        // Where limits do not count, members of a cluster may be apart. With a factor of 1 it does
        // not matter where it is now.
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
