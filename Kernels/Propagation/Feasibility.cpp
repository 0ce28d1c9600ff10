#include "Feasibility.h"

#include <limits>

namespace chainmail
{

namespace
{

/// Bounds that still change after so many passes over all bricks count as divergent: rotations contradict each other.
constexpr int mostPasses = 16;

/// Held elements are compatible if they strain links beyond their limits by no more than this.
constexpr double rounding = 1e-5;

}

Feasibility::Feasibility(Bricks& bricks)
  : bricks_(bricks)
  , fixedPoint_(bricks, "feasibility.cl", "bound")
  , upper_{ 3, sizeof(cl_float), "bounds of displacements" }
  , lower_{ 3, sizeof(cl_float), "bounds of displacements" }
{
}

Feasibility::~Feasibility()
{
  this->bricks_.removeField(this->upper_);
  this->bricks_.removeField(this->lower_);
}

/// The bricks of those slots for which the kernel `what` sets `found`.
std::vector<int> Feasibility::bricksThatAre(
  const char* what, const char* file, bool vectors, const std::vector<int>& slots)
{
  Context& context = this->bricks_.context();
  std::vector<cl_int> found(slots.size(), 0);
  const std::string defines = vectors ? this->bricks_.definesOfRows(this->bricks_.activeRotations())
                                      : this->bricks_.defines(false, this->bricks_.activeRotations());
  const cl::Buffer& foundBuffer = this->found_.holding(context, found);
  context.launch(context.kernel(file, defines, what), slots.size(), this->bricks_.workItems(vectors),
    this->list_.holding(context, slots), this->bricks_.state(this->bricks_.activeRotations()), foundBuffer);
  context.read(foundBuffer, found);
  return this->bricks_.bricksWhere(slots, found);
}

bool Feasibility::run(EnvelopePropagation& propagation, const Checkpoint& checkpoint)
{
  this->bricks_.makeUpdatable(this->bricks_.bricksOf(this->bricks_.dirtySlots()));
  const bool rotating = this->bricks_.activeRotations() != nullptr;
  const std::vector<int> slots = this->bricks_.dirtySlots();
  const std::vector<int> violated =
    this->bricksThatAre("violated", "feasibility.cl", true, rotating ? slots : this->bricks_.slotsAround(slots));
  this->bricks_.makeUpdatable(violated);
  const std::vector<int> violatedSlots = this->bricks_.slotsOf(violated);
  if (violated.empty() ||
      (rotating && !this->bricksThatAre("contradicted", "contradictions.cl", false, violatedSlots).empty()))
  {
    propagation.start({}); // resets conflict() to 0
    return violated.empty();
  }
  if (rotating)
  {
    this->bricks_.addField(this->upper_); // both are bounds of shifts, which start as 0
    this->bricks_.addField(this->lower_);
  }
  else
  {
    // The lower bounds are in Bricks::before(). There `settle` writes the state from which the wave starts.
    this->bricks_.before().save(violatedSlots);
    this->bricks_.saveIn(this->upper_, violatedSlots);
  }
  this->fixedPoint_.start(violated);
  this->fixedPoint_.run(rotating ? mostPasses : 0, std::numeric_limits<float>::infinity(), checkpoint,
    [&](ArgumentList& own)
    { own.add(rotating ? this->lower_.buffer : this->bricks_.before().buffer(), this->upper_.buffer); });
  bool feasible = this->fixedPoint_.finished();
  const std::vector<int> changed = this->fixedPoint_.changed();
  this->bricks_.markDirty(changed);
  if (rotating)
  {
    this->bricks_.before().save(changed);
  }
  Context& context = this->bricks_.context();
  std::vector<cl_int> found(changed.size(), 0);
  const cl::Buffer& foundBuffer = this->found_.holding(context, found);
  context.launch(
    context.kernel("feasibility.cl", this->bricks_.definesOfRows(this->bricks_.activeRotations()), "settle"),
    changed.size(), this->bricks_.workItems(true), this->list_.holding(context, changed), this->bricks_.pitch(),
    this->bricks_.tissuePitch(), this->bricks_.constraint(), this->upper_.buffer,
    [&](ArgumentList& own)
    {
      if (rotating)
      {
        own.add(this->lower_.buffer);
      }
    },
    this->bricks_.before().buffer(), this->bricks_.displacement(), foundBuffer);
  context.read(foundBuffer, found);
  if (feasible)
  {
    // With rotations the wave also removes the rounding of the means, so it starts in all bricks that have any.
    // Without, links may exceed their limits by that rounding, as after a sweep.
    propagation.start(rotating ? this->bricks_.bricksOf(changed) : this->bricks_.bricksWhere(changed, found));
    propagation.run(0, std::numeric_limits<float>::infinity(), checkpoint);
    feasible = !rotating || propagation.conflict().largest() <= rounding;
  }
  else
  {
    propagation.start({}); // resets conflict() to 0
  }
  propagation.release();
  this->bricks_.removeField(this->upper_);
  this->bricks_.removeField(this->lower_);
  this->bricks_.before().release();
  return feasible;
}

}
