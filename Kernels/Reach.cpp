#include "Reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace chainmail
{

namespace
{

/// Handles that have not come as far as they are to, and by how much all of them lack [mm], each on its worst axis.
struct Lacking
{
  Handles::Change handles;
  std::vector<Vector3> reached; ///< by each of them
  double lack = 0.0;
};

Lacking lackingOf(Handles& handles)
{
  constexpr double rounding = 1e-5;
  Lacking all;
  const std::vector<ProbeResult> results = handles.reached();
  for (std::size_t n = 0; n < results.size(); ++n)
  {
    const Handles::Pointer& handle = handles.all()[n];
    double ofProbe = 0.0;
    double asked = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      ofProbe = std::max(ofProbe, std::fabs(handle->probe.displacement[a] - results[n].reached[a]));
      asked = std::max(asked, std::fabs(handle->probe.displacement[a]));
    }
    if (!handle->probe.anchor && !handle->isSoft() && !handle->voxels.empty() && ofProbe > rounding * asked)
    {
      all.lack += ofProbe;
      all.handles.moved.push_back(handle);
      all.reached.push_back(results[n].reached);
    }
  }
  return all;
}

/// Lets handles go a small share of what they lack, which takes a wave of few steps. Returns how much of it they got.
double tryShare(
  double share, Waves& waves, Handles& handles, const Lacking& lacking, const Checkpoint& checkpoint, int& iterations)
{
  std::vector<Vector3> asked;
  for (std::size_t n = 0; n < lacking.reached.size(); ++n)
  {
    Vector3& displacement = lacking.handles.moved[n]->probe.displacement;
    asked.push_back(displacement);
    for (int a = 0; a < 3; ++a)
    {
      displacement[a] = lacking.reached[n][a] + share * (displacement[a] - lacking.reached[n][a]);
    }
  }
  const auto askAgain = [&]
  {
    for (std::size_t n = 0; n < asked.size(); ++n)
    {
      lacking.handles.moved[n]->probe.displacement = asked[n];
    }
  };
  try
  {
    waves.add(lacking.handles);
    iterations += waves.run(0, checkpoint).iterations;
  }
  catch (...)
  {
    askAgain(); // whoever stops an update finds the probes as they were
    throw;
  }
  askAgain();
  return (lacking.lack - lackingOf(handles).lack) / (share * lacking.lack);
}

}

Further reachFurther(Waves& waves, Handles& handles, const std::function<void()>& settle, const Checkpoint& checkpoint)
{
  constexpr int mostWaves = 40;
  constexpr double leastGain = 0.02; // of what is lacking
  Further further;
  double before = std::numeric_limits<double>::infinity();
  for (int wave = 0; wave < mostWaves; ++wave)
  {
    const Lacking lacking = lackingOf(handles);
    if (lacking.handles.moved.empty() || lacking.lack > (1.0 - leastGain) * before)
    {
      break;
    }
    before = lacking.lack;
    settle();
    // Where turning helps nothing, a wave that asks for all would only be taken back.
    if (wave == 0 && tryShare(leastGain, waves, handles, lacking, checkpoint, further.iterations) < 0.1)
    {
      break;
    }
    waves.add(lacking.handles);
    further.iterations += waves.run(0, checkpoint).iterations;
    further.travelled = true;
  }
  return further;
}

HeldBy findHolder(
  Bricks& bricks, const Model& model, const ModelReduction* reduction, Handles& handles, std::size_t probe)
{
  const std::vector<Handles::Pointer>& all = handles.all();
  HeldBy heldBy;
  const Handle& handle = *all[probe];
  if (handle.probe.anchor || handle.isSoft() || handle.voxels.empty())
  {
    return heldBy;
  }
  const Vector3 reached = handles.reached()[probe].reached;
  Vector3 lack;
  for (int a = 0; a < 3; ++a)
  {
    lack[a] = handle.probe.displacement[a] - reached[a];
  }
  const auto most =
    std::max_element(lack.begin(), lack.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
  const int axis = static_cast<int>(most - lack.begin());
  if (std::fabs(*most) <= 1e-5 * (std::fabs(handle.probe.displacement[axis]) + model.grid().spacing[axis]))
  {
    return heldBy; // no more than rounding
  }
  const std::optional<Grip> grip = findGrip(bricks, all, handle, axis, *most > 0.0 ? 1.0 : -1.0);
  if (!grip)
  {
    return heldBy;
  }
  heldBy.bone = grip->rigidly;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    if (!all[n]->isSoft() && std::binary_search(all[n]->voxels.begin(), all[n]->voxels.end(), grip->voxel))
    {
      heldBy.what = HeldBy::What::Probe;
      heldBy.probe = n;
      return heldBy;
    }
  }
  heldBy.what = HeldBy::What::Rigid;
  for (const std::size_t voxel : reduction ? reduction->voxelsOf(grip->voxel) : std::vector<std::size_t>{ grip->voxel })
  {
    const Index3 at = model.grid().indexOf(voxel);
    const int face = model.anchoringFace(at[0], at[1], at[2]);
    if (face >= 0)
    {
      heldBy.what = HeldBy::What::Face;
      heldBy.face = face;
      return heldBy;
    }
  }
  return heldBy;
}

}
