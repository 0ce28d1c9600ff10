#include "CoarseToFine.h"

#include "CoarseModel.h"
#include "ElementRule.h"
#include "Measurement.h"
#include "Pass.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

namespace chainmail
{

namespace
{

/// The sweeps on one coarser grid.
struct Sweeps
{
  Range range;
  int count;
};

/// `depth`: the number of grids between this one and the finest. Deeper grids reduce errors that extend over many
/// elements, and their sweeps cost little; on small grids sweeps cost almost nothing. Where elements rotate, the
/// coarser grid before has left incompatible rotations behind. So such long errors remain also at depth 0.
Sweeps sweepsOn(const Grid& grid, std::size_t depth, bool rotates)
{
  if (*std::max_element(grid.size.begin(), grid.size.end()) <= 16)
  {
    return { Range::Far, 40 };
  }
  if (depth == 0)
  {
    return rotates ? Sweeps{ Range::Far, 50 } : Sweeps{ Range::Near, 30 };
  }
  return { Range::Far, 30 };
}

/// A grid with no axis longer than this is the coarsest one.
constexpr int coarsestSize = 8;

/// Sweeps on the finest grid that smooth the interpolated displacements. They ignore the limits of links.
constexpr int smoothingSweeps = 2;

/// The share of a step that is kept is a multiple of this, so rounding of energies does not change it.
constexpr double shareStep = 1.0 / 16.0;

/// A correction is added this many times. Elements of coarser grids near fixed ones are fixed themselves, so
/// corrections are too small: the best factor for pulls at random in scans was between 1.1 and 3.
constexpr float timesAdded = 1.5f;

/// Sweeps on each coarser grid of a correction.
constexpr int correctionSweeps = 30;

/// A handle is displaced further than a coarser grid can stretch if the excess is above this [fractions of that grid's
/// spacing].
constexpr double tooFar = 1e-4;

/// Saves the rotations of all elements in `before`.
void saveRotations(Bricks& bricks, Field& before)
{
  bricks.addField(before);
  bricks.context().queue().enqueueCopyBuffer(
    bricks.rotations()->spin.buffer, before.buffer, 0, 0, sizeof(cl_float) * 3 * bricks.pitch());
}

/// Restores the rotations of all elements from `before`.
void restoreRotations(Bricks& bricks, const Field& before)
{
  bricks.context().queue().enqueueCopyBuffer(
    before.buffer, bricks.rotations()->spin.buffer, 0, 0, sizeof(cl_float) * 3 * bricks.pitch());
}

/// The soft links of a coarser grid. The soft link of an element has the sum of the weights of those that it stands
/// for. Its place is the weighted mean of theirs. A link between elements stands for four parallel links (two in a
/// slice), but its energy counts once. So the energy of soft links is divided by four (two), too. Weights refer to
/// lengths in spacings, and the spacing is doubled, so weights are doubled.
std::vector<SoftLink> coarserSoftLinks(const Bricks& finer, const Grid& grid)
{
  std::map<std::size_t, SoftLink> sums;
  for (const SoftLink& link : finer.softLinks()->all())
  {
    const Index3 at = finer.model().grid().indexOf(link.voxel);
    SoftLink& sum = sums[grid.at(at[0] / 2, at[1] / 2, at[2] / 2)];
    sum.weight += link.weight;
    for (int a = 0; a < 3; ++a)
    {
      sum.place[a] += link.weight * link.place[a];
    }
  }
  double linksPerLink = 0.5;
  for (const int size : finer.model().grid().size)
  {
    linksPerLink *= size > 1 ? 2.0 : 1.0;
  }
  std::vector<SoftLink> links;
  for (auto& [voxel, sum] : sums)
  {
    for (double& place : sum.place)
    {
      place = sum.weight > 0.0 ? 0.5 * place / sum.weight : 0.0;
    }
    sum.voxel = voxel;
    sum.weight *= 2.0 / linksPerLink;
    links.push_back(sum);
  }
  return links;
}

}

/// One coarser grid, together with the finer grid that it stands for.
class CoarseToFine::Level
{
public:
  /// `depth`: as for sweepsOn(). The constraints of depth 0 would take half a byte for every voxel, so they are
  /// computed from the voxels when they are needed. Those of further levels take less, and reading one again and again
  /// would read all voxels that it stands for.
  Level(Bricks& finer, std::size_t depth)
    : finer_(finer)
    , model_(coarserModel(finer, depth > 0))
    , bricks_(finer.sharedContext(), this->model_, finer.size(), finer.rotationSettings())
    , propagation_(this->bricks_)
    , feasibility_(this->bricks_)
    , relaxation_(this->bricks_)
  {
    coarsenCuts(finer, this->bricks_);
    this->clusters_ = std::make_unique<RigidClusters>(this->bricks_);
  }
  ~Level() { this->release(); }

  /// See CoarseToFine::release().
  void release()
  {
    this->bricks_.removeField(this->rotationsBefore_);
    this->bricks_.removeField(this->residual_);
  }

  Bricks& bricks() { return this->bricks_; }

  /// Restricts the state of the finer grid to this one. `held`: the voxels of this grid that probes hold.
  void coarsen(const std::vector<std::size_t>& held)
  {
    this->bricks_.clearDisplacements();
    this->hold(held);
    const std::vector<int> slots = this->bricks_.slotsOf(this->touchBricks());
    this->bricks_.setSoftLinks(
      this->finer_.softLinks() ? coarserSoftLinks(this->finer_, this->model_->grid()) : std::vector<SoftLink>());
    Context& context = this->bricks_.context();
    const auto transfer = [&](const cl::Buffer& from, float scale, bool rotations, const cl::Buffer& to)
    {
      launchPass(this->bricks_, context.kernel("coarsen.cl", this->bricks_.definesOfRows(), "coarsen"), slots.size(),
        this->bricks_.workItems(true), this->list_.holding(context, slots),
        this->bricks_.stateWith(to, this->bricks_.rotations()), this->finer_.layout(), from, this->finer_.constraint(),
        scale, static_cast<cl_int>(rotations));
    };
    transfer(this->finer_.displacement(), 0.5f, false, this->bricks_.displacement());
    this->clusters_->begin(this->held_);
    if (this->bricks_.rotations())
    {
      transfer(this->finer_.rotations()->spin.buffer, 1.0f, true, this->bricks_.rotations()->spin.buffer);
      this->bricks_.setRotated(this->finer_.activeRotations() != nullptr);
      this->clusters_->projectToRigid();
      saveRotations(this->bricks_, this->rotationsBefore_);
    }
  }

  /// Projects the state to a feasible one. If its rotations are incompatible, those restricted from the finer grid
  /// replace them first. On this grid handles and bones are thicker, and the tissue between them is thinner. So it may
  /// not stretch as far as a handle is displaced. Then the handle is set back to a feasible place. Otherwise it would
  /// drag anchored bone and everything around it along.
  void projectToFeasible(const Checkpoint& checkpoint)
  {
    if (!this->feasibility_.run(this->propagation_, checkpoint) && this->propagation_.conflict().largest() == 0.0)
    {
      // Infeasible, but no conflict between held elements: the rotations are incompatible with each other.
      restoreRotations(this->bricks_, this->rotationsBefore_);
      this->clusters_->begin(this->held_);
      this->clusters_->projectToRigid(false);
      this->feasibility_.run(this->propagation_, checkpoint);
    }
    if (this->propagation_.conflict().largest() > tooFar)
    {
      this->mark(this->held_, false);
      this->feasibility_.run(this->propagation_, checkpoint);
      this->mark(this->held_, true);
    }
  }

  void relax(std::size_t depth, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
  {
    this->clusters_->begin(this->held_);
    const Sweeps sweeps = sweepsOn(this->model_->grid(), depth, this->bricks_.rotations() != nullptr);
    this->relaxation_.run(
      *this->clusters_, elasticity, nullptr, sweeps.range, 0, sweeps.count, tolerance, [&](int) { checkpoint(); });
  }

  /// Interpolates the displacements and rotations of this grid to the finer one. The result need not be feasible.
  void refine()
  {
    const std::vector<int> slots = this->touchFinerBricks();
    this->interpolate(
      slots, this->bricks_.displacement(), 2.0f, false, this->finer_.displacement(), {}, this->finer_.displacement());
    if (this->bricks_.rotations())
    {
      const cl::Buffer& spin = this->finer_.rotations()->spin.buffer;
      this->interpolate(slots, this->bricks_.rotations()->spin.buffer, 1.0f, true, spin, {}, spin);
      this->finer_.setRotated(true);
      this->bricks_.removeField(this->rotationsBefore_);
    }
  }

  /// Projects the bones of this grid to rigid motions, after interpolation from the coarser grid.
  void projectToRigid()
  {
    this->clusters_->begin(this->held_);
    this->clusters_->projectToRigid();
  }

  // --- Corrections, see correction.cl

  /// Restricts the residual of the finer grid to this one, as a force on its elements. `any`: whether one fixed child
  /// fixes an element; otherwise all are needed. Held elements are those of coarsen().
  void restrictResidual(const Field& residual, bool any)
  {
    this->bricks_.clearDisplacements();
    const std::vector<int> bricks = this->touchBricks();
    const std::vector<int> slots = this->bricks_.slotsOf(bricks);
    this->bricks_.makeSoftLinks(bricks);
    this->bricks_.addTemporary(this->residual_);
    // The energy of a coarser link is that of the finer ones that it stands for, divided by their number, and its
    // displacement is half as large. The residual is a derivative of the energy.
    float share = 2.0f;
    for (const int size : this->finer_.model().grid().size)
    {
      share *= size > 1 ? 0.5f : 1.0f;
    }
    Context& context = this->bricks_.context();
    launchPass(this->bricks_, context.kernel("correction.cl", this->bricks_.definesOfRows(), "restrictResiduals"),
      slots.size(), this->bricks_.workItems(true), this->list_.holding(context, slots),
      this->bricks_.state(nullptr, nullptr), this->finer_.layout(), residual.buffer, this->finer_.constraint(), share,
      static_cast<cl_int>(any), this->residual_.buffer, this->bricks_.softLinks()->values(),
      this->bricks_.softLinks()->proportions());
    this->clusters_->beginCorrection(this->held_, this->residual_);
  }
  const Field& residual() const { return this->residual_; }

  /// Relaxes the correction, from what the coarser grids found.
  void relaxCorrection(const Elasticity& unlimited, const Checkpoint& checkpoint)
  {
    this->relaxation_.run(
      *this->clusters_, unlimited, nullptr, Range::Far, 0, correctionSweeps, 0.0, [&](int) { checkpoint(); });
    this->bricks_.setSoftLinks({});
  }

  /// Adds `share` of the correction, interpolated, to the displacements of the finer grid. Elements whose `residual` is
  /// infinite are fixed and get none.
  void addCorrection(const Field& residual, float share)
  {
    this->interpolate(this->touchFinerBricks(), this->bricks_.displacement(), 2.0f, false, this->finer_.displacement(),
      share, residual.buffer);
  }

private:
  /// Makes the bricks of the finer grid that dirty ones stand for updatable and dirty, and returns their slots.
  std::vector<int> touchFinerBricks()
  {
    std::set<int> needed;
    const Index3 size = this->bricks_.size();
    const Grid& fine = this->finer_.model().grid();
    for (const int slot : this->bricks_.dirtySlots())
    {
      const Index3 origin = this->bricks_.origin(this->bricks_.brick(slot));
      for (int n = 0; n < 8; ++n)
      {
        const Index3 at{ 2 * origin[0] + (n & 1) * size[0], 2 * origin[1] + (n >> 1 & 1) * size[1],
          2 * origin[2] + (n >> 2) * size[2] };
        if (fine.contains(at[0], at[1], at[2]))
        {
          needed.insert(this->finer_.brickAt(at[0], at[1], at[2]));
        }
      }
    }
    const std::vector<int> bricks(needed.begin(), needed.end());
    this->finer_.makeUpdatable(bricks);
    const std::vector<int> slots = this->finer_.slotsOf(bricks);
    this->finer_.markDirty(slots);
    return slots;
  }

  /// Interpolates `from`, on this grid, to the slots of the finer one. `correction`: the share of it that is added
  /// where `fixed` is finite; otherwise it replaces what is in `to`.
  void interpolate(const std::vector<int>& slots, const cl::Buffer& from, float scale, bool rotations,
    const cl::Buffer& to, std::optional<float> correction, const cl::Buffer& fixed)
  {
    Context& context = this->bricks_.context();
    // The program is built for the cuts of this grid. Cuts of the finer grid have no effect here.
    launchPass(this->finer_, context.kernel("coarsen.cl", this->bricks_.definesOfRows(), "refine"), slots.size(),
      this->bricks_.workItems(true), this->list_.holding(context, slots),
      this->bricks_.stateWith(from, this->bricks_.rotations()), this->finer_.layout(), to, this->finer_.constraint(),
      scale, static_cast<cl_int>(rotations), static_cast<cl_int>(correction.has_value()), correction.value_or(1.0f),
      fixed);
  }

  /// Makes the bricks that stand for dirty ones of the finer grid updatable and dirty, and returns them.
  std::vector<int> touchBricks()
  {
    std::set<int> needed;
    for (const int slot : this->finer_.dirtySlots())
    {
      const Index3 origin = this->finer_.origin(this->finer_.brick(slot));
      needed.insert(this->bricks_.brickAt(origin[0] / 2, origin[1] / 2, origin[2] / 2));
    }
    std::vector<int> bricks(needed.begin(), needed.end());
    this->bricks_.makeUpdatable(bricks);
    this->bricks_.markDirty(this->bricks_.slotsOf(bricks));
    return bricks;
  }

  void hold(const std::vector<std::size_t>& voxels)
  {
    this->mark(this->held_, false);
    this->held_ = voxels;
    this->mark(this->held_, true);
  }

  void mark(const std::vector<std::size_t>& voxels, bool held)
  {
    const Grid& grid = this->model_->grid();
    const int axes = this->model_->axes();
    std::vector<int> bricks;
    for (const std::size_t voxel : voxels)
    {
      const Index3 at = grid.indexOf(voxel);
      bricks.push_back(this->bricks_.brickAt(at[0], at[1], at[2]));
    }
    this->bricks_.makeUpdatable(bricks);
    std::vector<float> values(voxels.size() * axes);
    for (std::size_t n = 0; n < voxels.size(); ++n)
    {
      const Index3 at = grid.indexOf(voxels[n]);
      this->bricks_.row(at[0], at[1], at[2], 1, values.data() + n * axes);
    }
    std::transform(values.begin(), values.end(), values.begin(), [held](float c) { return rule::asHeld(c, held); });
    Elements(this->bricks_, voxels).setConstraints(values);
  }

  Bricks& finer_;
  std::shared_ptr<const Model> model_;
  Bricks bricks_;
  std::vector<std::size_t> held_;
  EnvelopePropagation propagation_;
  Feasibility feasibility_;
  Relaxation relaxation_;
  std::unique_ptr<RigidClusters> clusters_;
  Scratch list_{ "the list of bricks" };
  Field rotationsBefore_{ 3, sizeof(cl_float), "the rotations" };
  Field residual_{ 3, sizeof(cl_float), "the residuals of a relaxation" };
};

CoarseToFine::CoarseToFine(Bricks& bricks, Handles& handles, StepStart& start)
  : bricks_(bricks)
  , handles_(handles)
  , start_(start)
  , propagation_(bricks)
  , feasibility_(bricks)
  , relaxation_(bricks)
{
}

CoarseToFine::~CoarseToFine()
{
  this->release();
}

void CoarseToFine::release()
{
  this->start_.release();
  this->bricks_.removeField(this->rotationsBefore_);
  this->bricks_.removeField(this->residual_);
  for (const std::unique_ptr<Level>& level : this->levels_)
  {
    level->release();
  }
}

void CoarseToFine::forget()
{
  this->levels_.clear();
  this->components_.reset();
}

void CoarseToFine::build()
{
  this->components_ = std::make_unique<TissueComponents>(this->bricks_);
  Bricks* coarsest = &this->bricks_;
  for (;;)
  {
    const Index3& size = coarsest->model().grid().size;
    if (*std::max_element(size.begin(), size.end()) <= coarsestSize)
    {
      return;
    }
    this->levels_.push_back(std::make_unique<Level>(*coarsest, this->levels_.size()));
    coarsest = &this->levels_.back()->bricks();
  }
}

double CoarseToFine::energy(const Elasticity& elasticity) const
{
  return energyOf(this->bricks_, measureBricks(this->bricks_, elasticity));
}

void CoarseToFine::cycle(
  RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
{
  const Grid* finer = &this->bricks_.model().grid();
  std::vector<std::size_t> held = this->handles_.voxels();
  for (const std::unique_ptr<Level>& level : this->levels_)
  {
    const Grid& grid = level->bricks().model().grid();
    for (std::size_t& voxel : held)
    {
      const Index3 at = finer->indexOf(voxel);
      voxel = grid.at(at[0] / 2, at[1] / 2, at[2] / 2);
    }
    std::sort(held.begin(), held.end());
    held.erase(std::unique(held.begin(), held.end()), held.end());
    finer = &grid;
    level->coarsen(held);
  }
  this->levels_.back()->projectToFeasible(checkpoint); // the others are projected after interpolation to them
  for (std::size_t n = this->levels_.size(); n-- > 0;)
  {
    Level& level = *this->levels_[n];
    level.relax(n, elasticity, tolerance, checkpoint);
    level.refine();
    if (n > 0)
    {
      if (this->bricks_.rotations())
      {
        this->levels_[n - 1]->projectToRigid();
      }
      this->levels_[n - 1]->projectToFeasible(checkpoint);
    }
    else
    {
      this->putOthersBack();
      this->smooth(clusters, elasticity, tolerance, checkpoint);
      this->feasible_ = this->feasibility_.run(this->propagation_, checkpoint);
      if (!this->feasible_ && this->bricks_.rotations())
      {
        // The rotations before the cycle are compatible. With these, tissue and bones only move; they rotate in the
        // sweeps that follow.
        restoreRotations(this->bricks_, this->rotationsBefore_);
        this->bricks_.setRotated(this->rotatedBefore_);
        clusters.projectToRigid(false);
        this->feasible_ = this->feasibility_.run(this->propagation_, checkpoint);
      }
    }
  }
}

/// Smooths the interpolated displacements, and projects those of rigid clusters to motions as a whole.
void CoarseToFine::smooth(
  RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
{
  Elasticity unlimited = elasticity;
  unlimited.limited = false;
  clusters.begin(this->handles_.voxels(), this->handles_.rotatingVoxels());
  if (this->bricks_.rotations())
  {
    clusters.projectToRigid();
  }
  this->relaxation_.run(
    clusters, unlimited, nullptr, Range::Near, 0, smoothingSweeps, tolerance, [&](int) { checkpoint(); });
}

/// Of each connected component, whether coarser grids may move it: an element in it is held and a link is strained. A
/// soft link counts as both: it strains its element until that is at the link's target place.
std::vector<char> CoarseToFine::movingComponents()
{
  const TissueComponents& components = *this->components_;
  std::vector<char> isHeld(components.count(), 0);
  std::vector<char> moves(components.count(), 0);
  for (int n = 0; n < components.count(); ++n)
  {
    isHeld[n] = components.isAnchored(n) ? 1 : 0;
  }
  for (const std::size_t voxel : this->handles_.voxels())
  {
    isHeld[components.of(voxel)] = 1;
  }
  if (const SoftLinks* soft = this->bricks_.softLinks())
  {
    for (const SoftLink& link : soft->all())
    {
      moves[components.of(link.voxel)] = 1;
    }
  }

  Context& context = this->bricks_.context();
  const std::vector<int> dirty = this->bricks_.dirtySlots();
  std::vector<cl_int> found(dirty.size());
  const cl::Buffer& foundBuffer = this->found_.sized(context, sizeof(cl_int) * std::max<std::size_t>(1, found.size()));
  context.launch(context.kernel("strained.cl", this->bricks_.definesOfRows(), "strained"), dirty.size(),
    this->bricks_.workItems(true), this->list_.holding(context, dirty), this->bricks_.state(this->bricks_.rotations()),
    foundBuffer);
  context.read(foundBuffer, found);
  std::vector<char> hasStrain(this->bricks_.numbers(), 0);
  for (const int brick : this->bricks_.bricksWhere(dirty, found))
  {
    hasStrain[brick] = 1;
  }
  for (int n = 0; n < components.count(); ++n)
  {
    moves[n] = moves[n] || (isHeld[n] && this->isStrained(n, hasStrain)) ? 1 : 0;
  }
  return moves;
}

/// Whether a link in a component is strained. `hasStrain`: of each brick whether one of its elements has a strained
/// link.
bool CoarseToFine::isStrained(int component, const std::vector<char>& hasStrain)
{
  const Grid& grid = this->bricks_.model().grid();
  std::set<int> examined;
  return this->components_->anyRun(component,
    [&](const ElementRun& run)
    {
      const Index3 first = grid.indexOf(run.first);
      const int last = first[0] + static_cast<int>(run.count) - 1;
      bool any = false;
      for (int brick = this->bricks_.brickAt(first[0], first[1], first[2]);
           !any && brick <= this->bricks_.brickAt(last, first[1], first[2]); ++brick)
      {
        any = hasStrain[brick] && examined.insert(brick).second && this->isStrained(component, brick);
      }
      return any;
    });
}

/// Whether an element of a component in a brick has a strained link. To be called only where some element of the brick
/// has one.
bool CoarseToFine::isStrained(int component, int brick)
{
  const Grid& grid = this->bricks_.model().grid();
  if (this->components_->inBrick(brick).size() == 1)
  {
    return true;
  }
  Elements from(this->bricks_);
  Elements to(this->bricks_);
  for (const std::size_t voxel : this->components_->elementsIn(brick, component))
  {
    const Index3 at = grid.indexOf(voxel);
    this->bricks_.forNeighbours(at,
      [&](int, const Index3& next)
      {
        if (this->bricks_.isElement(next))
        {
          from.add(at);
          to.add(next);
        }
      });
  }
  return from.displacements() != to.displacements();
}

/// Restores the state before the cycle in components that do not move.
void CoarseToFine::putOthersBack()
{
  const bool most = this->moves_[this->components_->largest()] != 0; // whether the largest component moves
  Elements few(this->bricks_);                                       // of all components for which the opposite is true
  for (int n = 0; n < this->components_->count(); ++n)
  {
    if ((this->moves_[n] != 0) != most)
    {
      this->addElements(n, few);
    }
  }
  const Rotations* rotations = this->bricks_.rotations();
  if (most)
  {
    few.setDisplacements(few.values(this->start_.field()));
    if (rotations)
    {
      few.setRotations(few.values(this->rotationsBefore_));
    }
    return;
  }
  const std::vector<float> u = few.displacements();
  this->start_.restore();
  few.setDisplacements(u);
  if (rotations)
  {
    const std::vector<float> spin = few.rotations();
    restoreRotations(this->bricks_, this->rotationsBefore_);
    few.setRotations(spin);
  }
}

/// Adds those elements of a component that are in bricks with a state.
void CoarseToFine::addElements(int component, Elements& elements) const
{
  const Grid& grid = this->bricks_.model().grid();
  this->components_->anyRun(component,
    [&](const ElementRun& run)
    {
      const Index3 first = grid.indexOf(run.first);
      for (int i = first[0]; i < first[0] + static_cast<int>(run.count); ++i)
      {
        if (this->bricks_.hasState(this->bricks_.brickAt(i, first[1], first[2])))
        {
          elements.add({ i, first[1], first[2] });
        }
      }
      return false;
    });
}

bool CoarseToFine::run(
  RigidClusters& clusters, const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
{
  if (this->levels_.empty())
  {
    this->build();
  }
  this->energyBefore_ = this->energy(elasticity);
  if (this->levels_.empty() || this->energyBefore_ == 0.0)
  {
    return false;
  }
  this->moves_ = this->movingComponents();
  if (std::find(this->moves_.begin(), this->moves_.end(), 1) == this->moves_.end())
  {
    return false;
  }
  this->start_.save();
  if (this->bricks_.rotations())
  {
    saveRotations(this->bricks_, this->rotationsBefore_);
    this->rotatedBefore_ = this->bricks_.activeRotations() != nullptr;
  }
  this->cycle(clusters, elasticity, tolerance, checkpoint);
  return true;
}

void CoarseToFine::correct(
  RigidClusters& clusters, const Elasticity& elasticity, double energy, const Checkpoint& checkpoint)
{
  this->energyBefore_ = energy;
  this->start_.save();
  this->bricks_.addTemporary(this->residual_);
  Context& context = this->bricks_.context();
  const std::vector<int> dirty = this->bricks_.dirtySlots();
  launchPass(this->bricks_, context.kernel("correction.cl", this->bricks_.definesOfRows(), "residuals"), dirty.size(),
    this->bricks_.workItems(true), this->list_.holding(context, dirty), this->bricks_.state(nullptr, nullptr),
    this->residual_.buffer);
  clusters.beginCorrection(this->handles_.voxels(), this->residual_);
  std::vector<const Field*> residuals(1, &this->residual_); // of each grid, from the finest on
  for (const std::unique_ptr<Level>& level : this->levels_)
  {
    level->restrictResidual(*residuals.back(), level == this->levels_.front());
    residuals.push_back(&level->residual());
  }
  Elasticity unlimited = elasticity;
  unlimited.limited = false;
  for (std::size_t n = this->levels_.size(); n-- > 0;)
  {
    this->levels_[n]->relaxCorrection(unlimited, checkpoint);
    this->levels_[n]->addCorrection(*residuals[n], n == 0 ? timesAdded : 1.0f); // the coarser ones start at rest
  }
  this->putOthersBack();
  this->smooth(clusters, elasticity, 0.0, checkpoint);
  this->feasible_ = this->feasibility_.run(this->propagation_, checkpoint);
}

CoarseToFine::Judgement CoarseToFine::judge(const Elasticity& elasticity)
{
  double kept = 1.0;
  const double whole = this->energy(elasticity);
  double after = whole;
  if (this->bricks_.rotations())
  {
    // If the rotation of a bone differs between two feasible states, not all states between them are feasible. So the
    // step is kept or discarded as a whole.
    if (!this->feasible_ || whole > this->energyBefore_)
    {
      kept = 0.0;
      after = this->energyBefore_;
      this->start_.restore();
      restoreRotations(this->bricks_, this->rotationsBefore_);
      this->bricks_.setRotated(this->rotatedBefore_);
    }
  }
  else if (whole > this->energyBefore_)
  {
    // The energy E of elastic tissue is quadratic in the share s of the step. E(1) > E(0), so its minimum is below 1/2:
    // s = 1/2 - 1/4 (E(1) - E(0)) / (E(1) - 2 E(1/2) + E(0)).
    this->start_.goBack(0.5f);
    const double half = this->energy(elasticity);
    const double bend = whole - 2.0 * half + this->energyBefore_;
    const double lowest = bend > 0.0 ? 0.5 - 0.25 * (whole - this->energyBefore_) / bend : 0.0;
    kept = std::max(0.0, shareStep * std::floor(lowest / shareStep));
    this->start_.goBack(static_cast<float>(2.0 * kept)); // the state is half way already
    after = kept > 0.0 ? this->energy(elasticity) : this->energyBefore_;
    if (after > this->energyBefore_) // in plastic tissue E is not quadratic
    {
      kept = 0.0;
      after = this->energyBefore_;
      this->start_.goBack(0.0f);
    }
  }
  return { kept, after, 1.0 - after / this->energyBefore_ };
}

}
