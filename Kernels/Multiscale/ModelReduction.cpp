#include "ModelReduction.h"

#include "Components.h"
#include "Elements.h"
#include "Error.h"
#include "ReducedModel.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <set>

namespace chainmail
{

namespace
{

Index3 factorsFor(const Grid& whole, int factor)
{
  if (factor != 2 && factor != 4 && factor != 8)
  {
    throw InputError("The model reduction is " + std::to_string(factor) + "; it can be 1, 2, 4 or 8.");
  }
  Index3 factors;
  for (int a = 0; a < 3; ++a)
  {
    factors[a] = whole.size[a] > 1 ? factor : 1;
  }
  return factors;
}

/// The number of voxels that may have a displacement at the same time; 134 million take 2 GiB.
std::size_t voxelsAtOnce()
{
  const char* const ofTest = std::getenv("CHAINMAIL_VOXELS_AT_ONCE");
  return ofTest ? std::strtoull(ofTest, nullptr, 10) : std::size_t(1) << 27;
}

}

ModelReduction::ModelReduction(Bricks& whole, int factor, const RotationSettings& rotationSettings)
  : whole_(whole)
  , factor_(factorsFor(whole.model().grid(), factor))
  , bricks_(whole.sharedContext(), reducedModel(whole, this->factor_, this->apart_), whole.size(), rotationSettings)
  , moved_(whole, this->bricks_, this->factor_)
  , mostAtOnce_(std::max<std::size_t>(1, voxelsAtOnce() / static_cast<std::size_t>(whole.elementsPerBrick())))
  , owner_{ 1, sizeof(cl_int), "the sides of cuts" }
{
  this->separate();
}

ModelReduction::~ModelReduction()
{
  this->whole_.removeField(this->owner_);
}

/// Removes the links that are missing from the start (reducedModel).
void ModelReduction::separate()
{
  for (const auto& [element, axis] : this->apart_)
  {
    const Index3 at = this->bricks_.model().grid().indexOf(element);
    this->bricks_.removeLink(at[0], at[1], at[2], 2 * axis + 1);
  }
  this->bricks_.uploadCuts();
}

void ModelReduction::restoreTopology()
{
  this->whole_.restoreTopology();
  this->whole_.removeField(this->owner_);
  this->owners_.clear();
  this->bricks_.restoreTopology();
  this->separate();
  this->moved();
}

double ModelReduction::linksPerLink() const
{
  double links = 1.0;
  bool first = true;
  for (const int factor : this->factor_)
  {
    links *= first ? 1.0 : factor;
    first = first && factor == 1;
  }
  return links;
}

// --- Which voxel belongs to which element

std::size_t ModelReduction::parentOf(std::size_t voxel) const
{
  const Index3 cell = this->cellOf(this->whole_.model().grid().indexOf(voxel));
  return this->bricks_.model().grid().at(cell[0], cell[1], cell[2]);
}

std::size_t ModelReduction::ownerOf(std::size_t voxel) const
{
  const auto other = this->owners_.empty() ? this->owners_.end() : this->owners_.find(voxel);
  return other == this->owners_.end() ? this->parentOf(voxel) : other->second;
}

/// Calls f(next) for every tissue voxel `next` that is linked to `voxel`.
template <typename F> void ModelReduction::forLinks(std::size_t voxel, const F& f) const
{
  const Grid& whole = this->whole_.model().grid();
  this->whole_.forNeighbours(whole.indexOf(voxel),
    [&](int, const Index3& next)
    {
      if (this->whole_.isElement(next))
      {
        f(whole.at(next[0], next[1], next[2]));
      }
    });
}

std::vector<std::size_t> ModelReduction::voxelsOf(std::size_t element) const
{
  const Grid& whole = this->whole_.model().grid();
  const Index3 cell = this->bricks_.model().grid().indexOf(element);
  Index3 first;
  Index3 end;
  for (int a = 0; a < 3; ++a)
  {
    first[a] = cell[a] * this->factor_[a];
    end[a] = std::min(first[a] + this->factor_[a], whole.size[a]);
  }
  Cell voxels;
  for (int k = first[2]; k < end[2]; ++k)
  {
    for (int j = first[1]; j < end[1]; ++j)
    {
      for (int i = first[0]; i < end[0]; ++i)
      {
        if (this->whole_.isElement({ i, j, k }))
        {
          voxels.push_back(whole.at(i, j, k));
        }
      }
    }
  }
  return voxels;
}

/// The connected components of an element's voxels by the links within the element, in the order of their first voxels.
std::vector<ModelReduction::Cell> ModelReduction::pieces(std::size_t element) const
{
  const Cell voxels = this->voxelsOf(element);
  std::vector<char> found(voxels.size(), 0);
  std::vector<std::size_t> front;
  std::vector<Cell> pieces;
  for (std::size_t seed = 0; seed < voxels.size(); ++seed)
  {
    if (found[seed])
    {
      continue;
    }
    found[seed] = 1;
    pieces.emplace_back();
    visitComponent(voxels[seed], front,
      [&](std::size_t voxel, const auto& add)
      {
        pieces.back().push_back(voxel);
        this->forLinks(voxel,
          [&](std::size_t next)
          {
            if (this->parentOf(next) != element)
            {
              return;
            }
            char& known = found[std::lower_bound(voxels.begin(), voxels.end(), next) - voxels.begin()];
            if (!known)
            {
              known = 1;
              add(next);
            }
          });
      });
  }
  return pieces;
}

/// Assigns each loose component (`loose`) to an element that it is linked to. This is the one that it followed before.
/// If it has no link to that one, it is the one to which most of its links lead. A component linked only to loose ones
/// waits for these. A component without links stays with its own element.
void ModelReduction::join(std::vector<Cell> loose, const std::unordered_map<std::size_t, std::size_t>& before)
{
  std::set<std::size_t> open;
  for (const Cell& piece : loose)
  {
    open.insert(piece.begin(), piece.end());
  }
  for (bool any = true; any;)
  {
    any = false;
    std::vector<Cell> rest;
    std::vector<std::pair<Cell, std::size_t>> joined;
    for (Cell& piece : loose)
    {
      const std::size_t parent = this->parentOf(piece.front());
      std::map<std::size_t, int> links;
      for (const std::size_t voxel : piece)
      {
        this->forLinks(voxel,
          [&](std::size_t to)
          {
            if (this->parentOf(to) != parent && open.count(to) == 0)
            {
              ++links[this->ownerOf(to)];
            }
          });
      }
      if (links.empty())
      {
        rest.push_back(std::move(piece));
        continue;
      }
      const auto last = before.find(piece.front());
      const auto most =
        std::max_element(links.begin(), links.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
      const bool stays = last != before.end() && links.count(last->second) > 0;
      joined.push_back({ std::move(piece), stays ? last->second : most->first });
    }
    for (const auto& [piece, element] : joined)
    {
      any = true;
      for (const std::size_t voxel : piece)
      {
        open.erase(voxel);
        this->owners_[voxel] = element;
      }
    }
    loose = std::move(rest);
  }
}

/// Elements with a voxel that a cut or carve has changed.
std::set<std::size_t> ModelReduction::touched() const
{
  const Grid& whole = this->whole_.model().grid();
  const Index3 size = this->whole_.size();
  std::set<std::size_t> changed;
  for (const auto& [brick, bits] : this->whole_.links().all())
  {
    const Index3 origin = this->whole_.origin(brick);
    for (int k = origin[2]; k < std::min(origin[2] + size[2], whole.size[2]); ++k)
    {
      for (int j = origin[1]; j < std::min(origin[1] + size[1], whole.size[1]); ++j)
      {
        for (int i = origin[0]; i < std::min(origin[0] + size[0], whole.size[0]); ++i)
        {
          if (bits[this->whole_.local(i, j, k)] != 0)
          {
            changed.insert(this->parentOf(whole.at(i, j, k)));
          }
        }
      }
    }
  }
  return changed;
}

/// Recomputes which voxels follow another element than their own. Returns the elements that have lost their last voxel.
std::vector<std::size_t> ModelReduction::findOwners(const std::set<std::size_t>& changed)
{
  const Grid& grid = this->bricks_.model().grid();
  const std::unordered_map<std::size_t, std::size_t> before = std::move(this->owners_);
  this->owners_.clear();
  std::vector<Cell> loose;
  std::vector<std::size_t> gone;
  for (const std::size_t element : changed)
  {
    std::vector<Cell> parts = this->pieces(element);
    const Index3 at = grid.indexOf(element);
    if (parts.empty() && !this->bricks_.links().carved(at[0], at[1], at[2]))
    {
      gone.push_back(element);
    }
    // The component that stays is the one with the most voxels that have followed the element so far. So no tissue
    // jumps to another element.
    std::size_t most = 0;
    std::size_t stays = parts.size();
    for (std::size_t n = 0; n < parts.size(); ++n)
    {
      const std::size_t own = static_cast<std::size_t>(
        std::count_if(parts[n].begin(), parts[n].end(), [&](std::size_t voxel) { return before.count(voxel) == 0; }));
      if (own > most)
      {
        most = own;
        stays = n;
      }
    }
    for (std::size_t n = 0; n < parts.size(); ++n)
    {
      if (n != stays)
      {
        loose.push_back(std::move(parts[n]));
      }
    }
  }
  this->join(std::move(loose), before);
  return gone;
}

/// Removes the link between two elements if no voxel of one is linked to a voxel of the other any more.
void ModelReduction::removeLinks(const std::set<std::size_t>& changed)
{
  const Grid& grid = this->bricks_.model().grid();
  std::set<std::pair<std::size_t, int>> present;
  for (const std::size_t element : changed)
  {
    for (const std::size_t voxel : this->voxelsOf(element))
    {
      const std::size_t from = this->ownerOf(voxel);
      this->forLinks(voxel,
        [&](std::size_t next)
        {
          const std::size_t to = this->ownerOf(next);
          const Index3 low = grid.indexOf(std::min(from, to));
          const Index3 high = grid.indexOf(std::max(from, to));
          for (int a = 0; a < 3; ++a)
          {
            if (high == Index3{ low[0] + (a == 0), low[1] + (a == 1), low[2] + (a == 2) })
            {
              present.insert({ std::min(from, to), a });
            }
          }
        });
    }
  }
  for (const std::size_t element : changed)
  {
    const Index3 at = grid.indexOf(element);
    for (int d = 0; d < 6; ++d)
    {
      Index3 next = at;
      next[d / 2] += d % 2 == 0 ? -1 : 1;
      if (!grid.contains(next[0], next[1], next[2]))
      {
        continue;
      }
      const std::size_t low = d % 2 == 0 ? grid.at(next[0], next[1], next[2]) : element;
      if (this->bricks_.isElement(next) && present.count({ low, d / 2 }) == 0)
      {
        this->bricks_.removeLink(at[0], at[1], at[2], d);
      }
    }
  }
}

std::vector<std::size_t> ModelReduction::applyTopology()
{
  const std::set<std::size_t> changed = this->touched();
  const std::vector<std::size_t> gone = this->findOwners(changed);
  this->removeLinks(changed);
  this->bricks_.removeElements(gone); // also copies the links to the device
  this->moved();
  return gone;
}

std::vector<std::size_t> ModelReduction::elementsOf(const std::vector<std::size_t>& voxels) const
{
  std::map<std::size_t, std::size_t> grabbed;
  for (const std::size_t voxel : voxels)
  {
    ++grabbed[this->ownerOf(voxel)];
  }
  std::vector<std::size_t> elements;
  for (const auto& [element, count] : grabbed)
  {
    if (2 * count >= this->voxelsOf(element).size())
    {
      elements.push_back(element);
    }
  }
  if (elements.empty())
  {
    elements.push_back(std::max_element(grabbed.begin(), grabbed.end(),
      [](const auto& a, const auto& b) {
        return a.second < b.second;
      })->first);
  }
  return elements;
}

// --- Displacements

void ModelReduction::moved()
{
  ++this->version_;
  this->current_ = false;
  this->found_ = false;
}

/// The bricks that may be displaced now.
const VoxelExtents& ModelReduction::movedVoxels()
{
  if (!this->found_)
  {
    this->moved_.find(this->owners_);
    this->found_ = true;
  }
  return this->moved_;
}

const std::vector<int>& ModelReduction::displaced()
{
  return this->movedVoxels().bricks();
}

const std::vector<BrickExtent>& ModelReduction::extents()
{
  return this->movedVoxels().extents();
}

bool ModelReduction::displaceAll()
{
  if (!this->current_ && this->displaced().size() > this->mostAtOnce_)
  {
    return false;
  }
  this->expand();
  return true;
}

void ModelReduction::expand()
{
  if (!this->current_)
  {
    this->whole_.clearDisplacements();
    this->expandThese(this->displaced());
    this->current_ = true;
  }
}

void ModelReduction::displace(const std::vector<int>& bricks)
{
  std::vector<int> list;
  const std::vector<int>& all = this->displaced();
  std::set_intersection(bricks.begin(), bricks.end(), all.begin(), all.end(), std::back_inserter(list));
  this->whole_.unload();
  this->expandThese(list);
}

std::vector<std::vector<int>> ModelReduction::displacedIn(const VoxelBox& box)
{
  std::vector<std::vector<int>> lists;
  const Index3 size = this->whole_.size();
  for (const int brick : this->displaced())
  {
    const Index3 origin = this->whole_.origin(brick);
    bool meets = true;
    for (int a = 0; a < 3; ++a)
    {
      meets = meets && origin[a] < box.first[a] + box.size[a] && origin[a] + size[a] > box.first[a];
    }
    if (meets && (lists.empty() || lists.back().size() == this->mostAtOnce_))
    {
      lists.emplace_back();
    }
    if (meets)
    {
      lists.back().push_back(brick);
    }
  }
  return lists;
}

/// Displaces the voxels of these bricks, which are at rest.
void ModelReduction::expandThese(const std::vector<int>& bricks)
{
  const Grid& whole = this->whole_.model().grid();
  const Grid& grid = this->bricks_.model().grid();
  this->whole_.makeUpdatable(bricks);
  std::vector<int> slots;
  for (const int brick : bricks)
  {
    if (this->whole_.slot(brick) > 0)
    {
      slots.push_back(this->whole_.slot(brick));
      this->whole_.markDirty(slots.back());
    }
  }
  if (slots.empty())
  {
    return;
  }

  Context& context = this->whole_.context();
  if (!this->owners_.empty())
  {
    this->whole_.addField(this->owner_);
    context.queue().enqueueFillBuffer(this->owner_.buffer, cl_int(0), 0, sizeof(cl_int) * this->whole_.pitch());
    Elements voxels(this->whole_);
    std::vector<std::int32_t> owners;
    for (const auto& [voxel, element] : this->owners_)
    {
      const Index3 at = whole.indexOf(voxel);
      if (this->whole_.hasState(this->whole_.brickAt(at[0], at[1], at[2])))
      {
        voxels.add(at);
        owners.push_back(static_cast<std::int32_t>(element) + 1);
      }
    }
    voxels.set(this->owner_, owners);
  }
  const auto rows = static_cast<std::size_t>(this->whole_.size()[1] * this->whole_.size()[2]);
  const std::string factors = " -DFX=" + std::to_string(this->factor_[0]) +
                              " -DFY=" + std::to_string(this->factor_[1]) + " -DFZ=" + std::to_string(this->factor_[2]);
  context.launch(context.kernel("reduce.cl",
                   this->bricks_.defines(false) + factors + (this->owners_.empty() ? "" : " -DOWNERS"), "expand"),
    slots.size(), std::min<std::size_t>(this->whole_.workItems(false), rows), this->list_.holding(context, slots),
    this->bricks_.state(this->bricks_.rotations()), this->whole_.layout(),
    cl_int4{ { grid.size[0], grid.size[1], grid.size[2], 1 } },
    this->owners_.empty() ? this->whole_.constraint() : this->owner_.buffer, this->whole_.constraint(),
    this->whole_.displacement());
  context.queue().finish();
}

}
