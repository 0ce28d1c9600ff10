// SPDX-License-Identifier: BSD-3-Clause
// Private to vtkChainMailDeformation: what surfaces that cut or carve did, for warnings that come once.

#ifndef vtkChainMailSurfaceHistory_h
#define vtkChainMailSurfaceHistory_h

#include "Simulation.h"

#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

/// The polygons of one input of Cuts or Carves.
struct vtkChainMailInputSurface
{
  int Input;
  chainmail::Surface Triangles;
};

/**
 * What the surfaces of one port did.
 */
class vtkChainMailSurfaceHistory
{
public:
  explicit vtkChainMailSurfaceHistory(const char* port)
    : Port(port)
  {
  }

  /// All surfaces of an update. Inputs without one are forgotten: what comes there next is another one.
  void Begin(const std::vector<vtkChainMailInputSurface>& present)
  {
    std::set<int> missing;
    for (const vtkChainMailInputSurface& one : present)
    {
      if (this->Missing.count(one.Input) > 0)
      {
        missing.insert(one.Input);
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
  bool Remember(const vtkChainMailInputSurface& surface)
  {
    const chainmail::Surface& at = surface.Triangles;
    return !this->Places.insert({ surface.Input, Hash(at.points), Hash(at.triangles) }).second;
  }

  /// What a surface that cut or carved has to be warned about; empty: nothing, or nothing new. `removed`: how many
  /// links or elements are gone.
  std::string Worked(const vtkChainMailInputSurface& surface, std::size_t removed)
  {
    const std::string name = this->Port + " input " + std::to_string(surface.Input);
    if (removed > 0)
    {
      this->Missing.erase(surface.Input);
    }
    if (this->Remember(surface))
    {
      return this->Returned.insert(surface.Input).second
               ? name + " is back where it was before; in Interactive mode what was cut stays cut: Reset brings the "
                        "tissue back."
               : std::string();
    }
    if (removed > 0 || !this->Missing.insert(surface.Input).second)
    {
      return {};
    }
    return name + " met no tissue, or only what was cut before. Move it into tissue, or disconnect it.";
  }

private:
  template <typename T> static std::size_t Hash(const std::vector<T>& values)
  {
    return std::hash<std::string_view>()({ reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T) });
  }

  std::string Port;
  std::set<std::tuple<int, std::size_t, std::size_t>> Places; // since rest: input and hashes of what was there
  std::set<int> Returned;                                     // since rest: inputs that were told to be back
  std::set<int> Missing;                                      // inputs that removed nothing when they worked last
};

#endif
