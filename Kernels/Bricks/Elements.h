#pragma once

#include "Bricks.h"

#include <cstdint>
#include <vector>

namespace chainmail
{

/// A list of single elements, through which the host reads and writes their values: one transfer for the whole list,
/// interleaved values in its order. The list only refers to the elements, so a const list writes, too. It must not
/// write values of an element that it contains twice.
///
/// An element has the address that is current when it is added (BrickTable::address). The address changes when its
/// brick gets a slot or, later, a state (Tissue::makeUpdatable), and it may change while its brick has no state
/// (Tissue::allocateStates). So a list that is kept contains elements of bricks with a state. A list may also contain
/// other elements, if it is used before the next brick gets a slot or a state: these are at rest, and air where their
/// bricks have no slot. Their state must not be written.
class Elements
{
public:
  /// An empty list. `bricks` must outlive it.
  explicit Elements(Bricks& bricks)
    : bricks_(&bricks)
  {
  }
  /// These voxels (Grid::at).
  Elements(Bricks& bricks, const std::vector<std::size_t>& voxels);

  void add(const Index3& at) { this->addresses_.push_back(this->bricks_->address(at[0], at[1], at[2])); }
  void add(std::size_t voxel) { this->add(this->bricks_->model().grid().indexOf(voxel)); }
  void add(const Elements& more)
  {
    this->addresses_.insert(this->addresses_.end(), more.addresses_.begin(), more.addresses_.end());
  }
  void clear() { this->addresses_.clear(); }
  std::size_t size() const { return this->addresses_.size(); }

  /// Displacements, 3 values each.
  std::vector<float> displacements() const { return this->values(this->bricks_->displacement_); }
  void setDisplacements(const std::vector<float>& values) const { this->set(this->bricks_->displacement_, values); }

  /// Signed constraints, `axes()` values each. They are values of the tissue, so bricks need no state for them.
  std::vector<float> constraints() const { return this->bricks_->constraints(this->addresses_); }
  void setConstraints(const std::vector<float>& values) const
  {
    this->bricks_->setConstraints(this->addresses_, values);
  }

  /// Rotations, 3 values each. Elements must rotate (Bricks::rotations()).
  std::vector<float> rotations() const { return this->values(this->bricks_->rotations_->spin); }
  void setRotations(const std::vector<float>& values) const;

  /// Pressures; only where Poisson's ratio is not 0.
  std::vector<float> pressures() const
  {
    return this->bricks_->valuesAt(this->bricks_->rotations_->pressure, this->addresses_, 1);
  }

  /// Values of a state field, of floats to be read, `runs` values each.
  std::vector<float> values(const Field& field) const { return this->bricks_->valuesAt(field, this->addresses_); }
  template <typename T> void set(const Field& field, const std::vector<T>& values) const
  {
    this->bricks_->set(field, this->addresses_, values);
  }

private:
  Bricks* bricks_;
  std::vector<std::uint32_t> addresses_;
};

}
