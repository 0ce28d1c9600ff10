// SPDX-License-Identifier: BSD-3-Clause
// Remembers which surfaces cut or carved, and with what success, so that each warning comes once.

#ifndef SurfaceHistory_h
#define SurfaceHistory_h

#include "Fingerprint.h"
#include "Surfaces.h"

#include <set>
#include <string>
#include <tuple>
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
    std::set<std::string> missing;
    for (const InputSurface& one : present)
    {
      if (this->Missing.count(one.Name) > 0)
      {
        missing.insert(one.Name);
      }
    }
    this->Missing = std::move(missing);
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
    if (removed > 0 || !this->Missing.insert(surface.Name).second)
    {
      return {};
    }
    return surface.Name + " met no tissue, or only what was cut before. Move it into tissue, or disconnect it.";
  }

private:
  std::set<std::tuple<std::string, Fingerprint, Fingerprint>> Places; // names and places since rest
  std::set<std::string> Returned;                                     // since rest, warned about as back
  std::set<std::string> Missing; // surfaces that removed nothing the last time they worked
};

}

#endif
