#include "Joints.h"

#include "Components.h"
#include "Dispatch.h"
#include "Error.h"
#include "Format.h"
#include "Neighbours.h"
#include "Watershed.h"

#include <algorithm>
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

/// How far bodies extend into the stiff tissue around them [voxels]. Between the bones of a scan most of that tissue is
/// voxels that mix cartilage and bone, which are stiffer than any joint.
constexpr int reach = 3;

/// A component of unlabelled bone is a crumb if the labelled bodies that it touches have together at least this many
/// times as many voxels.
constexpr std::size_t timesCrumb = 10;

using Mask = std::vector<char>;

std::vector<Body> findTissue(const Grid& grid, int axes, const Model::RowReader& read, float jointConstraint)
{
  std::vector<Body> bodies(grid.voxels(), soft);
  const int width = grid.size[0];
  std::vector<float> row(static_cast<std::size_t>(width) * axes);
  for (std::size_t first = 0; first < bodies.size(); first += width)
  {
    read(first, width, row.data());
    for (std::size_t n = 0; n < row.size(); ++n)
    {
      Body& body = bodies[first + n / axes];
      const bool isStiff = row[n] >= 0.0f && row[n] < jointConstraint; // air is negative
      body = row[n] == 0.0f ? unlabelled : isStiff ? std::max(body, stiff) : body;
    }
  }
  return bodies;
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

/// The body of a voxel by its label; 0 where it has none, or one that no rigid voxel has.
using BodyOf = std::function<Body(std::size_t)>;

/// Numbers the bodies of rigid voxels in the order of their labels. `next` becomes the first unused number.
BodyOf readLabels(const ArrayView& labels, std::vector<Body>& bodies, Body& next)
{
  if (labels.components != 1)
  {
    throw InputError("BodyArray has " + std::to_string(labels.components) + " components; it needs 1, the label.");
  }
  return dispatch(labels,
    [&](const auto* label) -> BodyOf
    {
      std::set<std::int64_t> found;
      std::int64_t last = 0;
      for (std::size_t n = 0; n < bodies.size(); ++n)
      {
        const std::int64_t here = bodies[n] < unlabelled ? 0 : labelOf(label[n], n);
        if (here != 0 && here != last)
        {
          found.insert(here);
          last = here;
        }
      }
      const std::vector<std::int64_t> ordered(found.begin(), found.end());
      const BodyOf bodyOf = [=](std::size_t n) -> Body
      {
        const std::int64_t here = labelOf(label[n], n);
        const auto place = std::lower_bound(ordered.begin(), ordered.end(), here);
        return place == ordered.end() || *place != here ? 0 : firstBody + static_cast<Body>(place - ordered.begin());
      };
      for (std::size_t n = 0; n < bodies.size(); ++n)
      {
        bodies[n] = bodies[n] == unlabelled ? std::max(unlabelled, bodyOf(n)) : bodies[n];
      }
      next = firstBody + static_cast<Body>(ordered.size());
      return bodyOf;
    });
}

/// Unlabelled rigid tissue and the tissue that it encloses, without labelled bodies and their marrow. A cavity that a
/// face of the grid cuts open counts as enclosed if it is so within that face: the body continues beyond the grid.
Mask filled(const Grid& grid, const std::vector<Body>& bodies)
{
  constexpr char outside = 2;
  Mask solid(bodies.size());
  std::transform(bodies.begin(), bodies.end(), solid.begin(),
    [](Body body) {
      return static_cast<char>(body == unlabelled ? 1 : body < unlabelled ? 0 : outside);
    });
  std::vector<std::size_t> front;
  for (int face = 0; face < 6; ++face)
  {
    const int across = face / 2;
    const int layer = face % 2 == 0 ? 0 : grid.size[across] - 1;
    const auto inFace = [&](std::size_t voxel) { return grid.indexOf(voxel)[across] == layer; };
    Index3 at{ 0, 0, 0 };
    at[across] = layer;
    const int u = (across + 1) % 3;
    const int v = (across + 2) % 3;
    for (at[u] = 0; at[u] < grid.size[u]; ++at[u])
    {
      const bool isSide = at[u] == 0 || at[u] + 1 == grid.size[u];
      for (at[v] = 0; at[v] < grid.size[v]; at[v] += isSide ? 1 : std::max(1, grid.size[v] - 1))
      {
        const std::size_t voxel = grid.at(at[0], at[1], at[2]);
        if (solid[voxel] != 0)
        {
          continue;
        }
        solid[voxel] = outside;
        visitComponent(voxel, front,
          [&](std::size_t here, const auto& add)
          {
            forFaces(grid, here,
              [&](std::size_t next)
              {
                if (solid[next] == 0 && inFace(next))
                {
                  solid[next] = outside;
                  add(next);
                }
              });
          });
      }
    }
  }
  std::vector<std::size_t> starts;
  for (std::size_t n = 0; n < solid.size(); ++n)
  {
    if (solid[n] == outside)
    {
      starts.push_back(n);
    }
  }
  for (const std::size_t start : starts)
  {
    visitComponent(start, front,
      [&](std::size_t here, const auto& add)
      {
        forFaces(grid, here,
          [&](std::size_t next)
          {
            if (solid[next] == 0)
            {
              solid[next] = outside;
              add(next);
            }
          });
      });
  }
  std::transform(solid.begin(), solid.end(), solid.begin(), [](char s) { return s == outside ? 0 : 1; });
  return solid;
}

/// Grows bodies from the voxels of `front`, by one voxel in each of `steps` steps; where they meet, the lowest body
/// wins. enter(voxel, body) assigns a neighbouring voxel to a body if it is free, and returns whether it did.
template <typename Enter>
void grow(
  const Grid& grid, const std::vector<Body>& owner, std::vector<std::size_t> front, int steps, const Enter& enter)
{
  // Each step visits voxels in the order of their bodies and preserves it, so the first body to arrive is the lowest.
  std::stable_sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) { return owner[a] < owner[b]; });
  std::vector<std::size_t> next;
  for (int step = 0; step < steps && !front.empty(); ++step, front.swap(next))
  {
    next.clear();
    for (const std::size_t here : front)
    {
      forFaces(grid, here,
        [&](std::size_t beside)
        {
          if (enter(beside, owner[here]))
          {
            next.push_back(beside);
          }
        });
    }
  }
}

/// Divides unlabelled tissue into bodies where it is thinner than `size`.
void divideByThickness(const Grid& grid, int size, Body next, std::vector<Body>& bodies)
{
  const std::vector<Body> owner = watershed(grid, filled(grid, bodies), size, bodies, firstBody, next);
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    bodies[n] = bodies[n] == unlabelled && owner[n] != 0 ? owner[n] : bodies[n];
  }
}

/// Assigns crumbs of unlabelled tissue (timesCrumb) to the labelled body that they touch most.
void joinCrumbs(const Grid& grid, std::vector<Body>& bodies)
{
  std::vector<std::size_t> sizes(1 + *std::max_element(bodies.begin(), bodies.end()), 0);
  for (const Body body : bodies)
  {
    ++sizes[body];
  }
  std::vector<std::size_t> front;
  std::vector<std::size_t> crumb;
  Mask seen(bodies.size(), 0);
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    if (bodies[n] != unlabelled || seen[n] != 0)
    {
      continue;
    }
    crumb.clear();
    std::map<Body, std::size_t> faces;
    seen[n] = 1;
    visitComponent(n, front,
      [&](std::size_t here, const auto& add)
      {
        crumb.push_back(here);
        forFaces(grid, here,
          [&](std::size_t beside)
          {
            if (bodies[beside] >= firstBody)
            {
              ++faces[bodies[beside]];
            }
            else if (bodies[beside] == unlabelled && seen[beside] == 0)
            {
              seen[beside] = 1;
              add(beside);
            }
          });
      });
    std::size_t around = 0;
    Body most = unlabelled;
    for (const auto& [body, count] : faces)
    {
      around += sizes[body];
      most = most == unlabelled || count > faces[most] ? body : most;
    }
    if (most != unlabelled && around >= timesCrumb * crumb.size())
    {
      for (const std::size_t voxel : crumb)
      {
        bodies[voxel] = most;
      }
    }
  }
}

/// Assigns stiff tissue with the label of a body to it, although it is not rigid: marrow, and bone thinner than a
/// voxel.
void takeSoftTissue(const BodyOf& bodyOf, std::vector<Body>& bodies)
{
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    const Body own = bodies[n] == stiff ? bodyOf(n) : 0;
    bodies[n] = own != 0 ? own | around : bodies[n];
  }
}

/// Assigns stiff tissue to the nearest body, up to `reach` voxels away. Tissue with the label of a body never goes to
/// another one.
void reachOut(const Grid& grid, const BodyOf& bodyOf, int reach, std::vector<Body>& bodies)
{
  std::vector<std::size_t> front;
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    bool isSurface = false;
    if (bodies[n] >= unlabelled)
    {
      forFaces(grid, n, [&](std::size_t beside) { isSurface = isSurface || bodies[beside] == stiff; });
    }
    if (isSurface)
    {
      front.push_back(n);
    }
  }
  grow(grid, bodies, std::move(front), reach,
    [&](std::size_t voxel, Body body)
    {
      const Body own = bodies[voxel] == stiff && bodyOf ? bodyOf(voxel) : 0;
      const bool isFree = bodies[voxel] == stiff && (own == 0 || own == (body & ~around));
      bodies[voxel] = isFree ? body | around : bodies[voxel];
      return isFree;
    });
}

/// Calls visit(voxel, next, axis) for touching voxels along each axis that belong, or are assigned, to different
/// bodies.
template <typename Visit> void forContacts(const Grid& grid, const std::vector<Body>& bodies, const Visit& visit)
{
  for (int a = 0; a < 3; ++a)
  {
    forLines(grid, a,
      [&](std::size_t first, std::size_t stride)
      {
        const std::size_t end = first + (grid.size[a] - 1) * stride;
        for (std::size_t voxel = first; voxel < end; voxel += stride)
        {
          const Body one = bodies[voxel] & ~around;
          const Body other = bodies[voxel + stride] & ~around;
          if (one != other && one >= unlabelled && other >= unlabelled)
          {
            visit(voxel, voxel + stride, a);
          }
        }
      });
  }
}

}

FoundJoints findJoints(const Grid& grid, int axes, const Model::RowReader& read, const Joints& joints)
{
  if (joints.size > 0 && grid.voxels() > watershedVoxels)
  {
    throw InputError("The image has " + toString(grid.size) + " voxels; joints where bone is thin can be found among " +
                     std::to_string(watershedVoxels) +
                     " at most. Crop it, give labels (BodyArray) instead, or set JointSize to 0.");
  }
  // At free joints the constraint of joints is 1, so all tissue that is not rigid is stiff.
  std::vector<Body> bodies = findTissue(grid, axes, read, static_cast<float>(joints.constraint));
  Body next = firstBody;
  const BodyOf bodyOf = joints.labels ? readLabels(joints.labels, bodies, next) : BodyOf();
  if (joints.labels && joints.areFree())
  {
    joinCrumbs(grid, bodies);
    takeSoftTissue(bodyOf, bodies);
  }
  if (joints.size > 0)
  {
    divideByThickness(grid, joints.size, next, bodies);
  }

  std::vector<std::size_t> sizes(next, 0);
  for (const Body body : bodies)
  {
    sizes.resize(std::max<std::size_t>(sizes.size(), 1 + (body & ~around)), 0);
    ++sizes[body & ~around];
  }
  reachOut(grid, bodyOf, joints.areFree() ? joints.margin : reach, bodies);
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
        found.voxels.push_back(givesWay(bodies[voxel], bodies[beside]) ? voxel : beside);
      }
    });
  std::sort(found.links.begin(), found.links.end());
  std::sort(found.voxels.begin(), found.voxels.end());
  found.voxels.erase(std::unique(found.voxels.begin(), found.voxels.end()), found.voxels.end());
  return found;
}

}
