#include "RotatingClusters.h"

#include "ElementRule.h"
#include "Elements.h"
#include "Pass.h"
#include "Pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chainmail
{

namespace
{

constexpr const char* purpose = "the rigid clusters";

/// Floats for each cluster or chunk, as in rotatingclusters.cl.
constexpr std::size_t floatsOfPose = 8;
constexpr std::size_t floatsOfSystem = 16;
constexpr std::size_t floatsOfBounds = 8;

/// Up to this number of links of all clusters, a CPU does a pass in one launch, see rotatingAtOnce().
constexpr std::size_t fewLinks = 2048;

/// The vector from one voxel to another at rest [mm].
Vector3 way(const Grid& grid, const Index3& from, const Index3& to)
{
  return { (to[0] - from[0]) * grid.spacing[0], (to[1] - from[1]) * grid.spacing[1],
    (to[2] - from[2]) * grid.spacing[2] };
}

double length(const Vector3& v)
{
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

Vector3 cross(const Vector3& a, const Vector3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

/// The member nearest to the centre of a cluster.
std::size_t middleOf(const Grid& grid, const std::uint32_t* members, std::size_t count)
{
  Vector3 middle{};
  for (std::size_t n = 0; n < count; ++n)
  {
    const Index3 at = grid.indexOf(members[n]);
    for (int a = 0; a < 3; ++a)
    {
      middle[a] += at[a] / static_cast<double>(count);
    }
  }
  std::size_t nearest = members[0];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < count; ++n)
  {
    const Index3 at = grid.indexOf(members[n]);
    Vector3 off;
    for (int a = 0; a < 3; ++a)
    {
      off[a] = (at[a] - middle[a]) * grid.spacing[a];
    }
    if (length(off) < least)
    {
      least = length(off);
      nearest = members[n];
    }
  }
  return nearest;
}

/// Sets the degrees of freedom that held elements leave to a cluster, and its reference element.
void holdBy(const Grid& grid, const std::vector<std::size_t>& held, RotatingClusters::Body& body)
{
  const Index3 first = grid.indexOf(held.front());
  body.member = held.front();
  body.middle = { static_cast<double>(first[0]), static_cast<double>(first[1]), static_cast<double>(first[2]) };
  body.freedom = RotatingClusters::Freedom::Ball;
  Vector3 farthest{};
  for (const std::size_t voxel : held)
  {
    const Vector3 arm = way(grid, first, grid.indexOf(voxel));
    farthest = length(arm) > length(farthest) ? arm : farthest;
  }
  if (length(farthest) == 0.0)
  {
    return;
  }
  body.freedom = RotatingClusters::Freedom::Hinge;
  for (int a = 0; a < 3; ++a)
  {
    body.axis[a] = farthest[a] / length(farthest);
  }
  const double shortest = *std::min_element(grid.spacing.begin(), grid.spacing.end());
  for (const std::size_t voxel : held)
  {
    if (length(cross(body.axis, way(grid, first, grid.indexOf(voxel)))) > 1e-6 * shortest)
    {
      body.freedom = RotatingClusters::Freedom::None;
    }
  }
}

}

RotatingClusters::Body RotatingClusters::bodyOf(const Bricks& bricks, const std::uint32_t* members, std::size_t count,
  const std::vector<std::size_t>& held, bool anchored)
{
  const Grid& grid = bricks.model().grid();
  Body body;
  body.member = members[0];
  if (anchored)
  {
    body.freedom = Freedom::None;
    return body;
  }
  if (!held.empty())
  {
    holdBy(grid, held, body);
  }
  else
  {
    body.member = middleOf(grid, members, count);
    const Index3 at = grid.indexOf(body.member);
    body.middle = { static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]) };
  }
  const cl_float4& proportions = bricks.rotations()->proportions;
  for (std::size_t n = 0; n < count; ++n)
  {
    const Index3 at = grid.indexOf(members[n]);
    double square = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      const double arm = (at[a] - body.middle[a]) * proportions.s[a];
      square += arm * arm;
    }
    body.radius = std::max(body.radius, std::sqrt(square));
  }
  body.radius += 1.0; // links extend beyond members
  return body;
}

void RotatingClusters::projectToRigid(const Bricks& bricks, const std::uint32_t* members, std::size_t count,
  const Body& body, bool anchored, const std::vector<std::size_t>& held, bool rotates, float* places, float* rotations)
{
  if (anchored)
  {
    std::fill_n(places, 3 * count, 0.0f);
    std::fill_n(rotations, 3 * count, 0.0f);
    return;
  }
  const Grid& grid = bricks.model().grid();
  const cl_float4& proportions = bricks.rotations()->proportions;
  const std::size_t own = static_cast<std::size_t>(
    std::lower_bound(members, members + count, static_cast<std::uint32_t>(body.member)) - members);
  // Free clusters rotate about the mean of their members, others about the held reference element.
  std::vector<double> rest(3 * count);
  std::vector<double> now(3 * count);
  double centre[3] = {};
  double place[3] = {};
  for (std::size_t n = 0; n < count; ++n)
  {
    const Index3 at = grid.indexOf(members[n]);
    for (int a = 0; a < 3; ++a)
    {
      rest[3 * n + a] = (at[a] - body.middle[a]) * proportions.s[a];
      centre[a] += held.empty() ? rest[3 * n + a] / static_cast<double>(count) : 0.0;
      place[a] += held.empty() ? places[3 * n + a] / static_cast<double>(count) : 0.0;
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    place[a] = held.empty() ? place[a] : places[3 * own + a];
  }
  for (std::size_t n = 0; n < 3 * count; ++n)
  {
    rest[n] -= centre[n % 3];
    now[n] = rest[n] + (places[n] - place[n % 3]) * proportions.s[n % 3];
  }
  Vector3 spin{ rotations[3 * own], rotations[3 * own + 1], rotations[3 * own + 2] };
  if (rotates && (body.freedom == Freedom::All || body.freedom == Freedom::Ball))
  {
    spin = spinOf(nearestRotation(rest, now, rotationOfSpin(spin)));
  }
  for (std::size_t n = 0; n < count; ++n)
  {
    double more[3];
    rule::wide::rotationOffset(spin.data(), &rest[3 * n], more);
    const bool stays = std::binary_search(held.begin(), held.end(), static_cast<std::size_t>(members[n]));
    for (int a = 0; a < 3; ++a)
    {
      rotations[3 * n + a] = static_cast<float>(spin[a]);
      places[3 * n + a] = stays ? places[3 * n + a] : static_cast<float>(place[a] + more[a] / proportions.s[a]);
    }
  }
}

void RotatingClusters::upload(const std::vector<Body>& bodies, std::size_t chunks)
{
  Context& context = this->bricks_.context();
  this->list_ = bodies;
  std::vector<cl_float> rows;
  for (const Body& body : bodies)
  {
    for (int a = 0; a < 3; ++a)
    {
      rows.push_back(static_cast<cl_float>(body.middle[a]));
    }
    rows.push_back(static_cast<cl_float>(body.radius));
    for (int a = 0; a < 3; ++a)
    {
      rows.push_back(static_cast<cl_float>(body.axis[a]));
    }
    rows.push_back(static_cast<cl_float>(static_cast<int>(body.freedom)));
  }
  this->bodies_ = context.upload(rows, purpose);
  const auto floats = [&](std::size_t count)
  { return context.allocate(sizeof(cl_float) * std::max<std::size_t>(1, count), purpose); };
  this->ends_ = floats(floatsOfPose * bodies.size());
  this->steps_ = floats(floatsOfSystem * bodies.size());
  this->moves_ = floats(bodies.size());
  this->sums_ = floats(floatsOfSystem * chunks);
  this->bounds_ = floats(floatsOfBounds * chunks);
  this->checks_ = floats(2 * chunks);
  this->refresh();
}

void RotatingClusters::refresh()
{
  Elements members(this->bricks_);
  for (const Body& body : this->list_)
  {
    members.add(body.member);
  }
  const std::vector<float> places = members.displacements();
  const std::vector<float> rotations = members.rotations();
  std::vector<cl_float> poses(floatsOfPose * this->list_.size(), 0.0f);
  for (std::size_t n = 0; n < this->list_.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      poses[floatsOfPose * n + a] = places[3 * n + a];
      poses[floatsOfPose * n + 3 + a] = rotations[3 * n + a];
    }
  }
  this->poses_ = this->bricks_.context().upload(poses, purpose);
}

void RotatingClusters::relax(const Lists& lists, float omega, float still, bool limited, const PassArguments& pass)
{
  Context& context = this->bricks_.context();
  const std::string defines = this->bricks_.defines(false) + this->bricks_.ofSoftLinks();
  const auto kernel = [&](const char* name) { return context.kernel("rotatingclusters.cl", defines, name); };
  const std::size_t clusters = this->list_.size();
  const std::size_t items = context.info().takesManyItems() ? 64 : 1;
  const auto arguments =
    std::make_tuple(pass, this->bricks_.state(this->bricks_.rotations(), this->bricks_.softLinks()),
      std::tie(lists.chunks, lists.links, lists.directions, lists.heads, lists.members),
      static_cast<cl_uint>(lists.memberCount),
      std::tie(this->bodies_, this->poses_, this->ends_, this->steps_, this->moves_, this->sums_, this->bounds_,
        this->checks_),
      lists.soft, omega, still, 0.0f, static_cast<cl_int>(limited));

  if (!context.info().takesManyItems() && lists.linkCount <= fewLinks)
  {
    launchPass(this->bricks_, kernel("rotatingAtOnce"), clusters, items, arguments);
    return;
  }
  const auto overChunks = [&](const char* name)
  {
    if (lists.chunkCount > 0)
    {
      context.launchOver(kernel(name), lists.chunkCount, arguments);
    }
  };
  overChunks("rotatingGather");
  context.launch(kernel("rotatingSolve"), clusters, items, arguments);
  overChunks("rotatingBound");
  context.launch(kernel("rotatingChoose"), clusters, items, arguments);
  overChunks("rotatingCheck");
  context.launch(kernel("rotatingAccept"), clusters, items, arguments);
  launchPassOver(this->bricks_, kernel("rotatingScatter"), lists.memberCount, arguments);
}

}
