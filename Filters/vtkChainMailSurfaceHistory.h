// SPDX-License-Identifier: BSD-3-Clause
// Private to vtkChainMailDeformation: which of the surfaces that cut or carve did nothing, for warnings that come once.

#ifndef vtkChainMailSurfaceHistory_h
#define vtkChainMailSurfaceHistory_h

#include "Simulation.h"

#include <algorithm>
#include <set>
#include <string>
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

  /// What a surface that cut or carved has to be warned about; empty: nothing, or nothing new. `removed`: how many
  /// links or elements are gone.
  std::string Worked(const vtkChainMailInputSurface& surface, std::size_t removed)
  {
    const std::string name = this->Port + " input " + std::to_string(surface.Input);
    if (removed > 0)
    {
      this->Missing.erase(surface.Input);
      return {};
    }
    if (!this->Missing.insert(surface.Input).second)
    {
      return {};
    }
    return name + " met no tissue, or only what was cut before. Move it into tissue, or disconnect it.";
  }

private:
  std::string Port;
  std::set<int> Missing; // inputs that removed nothing when they worked last
};

#endif
