// SPDX-License-Identifier: BSD-3-Clause
// Surfaces that cut or carve, and what they did, for warnings that come once.

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

/// What the surfaces of one port did.
class SurfaceHistory
{
public:
  /// All surfaces of an update. Inputs without one are forgotten: what comes there next is another.
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

  /// All tissue is whole and at rest again.
  void Rest()
  {
    this->Places.clear();
    this->Returned.clear();
  }

  /// Keeps in mind where a surface is. Returns whether it was there before, since rest.
  bool Remember(const InputSurface& surface)
  {
    const chainmail::Surface& at = surface.Triangles;
    const Fingerprint points = FingerprintOf(at.points.data(), at.points.size() * sizeof(at.points[0]));
    const Fingerprint corners = FingerprintOf(at.triangles.data(), at.triangles.size() * sizeof(at.triangles[0]));
    return !this->Places.insert({ surface.Name, points, corners }).second;
  }

  /// What a surface that cut or carved has to be warned about; empty: nothing, or nothing new. `removed`: how many
  /// links or elements are gone.
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
  std::set<std::tuple<std::string, Fingerprint, Fingerprint>> Places; // since rest: names, and where they were
  std::set<std::string> Returned;                                     // since rest: those that were told to be back
  std::set<std::string> Missing; // those that removed nothing when they worked last
};

}

#endif
