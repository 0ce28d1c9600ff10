// SPDX-License-Identifier: BSD-3-Clause
#include "ProbeWarnings.h"

#include "Format.h"
#include "HowFar.h"

#include <algorithm>
#include <iterator>

namespace vtkChainMail
{

namespace
{

/// Lists the names `name(p)` of the first few: "a; b; c; and 240 more."
template <typename F> std::string List(const std::vector<std::size_t>& probes, const F& name)
{
  constexpr std::size_t mostNamed = 3;
  std::string list;
  for (std::size_t n = 0; n < probes.size() && n < mostNamed; ++n)
  {
    list += (n == 0 ? "" : "; ") + name(probes[n]);
  }
  return list + (probes.size() > mostNamed ? "; and " + std::to_string(probes.size() - mostNamed) + " more." : ".");
}

/// What holds a probe back, as the end of a sentence about the probe.
std::string WhatHolds(
  const Scene& scene, const std::vector<std::size_t>& held, std::size_t probe, const chainmail::Simulation& simulation)
{
  using What = chainmail::Limiter::What;
  const auto number = std::find(held.begin(), held.end(), probe) - held.begin();
  const chainmail::Limiter holder = simulation.limiter(static_cast<std::size_t>(number));
  const std::string what = holder.bone ? ", because the bone in its grip " : ", because it is held by tissue that ";
  const char* const faces[] = { "x-", "x+", "y-", "y+", "z-", "z+" };
  switch (holder.what)
  {
  case What::Probe:
    return what + (holder.bone ? "is held by " : "is gripped by ") + scene.NameOf(held[holder.probe]);
  case What::Face:
    return what + "touches the face " + faces[holder.face] + " of the image (AnchoredFaces)";
  case What::Rigid:
    return what + "is rigid and anchored (AnchorRigid)";
  default:
    return {};
  }
}

}

std::vector<std::size_t> WarnedProbes::Renew(
  const std::vector<chainmail::Probe>& probes, const std::vector<std::size_t>& present)
{
  std::vector<std::size_t> added;
  std::set<Place> now;
  for (const std::size_t p : present)
  {
    const Place place(probes[p].position, probes[p].radius, probes[p].body);
    now.insert(place);
    if (this->Probes.count(place) == 0)
    {
      added.push_back(p);
    }
  }
  this->Probes = std::move(now);
  return added;
}

void ProbeWarnings::Clear()
{
  this->Empty.Clear();
  this->Short.Clear();
  this->Sharing = false;
}

std::string ProbeWarnings::OfSharing(
  const chainmail::Method& method, const std::vector<std::size_t>& held, const chainmail::PropagateResult& found)
{
  if (found.iterations == 0)
  {
    return {};
  }
  const bool isNew = found.shared > 0 && !this->Sharing;
  this->Sharing = found.shared > 0;
  if (!isNew || method.conflict == chainmail::ConflictPolicy::Share)
  {
    return {};
  }
  return std::to_string(found.shared) + " of " + std::to_string(held.size()) +
         " probes are in conflict with others. More than 32 moving probes are always treated as with ConflictPolicy "
         "Share: each stops at the mean of the two bounds that the others set. The array ProbeReached has their "
         "displacements.";
}

std::string ProbeWarnings::OfEmptyHandles(
  const Scene& scene, const std::vector<std::size_t>& held, const std::vector<chainmail::ProbeResult>& results)
{
  std::vector<std::size_t> empty;
  std::copy_if(held.begin(), held.end(), std::back_inserter(empty),
    [&results](std::size_t p) { return results[p].elements == 0; });
  const std::vector<std::size_t> added = this->Empty.Renew(scene.Probes, empty);
  if (added.size() == 1)
  {
    return scene.NameOf(added[0]) + ": the probe has no tissue of its own: other probes or anchors hold all tissue "
                                    "within its radius, or the tissue was carved away.";
  }
  if (added.size() > 1)
  {
    return std::to_string(added.size()) + " of " + std::to_string(held.size()) +
           " probes have no tissue of their own: other probes or anchors hold all tissue within their radii, or the "
           "tissue was carved away. They are " +
           List(added, [&](std::size_t p) { return scene.NameOf(p); });
  }
  return {};
}

std::string ProbeWarnings::OfShortProbes(const Scene& scene, const std::vector<std::size_t>& held,
  const std::vector<chainmail::ProbeResult>& results, const chainmail::Simulation& simulation)
{
  // No warning for displacements up to a thousandth of the smallest spacing.
  const Vector3& spacing = scene.Space.GetSpacing();
  const double least = 1e-3 * *std::min_element(spacing.begin(), spacing.end());
  std::vector<std::size_t> shortened;
  for (const std::size_t p : held)
  {
    if (!scene.Probes[p].anchor && !scene.Probes[p].isSoft() && results[p].elements > 0 &&
        HowFar(scene.Probes[p], results[p]).GetShare(least) < 0.5)
    {
      shortened.push_back(p);
    }
  }
  const std::vector<std::size_t> added = this->Short.Renew(scene.Probes, shortened);
  const auto describe = [&](std::size_t p)
  {
    return HowFar(scene.Probes[p], results[p]).ToString([](double number) { return chainmail::toString(number, 3); }) +
           WhatHolds(scene, held, p, simulation);
  };
  if (added.size() == 1)
  {
    return scene.NameOf(added[0]) + ": " + describe(added[0]) + ".";
  }
  if (added.size() > 1)
  {
    return std::to_string(added.size()) + " of " + std::to_string(held.size()) +
           " probes reached less than half of their displacements: " +
           List(added, [&](std::size_t p) { return scene.NameOf(p) + ": " + describe(p); });
  }
  return {};
}

}
