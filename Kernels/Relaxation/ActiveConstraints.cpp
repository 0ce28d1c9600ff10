#include "ActiveConstraints.h"

#include "Components.h"
#include "ElementRule.h"
#include "Elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace chainmail
{

namespace
{

/// Elements near active constraints and their links, as plain arrays on the host.
struct Patch
{
  explicit Patch(Bricks& bricks)
    : bricks(&bricks)
    , elements(bricks)
  {
  }

  const Bricks* bricks;
  std::vector<std::size_t> voxels;                ///< numbers in the grid (Grid::at), ascending
  Elements elements;                              ///< the same, for their values on the device
  std::vector<std::array<std::uint32_t, 3>> next; ///< index of the element linked at +1 on each axis, or none
  std::vector<float> u[3];
  std::vector<float> c[3]; ///< signed constraints, with held elements marked as on the device
  /// Where elements rotate: the rest offsets of u(next) - u, on each axis (rotations.clh).
  std::vector<std::array<float, 3>> wanted[3];
  Vector3 weights{ 1.0, 1.0, 1.0 }; ///< factors for the weights of links along each axis
  /// Where elements resist volumetric strain d, with the energy 1/2 lambda d^2 (volumetricstrain.clh). `pressure`:
  /// their pressure. `volumetricStrain`: on each axis, the derivatives of d by u(next) - u and by u - u(previous).
  std::vector<float> pressure;
  std::vector<float> lambda;
  std::vector<std::array<std::array<float, 2>, 3>> volumetricStrain[3];
  Vector3 scale{ 1.0, 1.0, 1.0 };      ///< the spacing, in mean spacings
  std::vector<const SoftLink*> soft;   ///< of each element, null without one; empty if there are none at all
  Vector3 softFactor{ 1.0, 1.0, 1.0 }; ///< for the weights of soft links on each axis

  static constexpr std::uint32_t none = ~std::uint32_t(0);
  std::size_t size() const { return this->voxels.size(); }
};

/// Sums over the links of a unit: of weights and of forces.
struct Pull
{
  double weight = 0.0;
  double force = 0.0;
  bool held = false;
};

/// One axis of a patch.
struct PatchAxis
{
  const Patch& patch;
  const std::vector<float>& c;
  const std::vector<std::array<float, 3>>& wanted;
  std::vector<float>& u;
  int number;                  ///< of the axis
  std::vector<float> pressure; ///< pressure after the moves of groups along this axis
};

/// The weight and the force of an element's soft link on an axis.
Pull softPullAt(const PatchAxis& axis, std::size_t n)
{
  Pull pull;
  if (const SoftLink* link = axis.patch.soft.empty() ? nullptr : axis.patch.soft[n])
  {
    pull.weight = axis.patch.softFactor[axis.number] * link->weight;
    pull.force = pull.weight * (static_cast<float>(link->place[axis.number]) - axis.u[n]);
  }
  return pull;
}

/// The groups of all three axes move in parallel, and (a + b + c)^2 <= 3 (a^2 + b^2 + c^2). So the volumetric energy
/// counts three times on each axis.
constexpr double axesAtOnce = 3.0;

/// The over-relaxation factor of groups. They are what is slowest to come to rest, like errors over many elements.
constexpr double groupOmega = 1.9;

/// A link from element n to m.
struct Link
{
  std::size_t n;
  std::size_t m;
  float limit;
  double weight;
  float wanted;     ///< rest offset of u(m) - u(n)
  double strainOfN; ///< derivative of n's volumetric strain by u(m) - u(n)
  double strainOfM; ///< the same of m
};

/// Calls f(link) for every link, in the order of voxels.
template <typename F> void forLinks(const PatchAxis& axis, F&& f)
{
  for (std::size_t n = 0; n < axis.patch.size(); ++n)
  {
    for (int along = 0; along < 3; ++along)
    {
      const std::uint32_t m = axis.patch.next[n][along];
      if (m != Patch::none && !std::isinf(axis.c[n]) && !std::isinf(axis.c[m]))
      {
        const float limit = axis.patch.bricks->link(axis.c[n], axis.c[m], 2 * along + 1, axis.number).limit;
        Link link{ n, m, limit, axis.patch.weights[along] * Elasticity::weight(limit),
          axis.wanted.empty() ? 0.0f : axis.wanted[n][along], 0.0, 0.0 };
        if (!axis.pressure.empty())
        {
          link.strainOfN = axis.patch.volumetricStrain[axis.number][n][along][0];
          link.strainOfM = axis.patch.volumetricStrain[axis.number][m][along][1];
        }
        f(link);
      }
    }
  }
}

/// Elements whose link to the next one along an axis of the grid is at its limit (activeconstraints.cl), ascending.
std::vector<std::size_t> elementsAtLimits(Bricks& bricks)
{
  const std::vector<int> slots = bricks.dirtySlots();
  std::vector<std::size_t> elements;
  if (slots.empty())
  {
    return elements;
  }
  Context& context = bricks.context();
  const std::size_t perBrick = bricks.elementsPerBrick();
  std::vector<std::uint8_t> found(slots.size() * perBrick);
  const cl::Buffer list = context.upload(slots, "the list of bricks");
  const cl::Buffer foundBuffer = context.allocate(found.size(), "links at their limits", 1);
  context.launch(context.kernel("activeconstraints.cl", bricks.definesOfRows(), "activeConstraints"), slots.size(),
    bricks.workItems(true), list, bricks.state(bricks.rotations()), foundBuffer);
  context.read(foundBuffer, found);

  for (std::size_t n = 0; n < slots.size(); ++n)
  {
    const std::uint8_t* here = found.data() + n * perBrick;
    if (std::all_of(here, here + perBrick, [](std::uint8_t byte) { return byte == 0; }))
    {
      continue;
    }
    for (const Bricks::Row& row : bricks.rows(bricks.brick(slots[n])))
    {
      for (int i = 0; i < row.count; ++i)
      {
        if (here[row.local(i)] != 0)
        {
          elements.push_back(row.voxel + i);
        }
      }
    }
  }
  std::sort(elements.begin(), elements.end());
  return elements;
}

/// Merges the neighbours of `voxels` into `all`, both ascending: the voxels at `step`, 1 or -1, along an axis of the
/// grid.
void addBeside(
  const Grid& grid, const std::vector<std::size_t>& voxels, int axis, int step, std::vector<std::size_t>& all)
{
  const std::size_t middle = all.size();
  for (const std::size_t voxel : voxels)
  {
    Index3 at = grid.indexOf(voxel);
    at[axis] += step;
    if (grid.contains(at[0], at[1], at[2]))
    {
      all.push_back(grid.at(at[0], at[1], at[2]));
    }
  }
  std::inplace_merge(all.begin(), all.begin() + middle, all.end());
}

/// Computes the rest offsets and weight factors of links where elements rotate.
void readRotations(Bricks& bricks, Patch& patch)
{
  const Rotations& all = *bricks.rotations();
  const std::vector<float> rotations = patch.elements.rotations();
  for (int axis = 0; axis < 3; ++axis)
  {
    patch.weights[axis] = all.weight(axis);
    patch.wanted[axis].resize(patch.size());
    for (std::size_t n = 0; n < patch.size(); ++n)
    {
      for (int along = 0; along < 3; ++along)
      {
        const std::uint32_t m = patch.next[n][along];
        if (m != Patch::none)
        {
          patch.wanted[axis][n][along] =
            all.restOffset(&rotations[3 * n], &rotations[3 * static_cast<std::size_t>(m)], 2 * along + 1, axis);
        }
      }
    }
  }
}

/// Reads the pressure of elements that resist volumetric strain; relaxation keeps it up to date. Computes `lambda` and
/// the derivatives of the strain.
void readVolumetricStrain(Bricks& bricks, Patch& patch)
{
  const Rotations& all = *bricks.rotations();
  const std::size_t axes = static_cast<std::size_t>(bricks.model().axes());
  patch.pressure = patch.elements.pressures();
  std::vector<float> soft(patch.size());
  for (std::size_t n = 0; n < patch.size(); ++n)
  {
    float sum = 0.0f;
    bool isSoft = true;
    for (std::size_t a = 0; a < axes; ++a)
    {
      const float c = std::fabs(patch.c[a][n]);
      sum += c;
      isSoft = isSoft && c > 0.0f && !std::isinf(c);
    }
    soft[n] = isSoft ? sum / static_cast<float>(axes) : 0.0f;
    patch.lambda.push_back(isSoft ? static_cast<float>(all.proportions.s[3] * Elasticity::weight(soft[n])) : 0.0f);
  }
  const std::vector<float> rotations = patch.elements.rotations();
  for (int axis = 0; axis < 3; ++axis)
  {
    patch.scale[axis] = all.proportions.s[axis];
    patch.volumetricStrain[axis].resize(patch.size());
  }
  for (std::size_t n = 0; n < patch.size(); ++n)
  {
    for (int along = 0; along < 3; ++along)
    {
      const std::uint32_t m = patch.next[n][along];
      if (m == Patch::none || soft[n] == 0.0f || soft[m] == 0.0f)
      {
        continue;
      }
      float ofN[3];
      float ofM[3];
      rule::single::rotationOffsetOfAxis(&rotations[3 * n], along, ofN);
      rule::single::rotationOffsetOfAxis(&rotations[3 * static_cast<std::size_t>(m)], along, ofM);
      for (int axis = 0; axis < 3; ++axis)
      {
        const float own = axis == along ? 1.0f : 0.0f;
        const float ratio = all.proportions.s[axis] / all.proportions.s[along] / (soft[n] + soft[m]);
        patch.volumetricStrain[axis][n][along][0] = soft[n] * ratio * (ofN[axis] + own);
        patch.volumetricStrain[axis][m][along][1] = soft[m] * ratio * (ofM[axis] + own);
      }
    }
  }
}

/// Reads the ends of links at their limits, the rigid clusters that these belong to, and all neighbours of both.
Patch readPatch(Bricks& bricks, const RigidClusters& clusters)
{
  const Grid& grid = bricks.model().grid();
  const int axes = bricks.model().axes();
  const std::vector<std::size_t> lower = elementsAtLimits(bricks);
  std::vector<std::size_t> ends = lower;
  for (int a = 0; a < 3; ++a)
  {
    addBeside(grid, lower, a, 1, ends);
  }
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<std::size_t> movable;
  for (int a = 0; a < axes; ++a)
  {
    const std::vector<std::size_t> more = clusters.withClusters(ends, a);
    const std::size_t middle = movable.size();
    movable.insert(movable.end(), more.begin(), more.end());
    std::inplace_merge(movable.begin(), movable.begin() + middle, movable.end());
  }
  movable.erase(std::unique(movable.begin(), movable.end()), movable.end());

  Patch patch(bricks);
  patch.voxels = movable;
  for (int a = 0; a < 3; ++a)
  {
    addBeside(grid, movable, a, -1, patch.voxels);
    addBeside(grid, movable, a, 1, patch.voxels);
  }
  patch.voxels.erase(std::unique(patch.voxels.begin(), patch.voxels.end()), patch.voxels.end());

  const std::size_t steps[3] = { grid.at(1, 0, 0), grid.at(0, 1, 0), grid.at(0, 0, 1) };
  std::array<std::size_t, 3> ahead{}; // advances together with n
  patch.next.resize(patch.size());
  for (std::size_t n = 0; n < patch.size(); ++n)
  {
    const std::size_t voxel = patch.voxels[n];
    const Index3 at = grid.indexOf(voxel);
    const std::uint8_t cut = bricks.cutBits(at[0], at[1], at[2]);
    patch.elements.add(at);
    for (int a = 0; a < 3; ++a)
    {
      while (ahead[a] < patch.size() && patch.voxels[ahead[a]] < voxel + steps[a])
      {
        ++ahead[a];
      }
      const bool linked = ahead[a] < patch.size() && patch.voxels[ahead[a]] == voxel + steps[a] &&
                          at[a] + 1 < grid.size[a] && (cut & CUT_UP_BIT(a)) == 0;
      patch.next[n][a] = linked ? static_cast<std::uint32_t>(ahead[a]) : Patch::none;
    }
  }
  const std::vector<float> u = patch.elements.displacements();
  const std::vector<float> c = patch.elements.constraints();
  for (int a = 0; a < 3; ++a)
  {
    for (std::size_t n = 0; n < patch.size(); ++n)
    {
      patch.u[a].push_back(u[3 * n + a]);
      if (a < axes)
      {
        patch.c[a].push_back(c[axes * n + a]);
      }
    }
  }
  if (const SoftLinks* soft = bricks.softLinks())
  {
    std::transform(patch.voxels.begin(), patch.voxels.end(), std::back_inserter(patch.soft),
      [soft](std::size_t voxel) { return soft->of(voxel); });
    for (int a = 0; a < 3; ++a)
    {
      patch.softFactor[a] = soft->factor(a, bricks.rotations() != nullptr);
    }
  }
  if (bricks.rotations())
  {
    readRotations(bricks, patch);
    if (bricks.rotations()->hasPressure())
    {
      readVolumetricStrain(bricks, patch);
    }
  }
  return patch;
}

/// Divides elements into units, which move as one: rigid clusters and single elements.
DisjointSets unitsOf(const PatchAxis& axis)
{
  DisjointSets units(axis.patch.size());
  forLinks(axis,
    [&](const Link& link)
    {
      if (link.limit == 0.0f)
      {
        units.join(link.n, link.m);
      }
    });
  return units;
}

/// The pull on each unit, stored at the unit's root.
std::vector<Pull> pullsAt(const PatchAxis& axis, const Elasticity& elasticity, DisjointSets& units)
{
  const std::size_t count = axis.patch.size();
  std::vector<Pull> pulls(count);
  for (std::size_t n = 0; n < count; ++n)
  {
    // Tissue at rest counts as held, because its brick may have no state yet.
    if (std::signbit(axis.c[n]) || axis.u[n] == 0.0f)
    {
      pulls[units.root(n)].held = true;
    }
    const Pull soft = softPullAt(axis, n);
    pulls[units.root(n)].weight += soft.weight;
    pulls[units.root(n)].force += soft.force;
  }
  forLinks(axis,
    [&](const Link& link)
    {
      const std::size_t n = units.root(link.n);
      const std::size_t m = units.root(link.m);
      double force = link.weight * elasticity.pull(axis.u[link.n], axis.u[link.m] - link.wanted, link.limit);
      if (!axis.pressure.empty())
      {
        const double scale = axis.patch.scale[axis.number];
        force +=
          0.5 / (scale * scale) * (axis.pressure[link.n] * link.strainOfN + axis.pressure[link.m] * link.strainOfM);
      }
      if (n != m)
      {
        pulls[n].weight += link.weight;
        pulls[n].force += force;
        pulls[m].weight += link.weight;
        pulls[m].force -= force;
      }
    });
  return pulls;
}

/// Joins units to groups by the links that block. Returns whether there are any such links.
bool joinBlocked(const PatchAxis& axis, const std::vector<Pull>& pulls, DisjointSets& units, DisjointSets& groups)
{
  bool any = false;
  forLinks(axis,
    [&](const Link& link)
    {
      if (units.root(link.n) == units.root(link.m))
      {
        return;
      }
      const Pull& atN = pulls[units.root(link.n)];
      const Pull& atM = pulls[units.root(link.m)];
      const float stretch = axis.u[link.n] - (axis.u[link.m] - link.wanted);
      const float rounding = 1e-6f * std::max(1.0f, std::fabs(axis.u[link.n]));
      const bool above = stretch >= link.limit - rounding;  // n is as far above m as it can be
      const bool below = -stretch >= link.limit - rounding; // n is as far below m as it can be
      const bool blocks =
        (above && (atN.force > 0.0 || atM.force < 0.0)) || (below && (atN.force < 0.0 || atM.force > 0.0));
      if (blocks && !atN.held && !atM.held)
      {
        groups.join(link.n, link.m);
        any = true;
      }
    });
  return any;
}

/// A blocked group: several units that move as one.
struct Group
{
  struct Outgoing
  {
    std::uint32_t inner;
    std::uint32_t outer;
    float limit;
    double weight;
    float wanted; ///< rest offset of u(outer) - u(inner)
  };
  struct VolumetricStrain
  {
    std::uint32_t element;
    double byMove; ///< derivative of its volumetric strain by the group's move
  };
  std::vector<std::uint32_t> members;
  std::vector<Outgoing> outgoing; ///< links that lead out of the group
  std::vector<VolumetricStrain>
    volumetricStrain; ///< elements at the ends of these, where there is pressure; see sumUp()
};

/// Adds the change of volumetric strain at both ends of a link. `stretch`: the change of u(m) - u(n) per move of the
/// group.
void addVolumetricStrain(Group& group, const Link& link, double stretch)
{
  if (link.strainOfN != 0.0 || link.strainOfM != 0.0)
  {
    group.volumetricStrain.push_back({ static_cast<std::uint32_t>(link.n), stretch * link.strainOfN });
    group.volumetricStrain.push_back({ static_cast<std::uint32_t>(link.m), stretch * link.strainOfM });
  }
}

/// Leaves one entry for each element, the sum of its entries, in the order of elements.
void sumUp(std::vector<Group::VolumetricStrain>& all)
{
  std::stable_sort(all.begin(), all.end(),
    [](const Group::VolumetricStrain& a, const Group::VolumetricStrain& b) { return a.element < b.element; });
  std::vector<Group::VolumetricStrain> sums;
  for (const Group::VolumetricStrain& one : all)
  {
    if (sums.empty() || sums.back().element != one.element)
    {
      sums.push_back({ one.element, 0.0 });
    }
    sums.back().byMove += one.byMove;
  }
  all = std::move(sums);
}

/// The blocked groups, with their members and links in the order of voxels.
std::vector<Group> groupsOf(const PatchAxis& axis, DisjointSets& units, DisjointSets& groups)
{
  const std::size_t count = axis.patch.size();
  std::vector<int> idOf(count, -1);
  std::vector<Group> found;
  for (std::size_t n = 0; n < count; ++n)
  {
    if (std::isinf(axis.c[n]) || units.root(n) == groups.root(n))
    {
      continue;
    }
    int& id = idOf[groups.root(n)];
    if (id < 0)
    {
      id = static_cast<int>(found.size());
      found.emplace_back();
    }
  }
  for (std::size_t n = 0; n < count; ++n)
  {
    const int id = idOf[groups.root(n)];
    if (id >= 0 && !std::isinf(axis.c[n]))
    {
      found[id].members.push_back(static_cast<std::uint32_t>(n));
    }
  }
  forLinks(axis,
    [&](const Link& link)
    {
      const std::uint32_t a = groups.root(link.n);
      const std::uint32_t b = groups.root(link.m);
      const std::uint32_t n = static_cast<std::uint32_t>(link.n);
      const std::uint32_t m = static_cast<std::uint32_t>(link.m);
      if (a != b && idOf[a] >= 0)
      {
        found[idOf[a]].outgoing.push_back({ n, m, link.limit, link.weight, link.wanted });
        addVolumetricStrain(found[idOf[a]], link, -1.0);
      }
      if (a != b && idOf[b] >= 0)
      {
        found[idOf[b]].outgoing.push_back({ m, n, link.limit, link.weight, -link.wanted });
        addVolumetricStrain(found[idOf[b]], link, 1.0);
      }
    });
  for (Group& group : found)
  {
    sumUp(group.volumetricStrain);
  }
  return found;
}

/// Moves one group and returns how far it went.
float moveGroup(const Group& group, PatchAxis& axis, const Elasticity& elasticity, float still)
{
  std::vector<float>& u = axis.u;
  double weight = 0.0;
  double force = 0.0;
  float lower = -std::numeric_limits<float>::infinity();
  float upper = std::numeric_limits<float>::infinity();
  for (const Group::Outgoing& link : group.outgoing)
  {
    const float outer = u[link.outer] - link.wanted;
    weight += link.weight;
    force += link.weight * elasticity.pull(u[link.inner], outer, link.limit);
    lower = std::max(lower, outer - link.limit - u[link.inner]);
    upper = std::min(upper, outer + link.limit - u[link.inner]);
  }
  for (const std::uint32_t n : group.members)
  {
    const Pull soft = softPullAt(axis, n);
    weight += soft.weight;
    force += soft.force;
  }
  const double scale = 0.5 / (axis.patch.scale[axis.number] * axis.patch.scale[axis.number]);
  for (const Group::VolumetricStrain& volumetricStrain : group.volumetricStrain)
  {
    force -= scale * axis.pressure[volumetricStrain.element] * volumetricStrain.byMove;
    weight += scale * axesAtOnce * axis.patch.lambda[volumetricStrain.element] * volumetricStrain.byMove *
              volumetricStrain.byMove;
  }
  const float wanted = weight > 0.0 ? static_cast<float>(groupOmega * force / weight) : 0.0f;
  const float way = std::min(std::max(wanted, lower), upper);
  // A group never moves against its pull. If rounding has left its box empty, it does not move.
  if (!(lower <= upper) || !(std::fabs(way) > still) || way * wanted <= 0.0f)
  {
    return 0.0f;
  }
  for (const std::uint32_t n : group.members)
  {
    u[n] += way;
  }
  for (const Group::VolumetricStrain& volumetricStrain : group.volumetricStrain)
  {
    axis.pressure[volumetricStrain.element] +=
      static_cast<float>(axesAtOnce * axis.patch.lambda[volumetricStrain.element] * volumetricStrain.byMove * way);
  }
  return std::fabs(way);
}

/// Moves the blocked groups of one axis and returns the largest move.
float moveAxis(PatchAxis axis, const Elasticity& elasticity, float still)
{
  DisjointSets units = unitsOf(axis);
  const std::vector<Pull> pulls = pullsAt(axis, elasticity, units);
  DisjointSets groups = units;
  if (!joinBlocked(axis, pulls, units, groups))
  {
    return 0.0f;
  }
  float largest = 0.0f;
  for (const Group& group : groupsOf(axis, units, groups))
  {
    largest = std::max(largest, moveGroup(group, axis, elasticity, still));
  }
  return largest;
}

}

float moveBlockedGroups(
  Bricks& bricks, const RigidClusters& clusters, const Elasticity& elasticity, float still, std::vector<int>& moved)
{
  moved.clear();
  Patch patch = readPatch(bricks, clusters);
  const std::vector<float> before[3] = { patch.u[0], patch.u[1], patch.u[2] };
  float moves[3];
  inParallel(3,
    [&](std::size_t a)
    {
      const std::vector<float>& c = patch.c[std::min<std::size_t>(a, bricks.model().axes() - 1)];
      moves[a] =
        moveAxis({ patch, c, patch.wanted[a], patch.u[a], static_cast<int>(a), patch.pressure }, elasticity, still);
    });

  Elements elements(bricks);
  std::vector<float> values;
  for (std::size_t n = 0; n < patch.size(); ++n)
  {
    const float u[3] = { patch.u[0][n], patch.u[1][n], patch.u[2][n] };
    if (u[0] != before[0][n] || u[1] != before[1][n] || u[2] != before[2][n])
    {
      const Index3 at = bricks.model().grid().indexOf(patch.voxels[n]);
      elements.add(at);
      values.insert(values.end(), u, u + 3);
      moved.push_back(bricks.brickAt(at[0], at[1], at[2]));
    }
  }
  elements.setDisplacements(values);
  std::sort(moved.begin(), moved.end());
  moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
  return *std::max_element(moves, moves + 3);
}

}
