// SPDX-License-Identifier: BSD-3-Clause
// Warnings about one or a thousand probes.

#ifndef ProbeWarnings_h
#define ProbeWarnings_h

#include "Scene.h"

#include "Simulation.h"

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vtkChainMail
{

/// Probes that give reason for a warning. Each is warned about when it begins to, and again only after it ceased to: a
/// probe that is dragged is still the same.
class WarnedProbes
{
public:
  void Clear() { this->Probes.clear(); }

  /// `present`: the numbers of the probes that do so now. Returns those that did not before.
  std::vector<std::size_t> Renew(const std::vector<chainmail::Probe>& probes, const std::vector<std::size_t>& present);

private:
  using Place = std::pair<chainmail::Vector3, double>;
  std::set<Place> Probes;
};

/// Probes that hold nothing, and those that got far less than they asked for.
class ProbeWarnings
{
public:
  void Clear();

  /// What there is to say after an update of these probes, which the simulation holds; empty: nothing, or nothing new.
  /// `results`: of all probes of the scene.
  std::string OfEmptyHandles(
    const Scene& scene, const std::vector<std::size_t>& held, const std::vector<chainmail::ProbeResult>& results);
  std::string OfShortProbes(const Scene& scene, const std::vector<std::size_t>& held,
    const std::vector<chainmail::ProbeResult>& results, const chainmail::Simulation& simulation);

private:
  WarnedProbes Empty;
  WarnedProbes Short;
};

}

#endif
