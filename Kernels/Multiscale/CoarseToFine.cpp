#include "CoarseToFine.h"

#include "Measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace chainmail
{

namespace
{

/// How a coarser grid is relaxed.
struct Sweeps
{
  Reach reach;
  int count;
};

/// `depth`: how many grids lie between it and the finest. Deeper ones, whose sweeps cost little, settle what is far
/// apart; on small ones sweeps cost next to nothing.
Sweeps sweepsOn(const Grid& grid, std::size_t depth)
{
  if (*std::max_element(grid.size.begin(), grid.size.end()) <= 16)
  {
    return { Reach::Far, 40 };
  }
  return depth == 0 ? Sweeps{ Reach::Near, 10 } : Sweeps{ Reach::Far, 30 };
}

/// A grid with no axis longer than this is the coarsest.
constexpr int coarsestSize = 8;

/// Sweeps on the finest grid that undo what interpolation bent, before limits count.
constexpr int smoothingSweeps = 2;

/// Shares of the way back are multiples of this, so that no rounding of energies changes them.
constexpr double shareStep = 1.0 / 16.0;

/// Hands that go too far for a coarser grid by this, a fraction of its spacing, do so by more than rounding.
constexpr double tooFar = 1e-4;

Grid halved(const Grid& finer)
{
  Grid grid;
  for (int a = 0; a < 3; ++a)
  {
    grid.size[a] = (finer.size[a] + 1) / 2;
    grid.spacing[a] = 2.0 * finer.spacing[a];
  }
  return grid;
}

/// The signed constraint of an element from those of the up to eight that it stands for, on one axis.
///
/// One number has to say two things. How far the element stretches: chains at their limits take the shortest way, so
/// that is its shortest row of links. And what that costs: its rows share the strain side by side, so that is their
/// harmonic mean. Where tissue is of one kind both are the same; else it is the mean of the two, over the rows along
/// all axes. With the mean of the eight alone, coarser grids let a handle's pull reach too little: 128^3 patchy tissue
/// with two bones then enters the finest grid with an energy of 1.33 times the least, so with 1.05 times.
class Children
{
public:
  /// `place`: bit a is the element's place along axis a.
  void add(int place, float c)
  {
    if (std::isinf(c))
    {
      return;
    }
    ++this->count_;
    this->rigid_ += c == 0.0f ? 1 : 0;
    this->sum_ += std::fabs(c);
    this->held_ = this->held_ || std::signbit(c);
    this->constraint_[place] = std::fabs(c);
  }

  float signedConstraint() const
  {
    if (this->count_ == 0)
    {
      return -std::numeric_limits<float>::infinity();
    }
    const float c = 2 * this->rigid_ >= this->count_ ? 0.0f : this->ofRows();
    return rule::asHeld(c, this->held_);
  }

private:
  static constexpr float none = -1.0f;
  static constexpr float least = 1e-6f; ///< of an element that is not rigid, and keeps a row's share finite

  float ofRows() const
  {
    float sum = 0.0f;
    int axes = 0;
    for (int a = 0; a < 3; ++a)
    {
      float shortest = std::numeric_limits<float>::infinity();
      float shares = 0.0f;
      int rows = 0;
      for (int place = 0; place < 8; ++place)
      {
        const float c = this->constraint_[place];
        const float next = this->constraint_[place | 1 << a];
        if ((place & 1 << a) == 0 && c != none && next != none)
        {
          const float row = rule::linkLimit(c, next) + least;
          shortest = std::min(shortest, row);
          shares += 1.0f / row;
          ++rows;
        }
      }
      if (rows > 0)
      {
        sum += 0.5f * (shortest + rows / shares);
        ++axes;
      }
    }
    return axes > 0 ? sum / axes : this->sum_ / this->count_;
  }

  int count_ = 0;
  int rigid_ = 0;
  float sum_ = 0.0f;
  bool held_ = false;
  std::array<float, 8> constraint_{ none, none, none, none, none, none, none, none };
};

std::shared_ptr<const Model> coarserModel(const Bricks& finer)
{
  const Grid fine = finer.model().grid();
  const Grid grid = halved(fine);
  const int axes = finer.model().axes();
  return std::make_shared<const Model>(grid, axes,
    [&finer, fine, grid, axes](std::size_t first, int count, float* out)
    {
      const Index3 at = grid.indexOf(first);
      const int begin = 2 * at[0];
      const int length = std::min(2 * count, fine.size[0] - begin);
      std::vector<Children> children(static_cast<std::size_t>(count) * axes);
      std::vector<float> row(static_cast<std::size_t>(length) * axes);
      for (int k = 2 * at[2]; k < std::min(2 * at[2] + 2, fine.size[2]); ++k)
      {
        for (int j = 2 * at[1]; j < std::min(2 * at[1] + 2, fine.size[1]); ++j)
        {
          finer.row(begin, j, k, length, row.data());
          for (int n = 0; n < length * axes; ++n)
          {
            const int place = (n / axes & 1) | (j & 1) << 1 | (k & 1) << 2;
            children[static_cast<std::size_t>(n / axes / 2 * axes + n % axes)].add(place, row[n]);
          }
        }
      }
      std::transform(children.begin(), children.end(), out, [](const Children& c) { return c.signedConstraint(); });
    });
}

/// Removes the links of a coarser grid that cuts of the finer one leave nothing of: all those across the boundary of
/// two elements are gone, or all those within an element along that axis, which then stays with the lower side.
void coarsenCuts(const Bricks& finer, Bricks& coarser)
{
  const Grid& fine = finer.model().grid();
  std::set<std::pair<std::size_t, int>> candidates; // voxel of the coarser grid, axis
  for (const auto& [brick, bits] : finer.cuts())
  {
    const Index3 origin = finer.origin(brick);
    for (int k = origin[2]; k < std::min(origin[2] + finer.size()[2], fine.size[2]); ++k)
    {
      for (int j = origin[1]; j < std::min(origin[1] + finer.size()[1], fine.size[1]); ++j)
      {
        for (int i = origin[0]; i < std::min(origin[0] + finer.size()[0], fine.size[0]); ++i)
        {
          for (int a = 0; a < 3; ++a)
          {
            if ((bits[finer.local(i, j, k)] & (2 << (2 * a))) != 0)
            {
              candidates.insert({ coarser.model().grid().at(i / 2, j / 2, k / 2), a });
            }
          }
        }
      }
    }
  }

  const auto isElement = [&](const Index3& at) { return fine.contains(at[0], at[1], at[2]) && finer.isElement(at); };
  const auto anyLink = [&](const Index3& coarse, int axis, int offset)
  {
    for (int n = 0; n < 4; ++n)
    {
      Index3 at{ 2 * coarse[0], 2 * coarse[1], 2 * coarse[2] };
      at[axis] += offset;
      at[(axis + 1) % 3] += n & 1;
      at[(axis + 2) % 3] += n >> 1;
      Index3 next = at;
      ++next[axis];
      if (isElement(at) && isElement(next) && (finer.cutBits(at[0], at[1], at[2]) & (2 << (2 * axis))) == 0)
      {
        return true;
      }
    }
    return false;
  };
  for (const auto& [voxel, axis] : candidates)
  {
    const Index3 at = coarser.model().grid().indexOf(voxel);
    if (at[axis] + 1 < coarser.model().grid().size[axis] && (!anyLink(at, axis, 1) || !anyLink(at, axis, 0)))
    {
      coarser.removeLink(at[0], at[1], at[2], 2 * axis + 1);
    }
  }
  coarser.uploadCuts();
}

}

/// A grid and the finer one that it stands for.
class CoarseToFine::Level
{
public:
  explicit Level(Bricks& finer)
    : finer_(finer)
    , model_(coarserModel(finer))
    , bricks_(finer.sharedContext(), this->model_, finer.size())
    , propagation_(this->bricks_)
    , feasibility_(this->bricks_)
    , relaxation_(this->bricks_)
  {
    coarsenCuts(finer, this->bricks_);
    this->clusters_ = std::make_unique<RigidClusters>(this->bricks_);
  }

  Bricks& bricks() { return this->bricks_; }

  /// Takes the state of the finer grid. `held`: voxels of this one that probes hold.
  void coarsen(const std::vector<std::size_t>& held)
  {
    this->bricks_.clearDisplacements();
    this->hold(held);
    std::set<int> needed;
    for (const int slot : this->finer_.touchedSlots())
    {
      const Index3 origin = this->finer_.origin(this->finer_.brick(slot));
      needed.insert(this->bricks_.brickAt(origin[0] / 2, origin[1] / 2, origin[2] / 2));
    }
    const std::vector<int> bricks(needed.begin(), needed.end());
    this->bricks_.require(bricks);
    std::vector<int> slots;
    for (const int brick : bricks)
    {
      if (this->bricks_.slot(brick) > 0)
      {
        slots.push_back(this->bricks_.slot(brick));
        this->bricks_.touch(slots.back());
      }
    }
    Context& context = this->bricks_.context();
    context.launch(context.kernel("coarsen.cl", this->bricks_.defines(false), "coarsen"), slots.size(),
      this->bricks_.workItems(false), this->list_.holding(context, slots), this->bricks_.layout(),
      this->finer_.layout(), this->finer_.displacement, this->finer_.constraint, this->bricks_.displacement);
  }

  /// Makes the state feasible. Hands and bones are thicker here and tissue between them is thinner, so that it may not
  /// stretch as far as a handle goes: then the handle gives way. Else it would drag anchored bone along, and all around
  /// it.
  void makeFeasible(const Checkpoint& checkpoint)
  {
    this->feasibility_.run(this->propagation_, checkpoint);
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
    const Sweeps sweeps = sweepsOn(this->model_->grid(), depth);
    this->relaxation_.run(
      *this->clusters_, elasticity, nullptr, sweeps.reach, 0, sweeps.count, tolerance, [&](int) { checkpoint(); });
  }

  /// Takes the finer grid where this one is. That need not be feasible.
  void refine()
  {
    std::set<int> needed;
    const Index3 size = this->bricks_.size();
    const Grid& fine = this->finer_.model().grid();
    for (const int slot : this->bricks_.touchedSlots())
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
    this->finer_.require(bricks);
    std::vector<int> slots;
    for (const int brick : bricks)
    {
      if (this->finer_.slot(brick) > 0)
      {
        slots.push_back(this->finer_.slot(brick));
        this->finer_.touch(slots.back());
      }
    }
    Context& context = this->bricks_.context();
    // The finer grid's cuts do not matter here.
    context.launch(context.kernel("coarsen.cl", this->bricks_.defines(true), "refine"), slots.size(),
      this->bricks_.workItems(true), this->list_.holding(context, slots), this->finer_.layout(), this->bricks_.layout(),
      this->bricks_.state(), this->finer_.constraint, this->finer_.displacement);
  }

private:
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
    this->bricks_.require(bricks);
    std::vector<std::uint32_t> addresses;
    std::vector<float> values(voxels.size() * axes);
    for (std::size_t n = 0; n < voxels.size(); ++n)
    {
      const Index3 at = grid.indexOf(voxels[n]);
      addresses.push_back(this->bricks_.address(at[0], at[1], at[2]));
      this->bricks_.row(at[0], at[1], at[2], 1, values.data() + n * axes);
    }
    std::transform(values.begin(), values.end(), values.begin(), [held](float c) { return rule::asHeld(c, held); });
    this->bricks_.setConstraints(addresses, values);
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
};

CoarseToFine::CoarseToFine(Bricks& bricks, Handles& handles)
  : bricks_(bricks)
  , handles_(handles)
  , propagation_(bricks)
  , feasibility_(bricks)
  , relaxation_(bricks)
  , pieces_(bricks, "components.cl", "join")
{
}

CoarseToFine::~CoarseToFine()
{
  this->bricks_.drop(this->before_);
  this->bricks_.drop(this->marks_);
}

void CoarseToFine::forget()
{
  this->levels_.clear();
}

void CoarseToFine::build()
{
  Bricks* finest = &this->bricks_;
  for (;;)
  {
    const Index3& size = finest->model().grid().size;
    if (*std::max_element(size.begin(), size.end()) <= coarsestSize)
    {
      return;
    }
    this->levels_.push_back(std::make_unique<Level>(*finest));
    finest = &this->levels_.back()->bricks();
  }
}

double CoarseToFine::energy(const Elasticity& elasticity) const
{
  double energy = 0.0;
  for (const BrickFigures& figures : measureBricks(this->bricks_, elasticity))
  {
    for (int a = 0; a < 3; ++a)
    {
      energy += figures.energy[a] * this->bricks_.model().grid().spacing[a];
    }
  }
  return energy;
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
  this->levels_.back()->makeFeasible(checkpoint); // all others are taken where the next coarser one is
  for (std::size_t n = this->levels_.size(); n-- > 0;)
  {
    Level& level = *this->levels_[n];
    level.relax(n, elasticity, tolerance, checkpoint);
    level.refine();
    if (n > 0)
    {
      this->levels_[n - 1]->makeFeasible(checkpoint);
    }
    else
    {
      this->putOthersBack(checkpoint);
      Elasticity unlimited = elasticity;
      unlimited.limited = false;
      clusters.begin(this->handles_.voxels());
      this->relaxation_.run(
        clusters, unlimited, nullptr, Reach::Near, 0, smoothingSweeps, tolerance, [&](int) { checkpoint(); });
      this->feasibility_.run(this->propagation_, checkpoint);
    }
  }
}

/// Tissue that does not hang on what moves (components.cl).
void CoarseToFine::putOthersBack(const Checkpoint& checkpoint)
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.touchedSlots();
  std::vector<int> bricks;
  for (const int slot : slots)
  {
    bricks.push_back(this->bricks_.brick(slot));
  }
  this->bricks_.keep(this->marks_);
  const std::string defines = this->bricks_.defines(true);
  const cl::Buffer& list = this->list_.holding(context, slots);
  context.launch(context.kernel("components.cl", defines, "mark"), slots.size(), this->bricks_.workItems(true), list,
    this->bricks_.layout(), this->before_.buffer, this->bricks_.tissue(), this->marks_.buffer);
  this->pieces_.start(bricks);
  this->pieces_.run(0, std::numeric_limits<float>::infinity(), checkpoint,
    [this](ArgumentList& own) { own.add(this->bricks_.tissue(), this->marks_.buffer); });
  context.launch(context.kernel("components.cl", defines, "putBack"), slots.size(), this->bricks_.workItems(true), list,
    this->bricks_.pitch(), this->marks_.buffer, this->before_.buffer, this->bricks_.displacement);
  this->bricks_.drop(this->marks_);
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
  this->bricks_.keep(this->before_);
  Context& context = this->bricks_.context();
  context.queue().enqueueCopyBuffer(
    this->bricks_.displacement, this->before_.buffer, 0, 0, sizeof(cl_float) * 3 * this->bricks_.pitch());
  this->cycle(clusters, elasticity, tolerance, checkpoint);
  return true;
}

double CoarseToFine::judge(const Elasticity& elasticity)
{
  double kept = 1.0;
  const double whole = this->energy(elasticity);
  if (whole > this->energyBefore_)
  {
    // The lowest point of the parabola through both ends and the middle lies before the middle.
    this->goBack(0.5f);
    const double half = this->energy(elasticity);
    const double bend = whole - 2.0 * half + this->energyBefore_;
    const double lowest = bend > 0.0 ? 0.5 - 0.25 * (whole - this->energyBefore_) / bend : 0.0;
    kept = std::max(0.0, shareStep * std::floor(lowest / shareStep));
    this->goBack(static_cast<float>(2.0 * kept));
    if (kept > 0.0 && this->energy(elasticity) > this->energyBefore_) // plastic tissue knows no parabola
    {
      kept = 0.0;
      this->goBack(0.0f);
    }
  }
  this->bricks_.drop(this->before_);
  return kept;
}

/// Leaves elements this share of the way from where they were before. Those that moved alike still do.
void CoarseToFine::goBack(float share)
{
  Context& context = this->bricks_.context();
  const std::vector<int> slots = this->bricks_.touchedSlots();
  context.launch(context.kernel("coarsen.cl", this->bricks_.defines(true), "goBack"), slots.size(),
    this->bricks_.workItems(true), this->list_.holding(context, slots), this->bricks_.pitch(), share,
    this->before_.buffer, this->bricks_.displacement);
}

}
