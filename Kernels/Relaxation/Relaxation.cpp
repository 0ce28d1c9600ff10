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
/// blocked groups (moveBlockedGroups). Such steps are at least sweepsPerActiveSetStep sweeps apart. Each such step that
/// moves nothing doubles this number, and one that moves something resets it. There are also steps at fixed intervals
/// (SweepPlan), and one before a relaxation counts as converged. While waves are under way, and without limits, there
/// are none.
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

/// What stays the same while a relaxation runs.
struct Relaxation::Run
{
  RigidClusters& clusters;
  const Elasticity& elasticity;
  const WavesUnderWay* waves; ///< null: none
  SweepPlan plan;
  float tolerance;
  float still; ///< see stillResidual()
};

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

void Relaxation::relaxBatch(const Run& run)
{
  Context& context = this->bricks_.context();
  this->batch_.toDevice(context);
  const std::string defines = this->bricks_.definesOfRows() + run.elasticity.ofLinks() + this->bricks_.ofSoftLinks();
  launchPass(this->bricks_, context.kernel("relax.cl", defines, "relaxBatch"), 1, 1, this->schedule_.activity(),
    this->schedule_.log(), this->batch_.buffer(), static_cast<cl_int>(this->batch_.rows()),
    static_cast<cl_int>(this->schedule_.groups()),
    this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), run.clusters.arguments(),
    run.clusters.counts(), run.still, run.elasticity.slack, static_cast<cl_int>(run.elasticity.limited));
}

void Relaxation::relaxColour(const Run& run, int colour, int sweep)
{
  Context& context = this->bricks_.context();
  const Elasticity& elasticity = run.elasticity;
  if (this->bricks_.rotations())
  {
    const cl_int rotating = run.plan.rotates(sweep) ? SweepPlan::mostSweepsPerRotation : 0;
    const std::string defines = this->bricks_.definesOfRows() + elasticity.defines() +
                                this->bricks_.ofVolumetricStrain() + this->bricks_.ofSoftLinks();
    launchPass(this->bricks_, context.kernel("relaxrotations.cl", defines, "relaxRotating"), this->schedule_.groups(),
      this->bricks_.workItems(true), this->schedule_,
      this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), static_cast<cl_int>(colour), rotating,
      run.plan.omega(sweep), run.still);
    return;
  }
  const std::string defines =
    this->bricks_.definesOfRows() + elasticity.ofLinks() + this->bricks_.ofSoftLinks() + (run.waves ? " -DWAVES" : "");
  launchPass(this->bricks_, context.kernel("relax.cl", defines, "relax"), this->schedule_.groups(),
    this->bricks_.workItems(true), this->schedule_,
    this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()), static_cast<cl_int>(colour),
    run.plan.omega(sweep), run.still, elasticity.slack, static_cast<cl_int>(elasticity.limited), run.waves);
}

/// The passes of a sweep: both colours, then the rigid clusters.
void Relaxation::addSweep(const Run& run, int sweep, float stopThreshold, bool inOneLaunch)
{
  this->schedule_.beginSweep(stopThreshold);
  for (int colour = 0; colour < 2; ++colour)
  {
    if (!this->schedule_.takesPass(colour))
    {
      continue;
    }
    if (inOneLaunch)
    {
      this->schedule_.addTo(this->batch_, run.plan.omega(sweep));
    }
    else
    {
      this->relaxColour(run, colour, sweep);
    }
  }
  if (!run.waves && run.clusters.anyActive() && this->schedule_.takesPass(SweepSchedule::ofBodies))
  {
    // Without limits, members of a cluster may have different displacements. With a factor of 1 the result does not
    // depend on the current place of the cluster.
    const float omega = run.elasticity.limited ? run.plan.omega(sweep) : 1.0f;
    if (inOneLaunch)
    {
      this->schedule_.addTo(this->batch_, omega);
    }
    else
    {
      run.clusters.relax(omega, run.still, run.elasticity, this->schedule_.arguments());
    }
  }
}

/// If the largest move of the sweep that is `sweeps` from now (1: the next one) is at most this, tissue counts as at
/// rest after it. An active-set step then follows, or the relaxation ends.
float Relaxation::restingMoveAfter(const Run& run, int sweeps) const
{
  const bool groupsMayMove =
    !run.waves && run.elasticity.limited && this->sweepsSinceActiveSet_ + sweeps >= this->activeSetPeriod_;
  return std::max(run.tolerance, groupsMayMove ? restingMove : 0.0f);
}

/// Moves blocked groups (moveBlockedGroups) and adapts the least number of sweeps to the next such step. It is
/// sweepsPerActiveSetStep after a step that moved something, and doubles after one `atRest` that moved nothing. Returns
/// the largest move.
float Relaxation::activeSetStep(const Run& run, bool atRest)
{
  this->sweepsSinceActiveSet_ = 0;
  this->schedule_.markDirty();
  std::vector<int> moved;
  const float largest = moveBlockedGroups(this->bricks_, run.clusters, run.elasticity, run.still, moved);
  if (largest > 0.0f)
  {
    this->activeSetPeriod_ = sweepsPerActiveSetStep;
  }
  else if (atRest)
  {
    this->activeSetPeriod_ = std::min(2 * this->activeSetPeriod_, mostSweepsPerActiveSetStep);
  }
  this->schedule_.note(moved);
  run.clusters.refresh();
  return largest;
}

RelaxResult Relaxation::run(RigidClusters& clusters, const Elasticity& elasticity, const WavesUnderWay* waves,
  Range range, int firstSweep, int iterations, double tolerance, const std::function<void(int)>& checkpoint)
{
  this->schedule_.begin(waves ? SweepSchedule::Bodies()
                              : SweepSchedule::Bodies{ [&] { return clusters.inactiveBricks(); },
                                  [&](const std::vector<int>& bricks) { clusters.activate(bricks); } });
  this->bricks_.setRotated(true);
  const Index3& size = this->bricks_.model().grid().size;
  const SweepPlan plan(range, this->bricks_.rotations() != nullptr, this->bricks_.rotationSettings().poissonRatio,
    waves ? 0 : *std::max_element(size.begin(), size.end()), firstSweep, iterations);
  const Run run{ clusters, elasticity, waves, plan, static_cast<float>(tolerance), stillResidual(tolerance) };
  if (firstSweep == 0)
  {
    this->activeSetPeriod_ = this->sweepsSinceActiveSet_ = sweepsPerActiveSetStep;
  }
  RelaxResult result;
  int launched = 0;
  while (result.iterations < iterations && !result.converged)
  {
    const bool inOneLaunch = !waves && this->fitsOneLaunch();
    const int sweeps = std::min({ inOneLaunch ? sweepsPerLaunch : sweepsPerBatch, iterations - result.iterations,
      plan.sweepsToTimedStep(result.iterations) });
    this->schedule_.beginBatch(sweeps);
    this->batch_.clear(0);
    for (int n = 0; n < sweeps; ++n)
    {
      const int sweep = result.iterations + n;
      launched = std::max(launched, sweep);
      checkpoint(launched);
      this->addSweep(
        run, sweep, plan.showsRest(sweep - 1) ? this->restingMoveAfter(run, n) : SweepSchedule::goesOn, inOneLaunch);
    }
    if (inOneLaunch)
    {
      this->relaxBatch(run);
    }

    for (const float largest : this->schedule_.endBatch())
    {
      const int sweep = result.iterations++;
      result.largestMove = largest;
      const bool judged = plan.showsRest(sweep);
      const bool atRest = judged && largest <= this->restingMoveAfter(run, 1);
      if (!waves && elasticity.limited && (atRest || plan.isTimedStepAfter(sweep)))
      {
        result.largestMove = std::max(result.largestMove, static_cast<double>(this->activeSetStep(run, atRest)));
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
