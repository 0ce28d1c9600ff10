// SPDX-License-Identifier: BSD-3-Clause
// Remembers which surfaces cut or carved, and with what success, so that each warning comes once and the report can
// tell.

#ifndef SurfaceHistory_h
#define SurfaceHistory_h

#include "Fingerprint.h"
#include "Surfaces.h"

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace vtkChainMail
{

/// The history of the surfaces of one port.
class SurfaceHistory
{
public:
  /// Begins an update with all its surfaces. Inputs without one are forgotten: the next surface there is another.
  void Begin(const std::vector<InputSurface>& present)
  {
    std::map<std::string, std::string> said;
    std::map<std::string, Fingerprint> missing;
    for (const InputSurface& one : present)
    {
      const auto miss = this->Missing.find(one.Name);
      if (miss != this->Missing.end())
      {
        missing.insert(*miss);
      }
      const auto before = this->Said.find(one.Name);
      if (before != this->Said.end())
      {
        said.insert(*before);
      }
    }
    this->Missing = std::move(missing);
    this->Said = std::move(said);
  }

  /// The names of surfaces that removed nothing the last time they worked.
  std::vector<std::string> GetMissing() const
  {
    std::vector<std::string> names;
    for (const auto& one : this->Missing)
    {
      names.push_back(one.first);
    }
    return names;
  }

  /// The warning about what a surface is like; empty where there is none, or none that differs from the last one.
  std::string About(const InputSurface& surface, const std::string& what)
  {
    std::string& before = this->Said[surface.Name];
    const bool isNew = before != what && !what.empty();
    before = what;
    return isNew ? surface.Name + ": " + what : std::string();
  }

  /// To be called when all tissue is whole and at rest again.
  void Rest()
  {
    this->Places.clear();
    this->Returned.clear();
  }

  /// Remembers where a surface is. Returns whether it was there before, since rest.
  bool Remember(const InputSurface& surface)
  {
    const chainmail::Surface& at = surface.Triangles;
    const Fingerprint points = FingerprintOf(at.points.data(), at.points.size() * sizeof(at.points[0]));
    const Fingerprint corners = FingerprintOf(at.triangles.data(), at.triangles.size() * sizeof(at.triangles[0]));
    return !this->Places.insert({ surface.Name, points, corners }).second;
  }

  /// The warning about a surface that has cut or carved; empty where there is none, or no new one. `removed` is how
  /// many links or elements it took away.
  std::string Worked(const InputSurface& surface, std::size_t removed)
  {
    if (removed > 0)
    {
      this->Missing.erase(surface.Name);
    }
    if (this->Remember(surface))
    {
      return this->Returned.insert(surface.Name).second
               ? surface.Name +
                   " is back where it was before; in Interactive mode what was cut stays cut: Reset brings the "
                   "tissue back."
               : std::string();
    }
    if (removed > 0)
    {
      return {};
    }
    // One that moves through air is the same surface still, one with other triangles is another.
    const Fingerprint triangles = FingerprintOf(
      surface.Triangles.triangles.data(), surface.Triangles.triangles.size() * sizeof(surface.Triangles.triangles[0]));
    const auto before = this->Missing.find(surface.Name);
    const bool isKnown = before != this->Missing.end() && before->second == triangles;
    this->Missing[surface.Name] = triangles;
    if (isKnown)
    {
      return {};
    }
    return surface.Name + " met no tissue, or only what was cut before. Move it into tissue, or disconnect it.";
  }

private:
  std::set<std::tuple<std::string, Fingerprint, Fingerprint>> Places; // names and places since rest
  std::set<std::string> Returned;                                     // since rest, warned about as back
  std::map<std::string, Fingerprint> Missing; // surfaces that removed nothing the last time, and their triangles
  std::map<std::string, std::string> Said;    // what was said of surfaces that are there
};

}

#endif
