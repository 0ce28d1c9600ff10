#include "Bricks.h"

#include "Elements.h"

namespace chainmail
{

Bricks::Bricks(std::shared_ptr<Context> context, std::shared_ptr<const Model> model, Index3 brickSize,
  const RotationSettings& rotationSettings)
  : Tissue(std::move(context), std::move(model), brickSize)
  , before_(*this, this->displacement_)
  , rotationSettings_(rotationSettings)
{
  this->addField(this->displacement_);
  if (rotationSettings.on)
  {
    this->rotations_ = std::make_unique<Rotations>();
    this->rotations_->proportions = proportionsOf(this->model().grid());
    this->rotations_->proportions.s[3] =
      static_cast<float>(2.0 * rotationSettings.poissonRatio / (1.0 - 2.0 * rotationSettings.poissonRatio));
    this->addField(this->rotations_->spin);
    if (this->rotations_->hasPressure())
    {
      this->addField(this->rotations_->pressure);
    }
  }
}

// --- Displacements

void Bricks::saveIn(Field& field)
{
  this->addField(field, Field::Start::Anything);
  field.start = Field::Start::Zeros; // bricks that get a state later are at rest in the saved field
  this->copy(this->displacement_, field);
}

void Bricks::saveIn(Field& field, const std::vector<int>& slots)
{
  this->addField(field, Field::Start::Anything);
  this->copy(this->displacement_, field, slots);
}

void Bricks::writeSlots(const std::vector<int>& slots, const float* values)
{
  const auto count = static_cast<std::size_t>(this->elementsPerBrick());
  for (std::size_t begin = 0, end = 0; begin < slots.size(); begin = end)
  {
    // Consecutive slots are one transfer for each axis.
    for (end = begin + 1; end < slots.size() && slots[end] == slots[end - 1] + 1;)
    {
      ++end;
    }
    for (std::size_t a = 0; a < 3; ++a)
    {
      this->context().write(this->displacement_.buffer, sizeof(float) * (a * this->pitch() + slots[begin] * count),
        values + (a * slots.size() + begin) * count, (end - begin) * count);
    }
  }
  this->markDirty(slots);
}

void Bricks::clearDisplacements()
{
  this->clear(this->displacement_);
  if (this->rotations_)
  {
    this->clear(this->rotations_->spin);
    this->clear(this->rotations_->pressure);
    this->rotations_->any = false;
  }
  this->dirty_.clear();
}

void Bricks::unload()
{
  this->unloadTissue();
  this->dirty_.clear();
}

void Bricks::removeElements(const std::vector<std::size_t>& voxels)
{
  this->replaceByAir(voxels);
  Elements movable(*this);
  for (const std::size_t voxel : voxels)
  {
    const Index3 at = this->model().grid().indexOf(voxel);
    if (this->hasState(this->brickAt(at[0], at[1], at[2])))
    {
      movable.add(at);
    }
  }
  const std::vector<float> atRest(3 * movable.size(), 0.0f);
  movable.setDisplacements(atRest);
  if (this->rotations_)
  {
    movable.setRotations(atRest);
  }
}

// --- Slots that may be displaced

std::vector<int> Bricks::dirtySlots() const
{
  std::vector<int> slots;
  for (std::size_t slot = 1; slot < this->dirty_.size(); ++slot)
  {
    if (this->dirty_[slot] != 0)
    {
      slots.push_back(static_cast<int>(slot));
    }
  }
  return slots;
}

void Bricks::markDirty(int slot)
{
  if (slot >= static_cast<int>(this->dirty_.size()))
  {
    this->dirty_.resize(this->states(), 0);
  }
  this->dirty_[slot] = 1;
}

void Bricks::markDirty(const std::vector<int>& slots)
{
  for (const int slot : slots)
  {
    this->markDirty(slot);
  }
}

// --- Rotations

void Bricks::setRotated(bool any)
{
  if (this->rotations_)
  {
    this->rotations_->any = any;
  }
}

// --- Soft links

void Bricks::setSoftLinks(std::vector<SoftLink> links)
{
  this->soft_.reset(); // frees the old ones first, so both never exist at once
  if (links.empty())
  {
    return;
  }
  this->soft_ = std::make_unique<SoftLinks>(this->context(), *this, this->model().grid(), std::move(links));
  for (const SoftLink& link : this->soft_->all())
  {
    const Index3 at = this->model().grid().indexOf(link.voxel);
    this->markDirty(this->slot(this->brickAt(at[0], at[1], at[2])));
  }
}

void Bricks::makeSoftLinks(const std::vector<int>& bricks)
{
  this->soft_.reset();
  this->soft_ = std::make_unique<SoftLinks>(this->context(), *this, this->model().grid(), bricks);
}

void Bricks::readSoftLinks(const std::vector<std::size_t>& voxels)
{
  this->soft_->read(this->context(), *this, this->model().grid(), voxels);
}

}
