#include "Relaxation.h"

#include "ActiveConstraints.h"
#include "Pass.h"
#include "StillResidual.h"
#include "sweepaccount.clh"

#include <algorithm>

namespace chainmail
{

namespace
{

/// After a sweep in which no element moves further than restingMove [fractions of the spacing], tissue counts as at
/// rest: at the optimum, or because chains of links at their limits block each other. Then an active-set step moves
/// blocked groups (moveBlockedGroups). Such steps are at least sweepsPerActiveSetStep sweeps apart, and each one that
/// moves nothing doubles this number. There are also steps at fixed intervals (SweepPlan), and one before a relaxation
/// counts as converged. While waves are under way, and without limits, there are none.
constexpr float restingMove = 1e-3f;
constexpr int sweepsPerActiveSetStep = 8;
constexpr int mostSweepsPerActiveSetStep = 1 << 20; // relaxations of tissue at rest double it again and again

/// Sweeps in one batch of launches.
constexpr int sweepsPerBatch = 8;

/// The same where a batch is one launch, whose sweeps take less time than reading their results.
constexpr int sweepsPerLaunch = 32;

/// With at most this many elements in loaded bricks a sweep takes about as long as launching its passes.
constexpr std::size_t fewElements = 1 << 15;

}

Relaxation::Relaxation(Bricks& bricks)
  : bricks_(bricks)
  , schedule_(bricks)
  , batch_(BATCH_ROW, "the list of colour passes")
{
}

/// Whether a single work-item does all passes of a batch in one launch.
bool Relaxation::fitsOneLaunch() const
{
  return this->bricks_.workItems(true) == 1 && !this->bricks_.rotations() &&
         this->schedule_.groups() * this->bricks_.elementsPerBrick() <= fewElements;
}

void Relaxation::relaxBatch(const RigidClusters& clusters, float still, const Elasticity& elasticity)
{
  Context& context = this->bricks_.context();
  this->batch_.toDevice(context);
  const std::string defines = this->bricks_.definesOfRows() + elasticity.ofLinks() + this->bricks_.ofSoftLinks();
  launchPass(this->bricks_, context.kernel("relax.cl", defines, "relaxBatch"), 1, 1, this->schedule_.activity(),
    this->schedule_.log(), this->batch_.buffer(), static_cast<cl_int>(this->batch_.rows()),
    static_cast<cl_int>(this->schedule_.groups()),
    this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), clusters.arguments(), clusters.counts(),
    still, elasticity.slack, static_cast<cl_int>(elasticity.limited));
}

void Relaxation::relaxColour(
  int colour, bool rotates, float omega, float still, const Elasticity& elasticity, const WavesUnderWay* waves)
{
  Context& context = this->bricks_.context();
  if (this->bricks_.rotations())
  {
    const cl_int rotating = rotates ? SweepPlan::mostSweepsPerRotation : 0;
    const std::string defines = this->bricks_.definesOfRows() + elasticity.defines() +
                                this->bricks_.ofVolumetricStrain() + this->bricks_.ofSoftLinks();
    launchPass(this->bricks_, context.kernel("relaxrotations.cl", defines, "relaxRotating"), this->schedule_.groups(),
      this->bricks_.workItems(true), this->schedule_,
      this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), static_cast<cl_int>(colour), rotating,
      omega, still);
    return;
  }
  const std::string defines =
    this->bricks_.definesOfRows() + elasticity.ofLinks() + this->bricks_.ofSoftLinks() + (waves ? " -DWAVES" : "");
  launchPass(this->bricks_, context.kernel("relax.cl", defines, "relax"), this->schedule_.groups(),
    this->bricks_.workItems(true), this->schedule_,
    this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), static_cast<cl_int>(colour), omega,
    still, elasticity.slack, static_cast<cl_int>(elasticity.limited), waves);
}

/// Moves blocked groups (moveBlockedGroups) and adapts the number of sweeps to the next such step: the least one after
/// a step that moved something, twice as many after one `atRest` that moved nothing. Returns the largest move.
float Relaxation::activeSetStep(RigidClusters& clusters, const Elasticity& elasticity, float still, bool atRest)
{
  this->sweepsSinceActiveSet_ = 0;
  this->schedule_.markDirty();
  std::vector<int> moved;
  const float largest = moveBlockedGroups(this->bricks_, clusters, elasticity, still, moved);
  if (largest > 0.0f)
  {
    this->activeSetPeriod_ = sweepsPerActiveSetStep;
  }
  else if (atRest)
  {
    this->activeSetPeriod_ = std::min(2 * this->activeSetPeriod_, mostSweepsPerActiveSetStep);
  }
  this->schedule_.note(moved);
  clusters.refresh();
  return largest;
}

RelaxResult Relaxation::run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves,
  Range range, int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint)
{
  this->schedule_.begin(waves ? SweepSchedule::Bodies()
                              : SweepSchedule::Bodies{ [&] { return clusters.inactiveBricks(); },
                                  [&](const std::vector<int>& bricks) { clusters.activate(bricks); } });
  this->bricks_.setRotated(true);
  const float still = stillResidual(tolerance);
  const Index3& size = this->bricks_.model().grid().size;
  const SweepPlan plan(range, this->bricks_.rotations() != nullptr, this->bricks_.rotationSettings().poissonRatio,
    waves ? 0 : *std::max_element(size.begin(), size.end()), firstSweep, iterations);
  if (firstSweep == 0)
  {
    this->activeSetPeriod_ = this->sweepsSinceActiveSet_ = sweepsPerActiveSetStep;
  }
  // The largest move of a sweep, `sweeps` from now, at which it has come to rest. An active-set step follows it, or it
  // is the last sweep.
  const auto restingMoveAfter = [&](int sweeps)
  {
    const bool groupsMayMove = !waves && this->sweepsSinceActiveSet_ + sweeps >= this->activeSetPeriod_;
    return std::max(static_cast<float>(tolerance), groupsMayMove ? restingMove : 0.0f);
  };
  RelaxResult result;
  int launched = 0;
  while (result.iterations < iterations && !result.converged)
  {
    const bool atOnce = !waves && this->fitsOneLaunch();
    const int sweeps = std::min({ atOnce ? sweepsPerLaunch : sweepsPerBatch, iterations - result.iterations,
      plan.sweepsToTimedStep(result.iterations) });
    this->schedule_.beginBatch(sweeps);
    this->batch_.clear(0);
    for (int n = 0; n < sweeps; ++n)
    {
      launched = std::max(launched, result.iterations + n);
      checkpoint(launched);
      const int done = result.iterations + n;
      const float omega = plan.omega(done);
      this->schedule_.beginSweep(plan.showsRest(done - 1) ? restingMoveAfter(n) : SweepSchedule::goesOn);
      for (int colour = 0; colour < 2; ++colour)
      {
        if (!this->schedule_.takesPass(colour))
        {
          continue;
        }
        if (atOnce)
        {
          this->schedule_.addTo(this->batch_, omega);
        }
        else
        {
          this->relaxColour(colour, plan.rotates(done), omega, still, elasticity, waves);
        }
      }
      if (!waves && clusters.anyActive() && this->schedule_.takesPass(SweepSchedule::ofBodies))
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
          clusters.relax(ofClusters, still, elasticity, this->schedule_.arguments());
        }
      }
    }
    if (atOnce)
    {
      this->relaxBatch(clusters, still, elasticity);
    }

    for (const float largest : this->schedule_.endBatch())
    {
      const int sweep = result.iterations++;
      result.largestMove = largest;
      const bool judged = plan.showsRest(sweep);
      const bool atRest = judged && largest <= restingMoveAfter(1);
      if (!waves && elasticity.limited && (atRest || plan.isTimedStepAfter(sweep)))
      {
        const float ofGroups = this->activeSetStep(clusters, elasticity, still, atRest);
        result.largestMove = std::max(result.largestMove, static_cast<double>(ofGroups));
      }
      else
      {
        ++this->sweepsSinceActiveSet_;
      }
      result.converged = judged && result.largestMove <= tolerance;
    }
  }
  this->schedule_.markDirty();
  return result;
}

}
