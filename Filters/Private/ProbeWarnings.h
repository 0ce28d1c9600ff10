// SPDX-License-Identifier: BSD-3-Clause
// Warnings about one or a thousand probes.

#ifndef ProbeWarnings_h
#define ProbeWarnings_h

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
  std::vector<std::size_t> Renew(const std::vector<chainmail::Probe>& probes, const std::vector<std::size_t>& present)
  {
    std::vector<std::size_t> added;
    std::set<Place> now;
    for (const std::size_t p : present)
    {
      const Place place(probes[p].position, probes[p].radius);
      now.insert(place);
      if (this->Probes.count(place) == 0)
      {
        added.push_back(p);
      }
    }
    this->Probes = std::move(now);
    return added;
  }

private:
  using Place = std::pair<chainmail::Vector3, double>;
  std::set<Place> Probes;
};

/// "a; b; c; and 240 more.": `name(p)` of the first few.
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

}

#endif
