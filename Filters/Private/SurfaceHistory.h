// SPDX-License-Identifier: BSD-3-Clause
// Records which surfaces cut or carved, and whether they removed anything. So each warning is given once, and the
// report can name the surfaces that removed nothing.

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
  /// Begins an update with all its surfaces. Inputs without a surface are forgotten, so their next surface counts as
  /// new.
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

  /// The names of surfaces that removed nothing when they were last applied.
  std::vector<std::string> GetMissing() const
  {
    std::vector<std::string> names;
    for (const auto& one : this->Missing)
    {
      names.push_back(one.first);
    }
    return names;
  }

  /// The warning `what` about the shape of a surface; empty where it is empty or the same as last time.
  std::string About(const InputSurface& surface, const std::string& what)
  {
    std::string& before = this->Said[surface.Name];
    const bool isNew = before != what && !what.empty();
    before = what;
    return isNew ? surface.Name + ": " + what : std::string();
  }

  /// To be called when all tissue is restored and at rest.
  void Rest()
  {
    this->Places.clear();
    this->Returned.clear();
  }

  /// Records the place of a surface. Returns whether the surface was at this place before, since rest.
  bool Remember(const InputSurface& surface)
  {
    const chainmail::Surface& at = surface.Triangles;
    const Fingerprint points = FingerprintOf(at.points.data(), at.points.size() * sizeof(at.points[0]));
    const Fingerprint corners = FingerprintOf(at.triangles.data(), at.triangles.size() * sizeof(at.triangles[0]));
    return !this->Places.insert({ surface.Name, points, corners }).second;
  }

  /// The warning about a surface after it cut or carved; empty where there is no new one. `removed`: the number of
  /// links or elements that it removed.
  std::string Worked(const InputSurface& surface, std::size_t removed)
  {
    if (removed > 0)
    {
      this->Missing.erase(surface.Name);
    }
    if (this->Remember(surface))
    {
      return this->Returned.insert(surface.Name).second
               ? surface.Name + " is back where it was before, but in Interactive mode what was cut stays cut. Press "
                                "Reset to bring the tissue back."
               : std::string();
    }
    if (removed > 0)
    {
      return {};
    }
    // A surface that moves through air remains the same surface; with other triangles it is a new one.
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
  std::set<std::string> Returned;                                     // warned about as returned, since rest
  std::map<std::string, Fingerprint> Missing; // surfaces that last removed nothing, and the hash of their triangles
  std::map<std::string, std::string> Said;    // last warning about the shape of each present surface
};

}

#endif
