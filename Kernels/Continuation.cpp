#include "Continuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace chainmail
{

namespace
{

/// Handles that fall short of their targets, and the sums of the missing and of the requested displacements [mm], each
/// on its worst axis.
struct Lacking
{
  Handles::Change handles;
  std::vector<Pose> reached; ///< the pose of each of them
  double lack = 0.0;
  double requested = 0.0;
  int furtherWaves = 0; ///< the most waves that one of them needs for the rest of its path, moving in steps
};

/// The displacement of a handle from one pose to another [mm]. Where it rotates: that of the corner of its elements'
/// bounding box that moves furthest along one axis.
Vector3 longestWay(const Handle& handle, const Pose& from, const Pose& to)
{
  if (!handle.rotates())
  {
    return { to.shift[0] - from.shift[0], to.shift[1] - from.shift[1], to.shift[2] - from.shift[2] };
  }
  const std::vector<double>& places = handle.placesGrabbed;
  Vector3 low{ places[0], places[1], places[2] };
  Vector3 high = low;
  for (std::size_t n = 0; n < places.size(); ++n)
  {
    low[n % 3] = std::min(low[n % 3], places[n]);
    high[n % 3] = std::max(high[n % 3], places[n]);
  }
  Vector3 longest{};
  double most = -1.0;
  for (int corner = 0; corner < 8; ++corner)
  {
    const Vector3 place{ corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2] };
    const Vector3 begin = from.of(place, handle.probe.centre);
    const Vector3 end = to.of(place, handle.probe.centre);
    const Vector3 way{ end[0] - begin[0], end[1] - begin[1], end[2] - begin[2] };
    const double length = std::max({ std::fabs(way[0]), std::fabs(way[1]), std::fabs(way[2]) });
    longest = length > most ? way : longest;
    most = std::max(most, length);
  }
  return longest;
}

/// The maximum norm of a displacement.
double lengthOf(const Vector3& way)
{
  return std::max({ std::fabs(way[0]), std::fabs(way[1]), std::fabs(way[2]) });
}

Lacking lackingOf(Handles& handles)
{
  constexpr double rounding = 1e-5;
  Lacking all;
  const std::vector<ProbeResult> results = handles.reached();
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    const Handles::Pointer& handle = handles.all()[n];
    if (handle->probe.anchor || handle->isSoft() || handle->voxels.empty())
    {
      continue;
    }
    const Pose reached{ results[n].reached, results[n].rotated };
    const double ofProbe = lengthOf(longestWay(*handle, reached, handle->asked()));
    const double requested = lengthOf(longestWay(*handle, Pose(), handle->asked()));
    if (ofProbe > rounding * requested)
    {
      all.lack += ofProbe;
      all.requested += requested;
      all.handles.moved.push_back(handle);
      all.reached.push_back(reached);
      all.furtherWaves = std::max(all.furtherWaves, Waves::wavesFor(*handle));
    }
  }
  return all;
}

/// Moves handles that fall short by a share of their missing displacements. Returns which fraction of that they gained.
double moveByShare(double share, Waves& waves, Handles& handles, const Checkpoint& checkpoint, int& iterations)
{
  const Lacking lacking = lackingOf(handles);
  if (lacking.handles.moved.empty())
  {
    return 0.0;
  }
  const auto ask = [](Handle& handle, const Pose& pose)
  {
    handle.probe.displacement = pose.shift;
    handle.probe.rotation = pose.rotation;
  };
  std::vector<Pose> asked;
  for (std::size_t n = 0; n < lacking.reached.size(); ++n)
  {
    Handle& handle = *lacking.handles.moved[n];
    asked.push_back(handle.asked());
    ask(handle, between(lacking.reached[n], asked.back(), share));
  }
  const auto askAgain = [&]
  {
    for (std::size_t n = 0; n < asked.size(); ++n)
    {
      ask(*lacking.handles.moved[n], asked[n]);
    }
  };
  try
  {
    waves.add(lacking.handles);
    iterations += waves.run(0, checkpoint).iterations;
  }
  catch (...)
  {
    askAgain(); // the probes keep their targets after an abort, too
    throw;
  }
  askAgain();
  return (lacking.lack - lackingOf(handles).lack) / (share * lacking.lack);
}

/// Moves them by a share of their missing displacements and, as long as that fits, further in each wave. A wave that is
/// much too long would propagate far before it is shortened. Returns which fraction of the first share they gained.
double moveStepwise(double share, Waves& waves, Handles& handles, const Checkpoint& checkpoint, int& iterations)
{
  constexpr double timesFurther = 4.0;
  constexpr double fits = 0.9;
  const double first = moveByShare(share, waves, handles, checkpoint, iterations);
  for (double gained = first; gained >= fits && share < 1.0;)
  {
    share = std::min(1.0, timesFurther * share);
    gained = moveByShare(share, waves, handles, checkpoint, iterations);
  }
  return first;
}

/// Whether a voxel is in a joint of two bodies, or adjacent to a link across a free joint.
bool isAtJoint(const Model& model, std::size_t voxel)
{
  if (model.isJoint(voxel))
  {
    return true;
  }
  const std::vector<Model::Link>& links = model.linksOfJoints();
  const Grid& grid = model.grid();
  const Index3 at = grid.indexOf(voxel);
  for (int k = std::max(0, at[2] - 1); k <= std::min(grid.size[2] - 1, at[2] + 1); ++k)
  {
    for (int j = std::max(0, at[1] - 1); j <= std::min(grid.size[1] - 1, at[1] + 1); ++j)
    {
      for (int i = std::max(0, at[0] - 1); i <= std::min(grid.size[0] - 1, at[0] + 1); ++i)
      {
        const auto link = std::lower_bound(links.begin(), links.end(), Model::Link(grid.at(i, j, k), 0));
        if (link != links.end() && link->first == grid.at(i, j, k))
        {
          return true;
        }
      }
    }
  }
  return false;
}

bool isRigid(const Model& model, std::size_t voxel)
{
  const Index3 at = model.grid().indexOf(voxel);
  std::array<float, 3> constraint{};
  model.row(at[0], at[1], at[2], 1, constraint.data());
  return constraint[0] == 0.0f;
}

/// The joints where a path of voxels leads from one body to another: a voxel of each body.
std::vector<std::pair<std::size_t, std::size_t>> jointsOn(const std::vector<std::size_t>& path, const Model& model)
{
  std::vector<std::pair<std::size_t, std::size_t>> joints;
  std::optional<std::size_t> body; // the last rigid voxel so far
  bool crosses = false;
  for (const std::size_t voxel : path)
  {
    if (!isRigid(model, voxel))
    {
      crosses = crosses || isAtJoint(model, voxel);
      continue;
    }
    if (body && crosses)
    {
      joints.emplace_back(*body, voxel);
    }
    body = voxel;
    crosses = false;
  }
  return joints;
}

}

Continued continueWaves(Waves& waves, Handles& handles, const Settle& settle, const Checkpoint& checkpoint)
{
  constexpr int mostWaves = 40;
  constexpr double leastGain = 0.02;  // fraction of what was requested or, where probes rotate, of what was missing
  constexpr double closeToEnd = 0.25; // gaining this fraction of what was missing is enough, too
  constexpr double trial = 0.02;      // share of the first step
  Continued further;
  double before = std::numeric_limits<double>::infinity();
  int most = mostWaves;
  int mayStop = 2; // how often a wave of rotating probes may gain little, because tissue may follow after it
  for (int wave = 0; wave < most; ++wave)
  {
    const Lacking lacking = lackingOf(handles);
    const auto any = [&lacking](const auto& is)
    {
      return std::any_of(lacking.handles.moved.begin(), lacking.handles.moved.end(),
        [&is](const Handles::Pointer& handle) { return is(*handle); });
    };
    const bool isOnItsWay = any([](const Handle& handle) { return handle.isOnItsWay; });
    const bool anyRotates = any([](const Handle& handle) { return handle.rotates() || handle.rotatesBody; });
    const double gain = before - lacking.lack; // of the last wave
    const bool gains =
      isOnItsWay ||
      gain >= (anyRotates ? leastGain * before : std::min(leastGain * lacking.requested, closeToEnd * before));
    if (lacking.handles.moved.empty() || (!gains && !(anyRotates && mayStop > 0)))
    {
      break;
    }
    mayStop -= gains ? 0 : 1;
    most = wave == 0 ? most + lacking.furtherWaves : most;
    before = lacking.lack;
    settle(anyRotates, !gains);
    if (anyRotates)
    {
      waves.add(lacking.handles);
      further.iterations += waves.run(0, checkpoint).iterations;
    }
    else
    {
      // The first step is a trial: if the rotation of bones gains nothing, it would only be taken back. Later ones
      // gain less and less.
      const double share = wave == 0 ? trial : std::clamp(2.0 * gain / lacking.lack, trial, 1.0);
      if (moveStepwise(share, waves, handles, checkpoint, further.iterations) < 0.1 && wave == 0)
      {
        break;
      }
    }
    further.travelled = true;
  }
  return further;
}

Limiter findLimiter(
  Bricks& bricks, const Model& model, const ModelReduction* reduction, Handles& handles, std::size_t probe)
{
  const std::vector<Handles::Pointer>& all = handles.all();
  Limiter limiter;
  const Handle& handle = *all[probe];
  if (handle.probe.anchor || handle.isSoft() || handle.voxels.empty())
  {
    return limiter;
  }
  const ProbeResult result = handles.reached()[probe];
  const Vector3 lack = longestWay(handle, { result.reached, result.rotated }, handle.asked());
  const auto most =
    std::max_element(lack.begin(), lack.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
  const int axis = static_cast<int>(most - lack.begin());
  if (std::fabs(*most) <= 1e-5 * (lengthOf(longestWay(handle, Pose(), handle.asked())) + model.grid().spacing[axis]))
  {
    return limiter; // no more than rounding
  }
  const std::optional<HoldingElement> grip = findHoldingElement(bricks, all, handle, axis, *most > 0.0 ? 1.0 : -1.0);
  if (!grip)
  {
    return limiter;
  }
  limiter.bone = grip->rigidly;
  limiter.joints = model.isDivided() ? jointsOn(grip->path, model) : limiter.joints;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    if (!all[n]->isSoft() && std::binary_search(all[n]->voxels.begin(), all[n]->voxels.end(), grip->voxel))
    {
      limiter.what = Limiter::What::Probe;
      limiter.probe = n;
      return limiter;
    }
  }
  limiter.what = Limiter::What::Rigid;
  for (const std::size_t voxel : reduction ? reduction->voxelsOf(grip->voxel) : std::vector<std::size_t>{ grip->voxel })
  {
    const Index3 at = model.grid().indexOf(voxel);
    const int face = model.anchoringFace(at[0], at[1], at[2]);
    if (face >= 0)
    {
      limiter.what = Limiter::What::Face;
      limiter.face = face;
      return limiter;
    }
  }
  return limiter;
}

}
