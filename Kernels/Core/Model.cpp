#include "Model.h"

#include "Constraints.h"
#include "ElementRule.h"
#include "Error.h"
#include "Format.h"
#include "Joints.h"
#include "ReducedBox.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

namespace chainmail
{

void Grid::check() const
{
  for (int a = 0; a < 3; ++a)
  {
    if (this->size[a] < 1)
    {
      throw InputError("The image is empty: give one with at least one voxel on every axis.");
    }
    if (!(this->spacing[a] > 0.0) || !std::isfinite(this->spacing[a]))
    {
      throw InputError(
        "The spacing of the image is not positive on every axis. Set a positive spacing, for a single slice too.");
    }
  }
  if (!this->fits())
  {
    throw InputError("The image has " + toString(this->size) + " voxels; at most " + std::to_string(maxVoxels) +
                     " can be handled. Crop it or resample it to fewer.");
  }
}

Model::Model(const Grid& grid, const ArrayView& scalars, const Material& material, const Anchors& anchors)
  : grid_(grid)
  , anchors_(anchors)
{
  grid.check();
  if (!scalars)
  {
    throw InputError("The image has no scalars to tell tissue from air: choose an array.");
  }

  const Constraints constraints(grid, scalars, material);
  this->axes_ = constraints.axes();
  this->read_ = constraints.reader();
  this->reduce_ = material.joints.wanted() ? nullptr : material.reduce;

  // One pass over all voxels counts the elements and finds every constraint that is out of range before work begins.
  const TissueCounts found = material.count ? material.count() : constraints.count(VoxelBox::all(grid));
  if (found.badVoxel != TissueCounts::none)
  {
    throw InputError(found.problem);
  }
  this->elements_ = found.elements;
  this->nonFinite_ = found.nonFinite;
  this->divide(material.joints);
  if (this->elements_ == 0)
  {
    throw InputError("The image is all air: no voxel has a finite scalar of at least the tissue threshold, " +
                     toString(material.tissueThreshold) + ". Lower TissueThreshold, or choose another MaterialPreset.");
  }
}

/// Finds the joints where bodies of rigid tissue meet.
void Model::divide(const Joints& joints)
{
  this->jointConstraint_ =
    joints.areFree() ? 0.0f : checkedConstraint(joints.constraint, [] { return std::string("of the joints"); });
  if (joints.size < 0)
  {
    throw InputError("The size of the joints is " + std::to_string(joints.size) + "; it has to be 0 (none) or more.");
  }
  if (joints.margin < 1 || joints.margin > 100)
  {
    throw InputError(
      "The margin of the joints is " + std::to_string(joints.margin) + "; it has to be 1 to 100 voxels.");
  }
  this->divided_ = joints.wanted();
  if (this->divided_)
  {
    FoundJoints found = findJoints(this->grid_, this->axes_, this->read_, joints);
    this->joints_ = std::move(found.voxels);
    this->linksOfJoints_ = std::move(found.links);
  }
}

Model::Model(const Grid& grid, int axes, RowReader rows)
  : grid_(grid)
  , axes_(axes)
  , read_(std::move(rows))
{
  this->anchors_.faces.fill(false);
}

std::shared_ptr<const Model> Model::derived(
  const Grid& grid, RowReader rows, std::vector<std::size_t> joints, std::vector<Link> links) const
{
  auto model = std::make_shared<Model>(grid, this->axes_, std::move(rows));
  model->joints_ = std::move(joints);
  model->linksOfJoints_ = std::move(links);
  return model;
}

std::vector<ReducedBox> Model::reduceElsewhere(const Index3& factor) const
{
  return this->reduce_ ? this->reduce_(factor) : std::vector<ReducedBox>();
}

bool Model::isJoint(std::size_t voxel) const
{
  return !this->joints_.empty() && std::binary_search(this->joints_.begin(), this->joints_.end(), voxel);
}

/// Makes the voxels of joints soft among `count` voxels, from voxel number `first` on.
void Model::soften(std::size_t first, int count, float* out) const
{
  const auto begin = std::lower_bound(this->joints_.begin(), this->joints_.end(), first);
  for (auto joint = begin; joint != this->joints_.end() && *joint < first + count; ++joint)
  {
    float* c = out + (*joint - first) * this->axes_;
    std::transform(c, c + this->axes_, c, [this](float one) { return std::max(one, this->jointConstraint_); });
  }
}

void Model::row(int i, int j, int k, int count, float* out) const
{
  this->read_(this->grid_.at(i, j, k), count, out);
  if (this->divided_)
  {
    this->soften(this->grid_.at(i, j, k), count, out);
  }
  if (this->anchors_.rigid)
  {
    holdRigid(this->axes_, count, out);
  }
  const Index3& size = this->grid_.size;
  std::array<bool, 6> faces = this->anchors_.faces;
  for (int a = 0; a < 3; ++a)
  {
    // An axis with a single layer has no faces: holding them would hold everything.
    faces[2 * a] = faces[2 * a] && size[a] > 1;
    faces[2 * a + 1] = faces[2 * a + 1] && size[a] > 1;
  }
  const bool all =
    (faces[2] && j == 0) || (faces[3] && j == size[1] - 1) || (faces[4] && k == 0) || (faces[5] && k == size[2] - 1);
  const bool ends = (faces[0] && i == 0) || (faces[1] && i + count == size[0]);
  for (int n = 0; n < count && (all || ends); ++n)
  {
    const bool held = all || (faces[0] && i + n == 0) || (faces[1] && i + n == size[0] - 1);
    float* c = out + static_cast<std::size_t>(n) * this->axes_;
    std::transform(c, c + this->axes_, c, [held](float one) { return rule::asHeld(one, held); });
  }
}

int Model::anchoringFace(int i, int j, int k) const
{
  const Index3 at{ i, j, k };
  for (int face = 0; face < 6; ++face)
  {
    const int size = this->grid_.size[face / 2];
    if (this->anchors_.faces[face] && size > 1 && at[face / 2] == (face % 2 == 0 ? 0 : size - 1))
    {
      return face;
    }
  }
  return -1;
}
}
