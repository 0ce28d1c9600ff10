// SPDX-License-Identifier: BSD-3-Clause
// Makes warnings about probes: one text for any number of probes, and each probe only once.

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

/// The probes that currently have one kind of problem. A probe is warned about when its problem begins, and again only
/// after an update without it. A probe that is dragged remains the same probe.
class WarnedProbes
{
public:
  void Clear() { this->Probes.clear(); }

  /// `present`: numbers of the probes that have the problem now. Returns those that did not have it at the last call.
  std::vector<std::size_t> Renew(const std::vector<chainmail::Probe>& probes, const std::vector<std::size_t>& present);

private:
  using Place = std::tuple<chainmail::Vector3, double, std::uint64_t>;
  std::set<Place> Probes;
};

/// Warns about probes that hold no tissue, and about probes that reached less than half of their displacement or
/// rotation, except soft probes, for which this is intended.
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
  /// The warning where probes share although ConflictPolicy is not Share.
  std::string OfSharing(
    const chainmail::Method& method, const std::vector<std::size_t>& held, const chainmail::PropagateResult& found);

private:
  WarnedProbes Empty;
  WarnedProbes Short;
  bool Sharing = false; ///< whether probes shared in the last propagation
};

}

#endif
