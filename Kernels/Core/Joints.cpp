#include "Joints.h"

#include "Cavities.h"
#include "Components.h"
#include "Dispatch.h"
#include "Error.h"
#include "Format.h"
#include "Neighbours.h"
#include "VoxelSet.h"
#include "Watershed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

namespace chainmail
{

namespace
{

using Body = std::uint32_t;
constexpr Body soft = 0;       // air, or no stiffer than joints
constexpr Body stiff = 1;      // stiffer than joints, and not rigid on any axis
constexpr Body unlabelled = 2; // rigid, of a body that only its links define
constexpr Body firstBody = 3;
constexpr Body around = Body(1) << 31; // flag: not rigid, but assigned to this body
constexpr Body owned = Body(1) << 30;  // flag: stiff, with the label of this body, and assigned to none

/// How far bodies extend into the stiff tissue around them [voxels]. Between the bones of a scan most of that tissue is
/// voxels that mix cartilage and bone, which are stiffer than any joint.
constexpr int reach = 3;

/// A component of unlabelled bone is a crumb if the labelled bodies that it touches have together at least this many
/// times as many voxels.
constexpr std::size_t timesCrumb = 10;

/// The bodies of rigid tissue and of the tissue near it. All else counts as soft.
using Bodies = VoxelMap<Body>;

/// Whether a voxel belongs to a body, or is assigned to one.
bool isBody(Body body)
{
  return body >= unlabelled && (body & owned) == 0;
}

bool isStiff(Body body)
{
  return body == stiff || (body & owned) != 0;
}

/// The label of a voxel as a whole number; 0 for none.
template <typename T> std::int64_t labelOf(T value, std::size_t voxel)
{
  if constexpr (std::is_floating_point<T>::value)
  {
    if (std::isnan(value))
    {
      return 0;
    }
    if (std::nearbyint(value) != value || std::fabs(value) > 9e18)
    {
      throw InputError("The label of the body at voxel " + std::to_string(voxel) + " is " +
                       toString(static_cast<double>(value)) + "; labels have to be whole numbers up to 9e+18.");
    }
  }
  else if constexpr (std::is_same<T, std::uint64_t>::value)
  {
    if (value >> 63 != 0)
    {
      throw InputError("The label of the body at voxel " + std::to_string(voxel) + " is " + std::to_string(value) +
                       "; labels have to be whole numbers up to 9e+18.");
    }
  }
  return static_cast<std::int64_t>(value);
}

/// The label of a voxel. Where arrays are elsewhere, a row is read once for voxels in ascending order.
using LabelReader = std::function<std::int64_t(std::size_t)>;

LabelReader readerOf(const ArrayView& labels, const Grid& grid)
{
  if (labels.components != 1)
  {
    throw InputError("BodyArray has " + std::to_string(labels.components) + " components; it needs 1, the label.");
  }
  return dispatch(labels,
    [&](const auto* values) -> LabelReader
    {
      using T = std::remove_const_t<std::remove_pointer_t<decltype(values)>>;
      const int width = grid.size[0];
      return [rows = ArrayRows<T>(labels), width, row = values, first = VoxelSet::none](std::size_t voxel) mutable
      {
        if (voxel - voxel % width != first)
        {
          first = voxel - voxel % width;
          row = rows(first, width);
        }
        return labelOf(row[voxel - first], voxel);
      };
    });
}

/// What the constraints and labels of all voxels say.
struct TissueClasses
{
  VoxelSet rigid;
  VoxelSet stiffer;                 ///< stiffer than joints and not rigid on any axis
  VoxelSet labelled;                ///< those of the stiff voxels that have a label; only for free joints
  std::vector<std::int64_t> labels; ///< of rigid voxels, ascending

  TissueClasses(
    const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints, const LabelReader& labelOf)
    : rigid(grid)
    , stiffer(grid)
    , labelled(grid)
  {
    // At free joints the constraint of joints is 1, so all tissue that is not rigid is stiff.
    const auto jointConstraint = static_cast<float>(joints.constraint);
    const int width = grid.size[0];
    std::vector<float> row(static_cast<std::size_t>(width) * axes);
    std::set<std::int64_t> found;
    std::int64_t last = 0;
    for (std::size_t first = 0; first < grid.voxels(); first += width)
    {
      read(first, width, row.data());
      for (int x = 0; x < width; ++x)
      {
        const auto begin = row.begin() + static_cast<std::ptrdiff_t>(x) * axes;
        const std::size_t voxel = first + x;
        if (std::find(begin, begin + axes, 0.0f) != begin + axes)
        {
          this->rigid.insert(voxel);
          const std::int64_t label = labelOf ? labelOf(voxel) : 0;
          if (label != 0 && label != last)
          {
            found.insert(label);
            last = label;
          }
        }
        else if (std::any_of(begin, begin + axes, [&](float c) { return c >= 0.0f && c < jointConstraint; }))
        {
          this->stiffer.insert(voxel); // air is negative
          if (labelOf && joints.areFree() && labelOf(voxel) != 0)
          {
            this->labelled.insert(voxel);
          }
        }
      }
    }
    this->labels.assign(found.begin(), found.end());
  }

  /// The bodies of rigid voxels by their labels, in the order of these. Stiff tissue within `steps` steps is among the
  /// voxels that may come to belong to a body.
  Bodies bodies(const Grid& grid, int steps, const LabelReader& labelOf) const
  {
    VoxelSet where = this->rigid;
    where.insert(this->labelled);
    where.growInto(this->stiffer, grid, steps);
    Bodies bodies(std::move(where), soft);
    bodies.forEach(
      [&](std::size_t voxel, Body& body)
      {
        const bool isRigid = this->rigid.contains(voxel);
        const std::int64_t label = labelOf ? labelOf(voxel) : 0;
        const auto place = std::lower_bound(this->labels.begin(), this->labels.end(), label);
        const bool hasBody = label != 0 && place != this->labels.end() && *place == label;
        const Body own = firstBody + static_cast<Body>(place - this->labels.begin());
        body = !hasBody ? (isRigid ? unlabelled : stiff) : isRigid ? own : own | owned;
      });
    return bodies;
  }
};

/// Grows bodies from the voxels of `front`, by one voxel in each of `steps` steps; where they meet, the lowest body
/// wins. enter(voxel, body) assigns a neighbouring voxel to a body if it is free, and returns whether it did.
template <typename Enter>
void grow(const Grid& grid, const Bodies& owner, std::vector<std::size_t> front, int steps, const Enter& enter)
{
  // Each step visits voxels in the order of their bodies and preserves it, so the first body to arrive is the lowest.
  std::stable_sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) { return owner.at(a) < owner.at(b); });
  std::vector<std::size_t> next;
  for (int step = 0; step < steps && !front.empty(); ++step, front.swap(next))
  {
    next.clear();
    for (const std::size_t here : front)
    {
      const Body body = owner.at(here);
      forFaces(grid, here,
        [&](std::size_t beside)
        {
          if (enter(beside, body))
          {
            next.push_back(beside);
          }
        });
    }
  }
}

/// Throws InputError where the watershed cannot divide so many voxels.
void checkSize(std::size_t voxels)
{
  if (voxels > watershedVoxels)
  {
    throw InputError("The image has " + std::to_string(voxels) +
                     " voxels of bone or enclosed in it; joints where bone " + "is thin can be found among " +
                     std::to_string(watershedVoxels) +
                     " at most. Crop it, give labels (BodyArray) instead, or set JointSize to 0.");
  }
}

/// Divides unlabelled tissue, with the tissue that it encloses, into bodies where it is thinner than `size`. `next` is
/// the first unused number of a body.
void divideByThickness(const Grid& grid, int size, Body next, Bodies& bodies)
{
  VoxelSet solid(grid);
  VoxelSet labelled(grid); // and their marrow
  bodies.forEach(
    [&](std::size_t voxel, Body body)
    {
      if (isBody(body))
      {
        (body == unlabelled ? solid : labelled).insert(voxel);
      }
    });
  fillCavities(grid, labelled, solid);
  solid.growInto(labelled, grid, 1); // only bodies that touch it take part
  checkSize(solid.count());
  VoxelMap<Body> divided(std::move(solid));
  divided.forEach(
    [&](std::size_t voxel, Body& body) { body = labelled.contains(voxel) ? bodies.at(voxel) & ~around : Body(0); });
  divided = watershed(grid, std::move(divided), size, next);
  bodies.forEach(
    [&](std::size_t voxel, Body& body)
    {
      const Body found = body == unlabelled ? divided.at(voxel) : Body(0);
      body = found != 0 ? found : body;
    });
}

/// Assigns crumbs of unlabelled tissue (timesCrumb) to the labelled body that they touch most.
void joinCrumbs(const Grid& grid, Body next, Bodies& bodies)
{
  std::vector<std::size_t> sizes(next, 0);
  VoxelSet left(grid);
  bodies.forEach(
    [&](std::size_t voxel, Body body)
    {
      if (body == unlabelled)
      {
        left.insert(voxel);
      }
      if (isBody(body))
      {
        ++sizes[body];
      }
    });
  std::vector<std::size_t> front;
  std::vector<std::size_t> crumb;
  VoxelSet seen(grid);
  left.forEach(
    [&](std::size_t first)
    {
      if (seen.contains(first))
      {
        return;
      }
      crumb.clear();
      std::map<Body, std::size_t> faces;
      seen.insert(first);
      visitComponent(first, front,
        [&](std::size_t here, const auto& add)
        {
          crumb.push_back(here);
          forFaces(grid, here,
            [&](std::size_t beside)
            {
              const Body body = bodies.at(beside);
              if (body == unlabelled && !seen.contains(beside))
              {
                seen.insert(beside);
                add(beside);
              }
              else if (isBody(body) && body != unlabelled)
              {
                ++faces[body];
              }
            });
        });
      std::size_t beside = 0;
      Body most = unlabelled;
      for (const auto& [body, count] : faces)
      {
        beside += sizes[body];
        most = most == unlabelled || count > faces[most] ? body : most;
      }
      if (most != unlabelled && beside >= timesCrumb * crumb.size())
      {
        for (const std::size_t voxel : crumb)
        {
          bodies.set(voxel, most);
        }
      }
    });
}

/// Assigns stiff tissue with the label of a body to it, although it is not rigid: marrow, and bone thinner than a
/// voxel.
void takeOwned(Bodies& bodies)
{
  for (Body& body : bodies.values())
  {
    body = (body & owned) != 0 ? (body & ~owned) | around : body;
  }
}

/// Assigns stiff tissue to the nearest body, up to `steps` voxels away. Tissue with the label of a body never goes to
/// another one.
void reachOut(const Grid& grid, int steps, Bodies& bodies)
{
  std::vector<std::size_t> front;
  bodies.forEach(
    [&](std::size_t voxel, Body body)
    {
      bool isSurface = false;
      if (isBody(body))
      {
        forFaces(grid, voxel, [&](std::size_t beside) { isSurface = isSurface || isStiff(bodies.at(beside)); });
      }
      if (isSurface)
      {
        front.push_back(voxel);
      }
    });
  grow(grid, bodies, std::move(front), steps,
    [&](std::size_t voxel, Body body)
    {
      const Body here = bodies.at(voxel);
      const bool isFree = here == stiff || here == ((body & ~around) | owned);
      if (isFree)
      {
        bodies.set(voxel, body | around);
      }
      return isFree;
    });
}

/// Calls visit(voxel, next, axis) for touching voxels along each axis that belong, or are assigned, to different
/// bodies.
template <typename Visit> void forContacts(const Grid& grid, const Bodies& bodies, const Visit& visit)
{
  const std::array<std::size_t, 3> strides = stridesOf(grid);
  bodies.forEach(
    [&](std::size_t voxel, Body body)
    {
      if (!isBody(body))
      {
        return;
      }
      const Index3 at = grid.indexOf(voxel);
      for (int a = 0; a < 3; ++a)
      {
        const Body other = at[a] + 1 < grid.size[a] ? bodies.at(voxel + strides[a]) : soft;
        if (isBody(other) && (other & ~around) != (body & ~around))
        {
          visit(voxel, voxel + strides[a], a);
        }
      }
    });
}

}

FoundJoints findJoints(const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints)
{
  const int steps = joints.areFree() ? joints.margin : reach;
  const LabelReader labelOf = joints.labels ? readerOf(joints.labels, grid) : LabelReader();
  Body next = firstBody;
  Bodies bodies = [&]
  {
    const TissueClasses classes(grid, axes, read, joints, labelOf);
    checkSize(joints.size > 0 ? classes.rigid.count() : 0);
    next += static_cast<Body>(classes.labels.size());
    return classes.bodies(grid, steps, labelOf);
  }();
  if (joints.labels && joints.areFree())
  {
    joinCrumbs(grid, next, bodies);
    takeOwned(bodies);
  }
  if (joints.size > 0)
  {
    divideByThickness(grid, joints.size, next, bodies);
  }

  std::vector<std::size_t> sizes(next, 0);
  for (const Body body : bodies.values())
  {
    if (isBody(body))
    {
      sizes.resize(std::max<std::size_t>(sizes.size(), 1 + (body & ~around)), 0);
      ++sizes[body & ~around];
    }
  }
  reachOut(grid, steps, bodies);
  const auto givesWay = [&](Body one, Body other)
  {
    if ((one & around) != (other & around))
    {
      return (one & around) != 0;
    }
    one &= ~around;
    other &= ~around;
    return other != unlabelled &&
           (one == unlabelled || std::make_pair(sizes[one], one) > std::make_pair(sizes[other], other));
  };
  FoundJoints found;
  forContacts(grid, bodies,
    [&](std::size_t voxel, std::size_t beside, int axis)
    {
      if (joints.areFree())
      {
        found.links.emplace_back(voxel, axis);
      }
      else
      {
        found.voxels.push_back(givesWay(bodies.at(voxel), bodies.at(beside)) ? voxel : beside);
      }
    });
  std::sort(found.links.begin(), found.links.end());
  std::sort(found.voxels.begin(), found.voxels.end());
  found.voxels.erase(std::unique(found.voxels.begin(), found.voxels.end()), found.voxels.end());
  return found;
}

}
