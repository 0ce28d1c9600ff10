// SPDX-License-Identifier: BSD-3-Clause
// Makes warnings about probes, be it one or a thousand, and gives each only once.

#ifndef ProbeWarnings_h
#define ProbeWarnings_h

#include "Scene.h"

#include "Simulation.h"

#include <atomic>
#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace vtkChainMail
{

/// Probes that give reason for one kind of warning. A probe is warned about when it begins to, and again only after it
/// has ceased to in between; a probe that is dragged is still the same.
class WarnedProbes
{
public:
  void Clear() { this->Probes.clear(); }

  /// `present` are the numbers of the probes that give reason now. Returns those that did not at the last call.
  std::vector<std::size_t> Renew(const std::vector<chainmail::Probe>& probes, const std::vector<std::size_t>& present);

private:
  using Place = std::tuple<chainmail::Vector3, double, std::uint64_t>;
  std::set<Place> Probes;
};

/// Warns about probes that hold nothing, and about those that got far less than they asked for; soft ones are meant to.
class ProbeWarnings
{
public:
  /// Of all filters of this process, see vtkChainMailDeformation::SetGlobalProbeWarnings().
  static inline std::atomic<bool> AreOn{ true };

  void Clear();

  /// The warning after an update; empty where there is none, or no new one. `held` are the numbers of the probes that
  /// the simulation holds, `results` those of all probes of the scene.
  std::string OfEmptyHandles(
    const Scene& scene, const std::vector<std::size_t>& held, const std::vector<chainmail::ProbeResult>& results);
  std::string OfShortProbes(const Scene& scene, const std::vector<std::size_t>& held,
    const std::vector<chainmail::ProbeResult>& results, const chainmail::Simulation& simulation);
  /// Where probes share although that is not the policy.
  std::string OfSharing(
    const Method& method, const std::vector<std::size_t>& held, const chainmail::PropagateResult& found);

private:
  WarnedProbes Empty;
  WarnedProbes Short;
  bool Sharing = false; ///< whether the last probes that moved shared
};

}

#endif
