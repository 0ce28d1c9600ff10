#include "CoarseToFine.h"

#include "Measurement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace chainmail
{

namespace
{

/// Sweeps on each coarser grid. They cost an eighth, a sixty-fourth, ... of one on the finest.
constexpr int sweepsPerLevel = 40;

/// A grid with no axis longer than this is the coarsest.
constexpr int coarsestSize = 8;

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
class Children
{
public:
  void add(float c)
  {
    if (std::isinf(c))
    {
      return;
    }
    ++this->count_;
    this->rigid_ += c == 0.0f ? 1 : 0;
    this->sum_ += std::fabs(c);
    this->held_ = this->held_ || std::signbit(c);
  }

  float signedConstraint() const
  {
    if (this->count_ == 0)
    {
      return -std::numeric_limits<float>::infinity();
    }
    const float c = 2 * this->rigid_ >= this->count_ ? 0.0f : this->sum_ / static_cast<float>(this->count_);
    return this->held_ ? -c : c;
  }

private:
  int count_ = 0;
  int rigid_ = 0;
  float sum_ = 0.0f;
  bool held_ = false;
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
            children[static_cast<std::size_t>(n / axes / 2 * axes + n % axes)].add(row[n]);
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

  const int axes = finer.model().axes();
  std::vector<float> c(axes);
  const auto isElement = [&](const Index3& at)
  {
    if (!fine.contains(at[0], at[1], at[2]))
    {
      return false;
    }
    finer.row(at[0], at[1], at[2], 1, c.data());
    return !std::isinf(c[0]);
  };
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
    , repair_(this->bricks_)
    , relaxation_(this->bricks_)
  {
    coarsenCuts(finer, this->bricks_);
    this->clusters_ = std::make_unique<RigidClusters>(this->bricks_);
  }

  Bricks& bricks() { return this->bricks_; }

  /// Takes the state of the finer grid. `held`: voxels of this one that probes hold.
  void coarsen(const std::vector<std::size_t>& held, const Checkpoint& checkpoint)
  {
    this->bricks_.clearDisplacements();
    this->hold(held);
    std::set<int> needed;
    for (int slot = 1; slot < this->finer_.slots(); ++slot)
    {
      if (this->finer_.touched(slot))
      {
        const Index3 origin = this->finer_.origin(this->finer_.brick(slot));
        needed.insert(this->bricks_.brickAt(origin[0] / 2, origin[1] / 2, origin[2] / 2));
      }
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
    cl::Kernel kernel = context.kernel("coarsen.cl", this->bricks_.defines(false), "coarsen");
    int argument = 0;
    kernel.setArg(argument++, this->list_.holding(context, slots));
    kernel.setArg(argument++, this->bricks_.pitch());
    this->bricks_.bindTable(kernel, argument);
    kernel.setArg(argument++, this->finer_.pitch());
    this->finer_.bindTable(kernel, argument);
    kernel.setArg(argument++, this->finer_.displacement);
    kernel.setArg(argument++, this->finer_.constraint);
    kernel.setArg(argument++, this->bricks_.displacement);
    context.runGroups(kernel, slots.size(), this->bricks_.workItems(false));
    this->repair_.run(this->propagation_, checkpoint);
  }

  void relax(const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
  {
    this->clusters_->begin(this->held_);
    this->relaxation_.run(
      *this->clusters_, elasticity, nullptr, 0, sweepsPerLevel, tolerance, [&](int) { checkpoint(); });
  }

  /// Takes the finer grid where this one is, and makes that feasible.
  void refine(Propagation& propagation, Repair& repair, const Checkpoint& checkpoint)
  {
    std::set<int> needed;
    const Index3 size = this->bricks_.size();
    const Grid& fine = this->finer_.model().grid();
    for (int slot = 1; slot < this->bricks_.slots(); ++slot)
    {
      if (!this->bricks_.touched(slot))
      {
        continue;
      }
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
    cl::Kernel kernel = context.kernel("coarsen.cl", this->bricks_.defines(false), "refine");
    int argument = 0;
    kernel.setArg(argument++, this->list_.holding(context, slots));
    kernel.setArg(argument++, this->finer_.pitch());
    this->finer_.bindTable(kernel, argument);
    kernel.setArg(argument++, this->bricks_.pitch());
    this->bricks_.bindTable(kernel, argument);
    kernel.setArg(argument++, this->bricks_.displacement);
    kernel.setArg(argument++, this->bricks_.constraint);
    kernel.setArg(argument++, this->bricks_.cutsOrNothing());
    kernel.setArg(argument++, this->finer_.constraint);
    kernel.setArg(argument++, this->finer_.displacement);
    context.runGroups(kernel, slots.size(), this->bricks_.workItems(false));
    repair.run(propagation, checkpoint);
  }

  Propagation& propagation() { return this->propagation_; }
  Repair& repair() { return this->repair_; }

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
      for (int a = 0; held && a < axes; ++a)
      {
        values[n * axes + a] = -std::fabs(values[n * axes + a]);
      }
    }
    this->bricks_.setConstraints(addresses, values);
  }

  Bricks& finer_;
  std::shared_ptr<const Model> model_;
  Bricks bricks_;
  std::vector<std::size_t> held_;
  Propagation propagation_;
  Repair repair_;
  Relaxation relaxation_;
  std::unique_ptr<RigidClusters> clusters_;
  Scratch list_{ "the list of bricks" };
};

CoarseToFine::CoarseToFine(Bricks& bricks, Holds& holds)
  : bricks_(bricks)
  , holds_(holds)
  , propagation_(bricks)
  , repair_(bricks)
{
}

CoarseToFine::~CoarseToFine() = default;

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

bool CoarseToFine::run(const Elasticity& elasticity, double tolerance, const Checkpoint& checkpoint)
{
  if (this->levels_.empty())
  {
    this->build();
  }
  const double before = this->energy(elasticity);
  if (this->levels_.empty() || before == 0.0)
  {
    return false;
  }
  Context& context = this->bricks_.context();
  Field saved{ 3, sizeof(cl_float), "the displacement before a relaxation" };
  this->bricks_.keep(saved);
  context.queue().enqueueCopyBuffer(
    this->bricks_.displacement, saved.buffer, 0, 0, sizeof(cl_float) * 3 * this->bricks_.pitch());

  const Grid* finer = &this->bricks_.model().grid();
  std::vector<std::size_t> held = this->holds_.voxels();
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
    level->coarsen(held, checkpoint);
  }
  for (std::size_t n = this->levels_.size(); n-- > 0;)
  {
    Level& level = *this->levels_[n];
    level.relax(elasticity, tolerance, checkpoint);
    if (n > 0)
    {
      level.refine(this->levels_[n - 1]->propagation(), this->levels_[n - 1]->repair(), checkpoint);
    }
    else
    {
      level.refine(this->propagation_, this->repair_, checkpoint);
    }
  }

  const bool lower = this->energy(elasticity) <= before;
  if (!lower)
  {
    context.queue().enqueueCopyBuffer(
      saved.buffer, this->bricks_.displacement, 0, 0, sizeof(cl_float) * 3 * this->bricks_.pitch());
    context.queue().finish();
  }
  this->bricks_.drop(saved);
  return lower;
}

std::size_t CoarseToFine::deviceBytes() const
{
  std::size_t bytes = 0;
  for (const std::unique_ptr<Level>& level : this->levels_)
  {
    bytes += level->bricks().deviceBytes();
  }
  return bytes;
}

}
