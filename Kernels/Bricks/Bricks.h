#pragma once

#include "Rotations.h"
#include "Snapshot.h"
#include "SoftLinks.h"
#include "Tissue.h"

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace chainmail
{

/// The tissue and the state of its elements on the device: displacements, rotations and soft links, in bricks that get
/// memory when they are first needed. All other parts of the engine access the state through this class; Elements reads
/// and writes single elements.
///
/// Only bricks whose elements may move have a state. Of the bricks around them only the tissue is loaded, and kernels
/// read rest where there is no state.
class Bricks : public Tissue
{
public:
  /// With `rotationSettings.on` elements have rotations (rotations()).
  Bricks(std::shared_ptr<Context> context, std::shared_ptr<const Model> model, Index3 brickSize,
    const RotationSettings& rotationSettings = {});

  // --- Displacements

  /// All displacements of one slot: 3 runs of elementsPerBrick() values, in the order of addresses.
  void readSlot(int slot, std::vector<float>& out) const
  {
    this->BrickStorage::readSlot(this->displacement_, slot, out);
  }
  /// Where an element is now [voxels]. `u` is what readSlot() gave for its slot.
  Vector3 place(int i, int j, int k, const std::vector<float>& u) const
  {
    const std::size_t at = this->local(i, j, k);
    const std::size_t count = static_cast<std::size_t>(this->elements_);
    return { static_cast<double>(i) + u[at], static_cast<double>(j) + u[count + at],
      static_cast<double>(k) + u[2 * count + at] };
  }
  /// float [axis][address].
  const cl::Buffer& displacement() const { return this->displacement_.buffer; }
  /// Exchanges the displacements with those in another field, which has to have memory.
  void swapDisplacements(Field& other) { std::swap(this->displacement_.buffer, other.buffer); }
  /// Copies all displacements to a field, which has memory from then on. States that are allocated later start at 0.
  void saveIn(Field& field);
  /// Copies those of some slots; the values in other slots are undefined.
  void saveIn(Field& field, const std::vector<int>& slots);

  /// The displacements before a wave.
  Snapshot& before() { return this->before_; }
  const Snapshot& before() const { return this->before_; }

  /// Sets all displacements in these slots, which have a state: elementsPerBrick() values for each slot, in their order
  /// and in the order of addresses, first of x for all slots, then of y, then of z.
  void writeSlots(const std::vector<int>& slots, const float* values);

  /// Puts all elements at rest: sets displacements and rotations to zero.
  void clearDisplacements();
  /// Does the same, and unloads the tissue (Tissue::unloadTissue()).
  void unload();
  /// Replaces these elements (Grid::at) by air and puts them at rest.
  void removeElements(const std::vector<std::size_t>& voxels);

  // --- Slots that may be displaced

  /// Slots in which an element may be displaced, ascending. They have a state.
  std::vector<int> dirtySlots() const;
  void markDirty(int slot);
  void markDirty(const std::vector<int>& slots);

  // --- Rotations

  /// The rotations of all elements; null where elements do not rotate.
  const Rotations* rotations() const { return this->rotations_.get(); }
  /// The same, but null while no element can have rotated: then waves need no rotations.
  const Rotations* activeRotations() const
  {
    return this->rotations_ && this->rotations_->any ? this->rotations_.get() : nullptr;
  }
  /// To be called with true where elements may rotate, and with false where all are back at rest.
  void setRotated(bool any);
  const RotationSettings& rotationSettings() const { return this->rotationSettings_; }
  /// All rotations of one slot, as readSlot().
  void readRotations(int slot, std::vector<float>& out) const
  {
    this->BrickStorage::readSlot(this->rotations_->spin, slot, out);
  }

  // --- Soft links

  /// Replaces all soft links by these: in ascending order of voxels, at most one per voxel, in bricks with a state.
  /// These bricks count as touched, because the tissue that the links pull has to settle again.
  void setSoftLinks(std::vector<SoftLink> links);
  /// Replaces them by soft links of all elements of these bricks, for a kernel to write (SoftLinks).
  void makeSoftLinks(const std::vector<int>& bricks);
  /// Reads those of these elements (SoftLinks::read).
  void readSoftLinks(const std::vector<std::size_t>& voxels);
  /// Null where there are none.
  const SoftLinks* softLinks() const { return this->soft_.get(); }

  // --- Options and arguments of kernels

  /// The -D options that every kernel with brick.clh needs. With `vectors` a kernel processes as many elements at once
  /// as suits the device, else one.
  std::string defines(bool vectors) const { return this->defines(vectors, this->rotations()); }
  /// The same for a kernel that reads these rotations; null: none.
  std::string defines(bool vectors, const Rotations* rotations) const
  {
    return this->options().defines(this->options().width(vectors), this->anyCut(), rotations != nullptr);
  }
  /// The same for a kernel that benefits from the longest vectors of the device, up to a row.
  std::string definesOfRows() const { return this->definesOfRows(this->rotations()); }
  std::string definesOfRows(const Rotations* rotations) const
  {
    return this->options().defines(this->options().widthOfRows(), this->anyCut(), rotations != nullptr);
  }
  /// Continued options, of kernels that include volumetricstrain.clh or softlinks.clh.
  std::string ofVolumetricStrain() const
  {
    return this->rotations_ && this->rotations_->hasPressure() ? " -DVOLUMETRIC_STRAIN" : "";
  }
  std::string ofSoftLinks() const { return this->soft_ ? " -DSOFT" : ""; }
  /// See KernelOptions.
  std::size_t workItems(bool vectors) const { return this->options().workItems(vectors); }

  /// STATE_ARGUMENTS of state.clh, for a kernel that was compiled with the defines() of these rotations and, where
  /// `soft` is not null, with ofSoftLinks().
  using StateArguments = std::tuple<LayoutArguments, const cl::Buffer&, const cl::Buffer&, const cl::Buffer&,
    const Rotations*, const SoftLinks*>;
  StateArguments state(const Rotations* rotations, const SoftLinks* soft = nullptr) const
  {
    return this->stateWith(this->displacement(), rotations, soft);
  }
  /// The same with other values in place of the displacement, laid out alike.
  StateArguments stateWith(
    const cl::Buffer& displacement, const Rotations* rotations, const SoftLinks* soft = nullptr) const
  {
    return { this->layout(), displacement, this->constraint(), this->cut(), rotations, soft };
  }
  /// The same with the cuts that pictures show, without rotations.
  StateArguments shownState() const
  {
    return { this->layout(), this->displacement(), this->constraint(), this->shownCut(), nullptr, nullptr };
  }

  std::size_t deviceBytes() const { return this->bytes() + (this->soft_ ? this->soft_->bytes() : 0); }

private:
  friend class Elements;

  Field displacement_{ 3, sizeof(float), "the displacement of the tissue reached" };
  Snapshot before_;
  std::vector<char> dirty_; ///< for each slot with a state, or fewer: those beyond its end are not touched
  RotationSettings rotationSettings_;
  std::unique_ptr<Rotations> rotations_;
  std::unique_ptr<SoftLinks> soft_;
};

}
