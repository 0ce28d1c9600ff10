#include "Tissue.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

constexpr float air = -std::numeric_limits<float>::infinity();

}

Tissue::Tissue(std::shared_ptr<Context> context, std::shared_ptr<const Model> model, const Index3& brickSize)
  : BrickStorage(std::move(context), model->grid(), brickSize, model->axes())
  , model_(std::move(model))
  , links_(*this)
  , cutDistances_(*this)
  , constraint_{ static_cast<std::size_t>(this->model_->axes()), sizeof(float),
    "the constraints of the tissue reached" }
{
  this->status_.assign(this->table_.size(), Status::Air);
  for (int k = 0; k < this->counts_[2]; ++k)
  {
    for (int j = 0; j < this->counts_[1]; ++j)
    {
      for (int i = 0; i < this->counts_[0]; ++i)
      {
        this->status_[(i + 1) + this->strideY_ * (j + 1) + this->strideZ_ * (k + 1)] = Status::Unknown;
      }
    }
  }
  this->addTissueField(this->constraint_);
  this->fillFirstSlot();
  this->separateJoints();
}

/// Slot 0 stands for bricks without tissue.
void Tissue::fillFirstSlot()
{
  for (int a = 0; a < this->model_->axes(); ++a)
  {
    this->writeTissue(this->constraint_, a, 0, std::vector<float>(this->elements_, air));
  }
}

// --- Loading

/// Reads the constraints of a brick's elements. Returns whether the brick has any element.
bool Tissue::fill(int brick, std::vector<float>& out) const
{
  const Grid& grid = this->model_->grid();
  const int axes = this->model_->axes();
  std::fill(out.begin(), out.end(), air);
  std::vector<float> constraints(static_cast<std::size_t>(this->size_[0]) * axes);
  // A brick from which everything was carved keeps its memory, because restoreTopology() may fill it again.
  bool tissue = this->links_.carvedBricks().count(brick) > 0;
  for (const Row& row : this->rows(brick))
  {
    const Index3 first = grid.indexOf(row.voxel);
    this->row(first[0], first[1], first[2], row.count, constraints.data());
    for (int a = 0; a < axes; ++a)
    {
      float* const to = out.data() + static_cast<std::size_t>(a) * this->elements_;
      for (int i = 0; i < row.count; ++i)
      {
        to[row.local(i)] = constraints[static_cast<std::size_t>(i) * axes + a];
      }
    }
    for (int i = 0; !tissue && i < row.count; ++i)
    {
      tissue = !std::isinf(constraints[static_cast<std::size_t>(i) * axes]);
    }
  }
  return tissue;
}

/// Loads the tissue of bricks with Status::Unknown.
void Tissue::readTissue(const std::vector<int>& bricks)
{
  // New slots are consecutive, so many bricks are uploaded in one transfer.
  constexpr std::size_t batch = 256;
  const std::size_t axes = this->model_->axes();
  const std::size_t count = this->elements_;
  std::vector<int> found;
  std::vector<float> constraints(axes * count);
  std::vector<std::vector<float>> staging(axes);
  const auto flush = [&]
  {
    const int first = this->slots();
    this->addSlots(found);
    for (std::size_t a = 0; a < axes; ++a)
    {
      this->writeTissue(this->constraint_, a, first, staging[a]);
      staging[a].clear();
    }
    for (const int brick : found)
    {
      this->known_.push_back(brick);
      this->status_[brick] = Status::Known;
      const auto bits = this->links_.all().find(brick);
      if (bits != this->links_.all().end() && this->cut_.buffer())
      {
        this->writeCuts(brick, bits->second);
      }
    }
    found.clear();
  };
  for (const int brick : bricks)
  {
    if (!this->fill(brick, constraints))
    {
      this->status_[brick] = Status::Air;
      continue;
    }
    found.push_back(brick);
    for (std::size_t a = 0; a < axes; ++a)
    {
      staging[a].insert(staging[a].end(), constraints.begin() + a * count, constraints.begin() + (a + 1) * count);
    }
    if (found.size() == batch)
    {
      flush();
    }
  }
  flush();
}

void Tissue::loadTissue(const std::vector<int>& bricks)
{
  std::vector<int> unknown;
  for (const int brick : bricks)
  {
    if (this->isUpdatable(brick))
    {
      continue;
    }
    for (int z = -1; z <= 1; ++z)
    {
      for (int y = -1; y <= 1; ++y)
      {
        for (int x = -1; x <= 1; ++x)
        {
          const int near = this->beside(brick, x, y, z);
          if (this->status_[near] == Status::Unknown)
          {
            unknown.push_back(near);
          }
        }
      }
    }
  }
  const int before = this->slots();
  std::sort(unknown.begin(), unknown.end());
  unknown.erase(std::unique(unknown.begin(), unknown.end()), unknown.end());
  this->readTissue(unknown);
  if (this->slots() > before)
  {
    this->uploadTables();
  }
}

void Tissue::unloadTissue()
{
  for (const int brick : this->known_)
  {
    this->status_[brick] = Status::Unknown;
  }
  this->known_.clear();
  this->takeSlots();
  this->fillFirstSlot();
}

void Tissue::makeUpdatable(const std::vector<int>& bricks)
{
  this->loadTissue(bricks);
  this->allocateStates(bricks);
  for (const int brick : bricks)
  {
    this->status_[brick] = this->status_[brick] == Status::Known ? Status::Ready : this->status_[brick];
  }
}

// --- Elements and links

void Tissue::row(int i, int j, int k, int count, float* out) const
{
  this->model_->row(i, j, k, count, out);
  this->links_.takeOut(i, j, k, count, this->model_->axes(), out);
}

bool Tissue::isElement(const Index3& at) const
{
  float c[3];
  this->row(at[0], at[1], at[2], 1, c);
  return !std::isinf(c[0]);
}

// --- Cuts and carves

void Tissue::replaceByAir(const std::vector<std::size_t>& voxels)
{
  std::vector<std::uint32_t> loaded;
  for (const std::size_t voxel : voxels)
  {
    const Index3 at = this->model_->grid().indexOf(voxel);
    this->links_.removeElement(at[0], at[1], at[2]);
    if (this->slot(this->brickAt(at[0], at[1], at[2])) > 0)
    {
      loaded.push_back(this->address(at[0], at[1], at[2]));
    }
  }
  this->uploadCuts();
  this->setConstraints(loaded, std::vector<float>(this->model_->axes() * loaded.size(), air));
}

void Tissue::restoreTopology()
{
  this->removeTissueField(this->cut_);
  this->removeTissueField(this->shownCut_);
  const std::set<int> carved = this->links_.carvedBricks();
  this->links_.clear();
  this->cutDistances_.clear();
  this->fillAgain(carved);
  this->separateJoints();
}

void Tissue::replaceTopology(Topology topology)
{
  this->restoreTopology();
  this->links_.replace(std::move(topology.bits));
  for (auto& [brick, values] : topology.distances)
  {
    this->cutDistances_.at(brick).setValues(std::move(values));
  }
  this->fillAgain(this->links_.carvedBricks());
  this->uploadCuts();
}

/// Writes the constraints of bricks with a slot again, as row() gives them now.
void Tissue::fillAgain(const std::set<int>& bricks)
{
  const std::size_t axes = this->model_->axes();
  const std::size_t count = this->elements_;
  std::vector<float> constraints(axes * count);
  for (const int brick : bricks)
  {
    if (this->slot(brick) > 0)
    {
      this->fill(brick, constraints);
      for (std::size_t a = 0; a < axes; ++a)
      {
        this->writeTissue(this->constraint_, a, this->slot(brick),
          std::vector<float>(constraints.begin() + a * count, constraints.begin() + (a + 1) * count));
      }
    }
  }
}

void Tissue::uploadCuts()
{
  if (!this->anyCut())
  {
    return;
  }
  this->addTissueField(this->cut_);
  if (this->links_.anyAtJoint())
  {
    this->addTissueField(this->shownCut_);
  }
  for (const auto& [brick, bits] : this->links_.all())
  {
    if (this->slot(brick) > 0)
    {
      this->writeCuts(brick, bits);
    }
  }
}

/// Copies the removed links of a brick with a slot to the device.
void Tissue::writeCuts(int brick, const std::vector<std::uint8_t>& bits)
{
  this->writeTissue(this->cut_, 0, this->slot(brick), bits);
  if (this->shownCut_.buffer())
  {
    this->writeTissue(this->shownCut_, 0, this->slot(brick), this->links_.shown(brick));
  }
}

/// Removes the links across free joints.
void Tissue::separateJoints()
{
  for (const auto& [voxel, axis] : this->model_->linksOfJoints())
  {
    const Index3 at = this->model_->grid().indexOf(voxel);
    this->links_.removeAtJoint(at[0], at[1], at[2], 2 * axis + 1);
  }
  this->uploadCuts();
}

}
