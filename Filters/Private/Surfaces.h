// SPDX-License-Identifier: BSD-3-Clause
// The polygons of Cuts and Carves as the engine's surfaces.

#ifndef Surfaces_h
#define Surfaces_h

#include "Frame.h"
#include "Inputs.h"

#include "Simulation.h"

#include <string>
#include <vector>

namespace vtkChainMail
{

/// The polygons of one dataset of Cuts or Carves.
struct InputSurface
{
  std::string Name; ///< "Cuts input 0", for messages
  chainmail::Surface Triangles;
};

bool Same(const InputSurface& a, const InputSurface& b);

/// One for each dataset of Cuts. Throws InputError.
std::vector<InputSurface> ReadCuts(const Inputs& inputs, const Frame& space);

/// The datasets of a composite input are surfaces of their own where they are closed, which may overlap. Where they are
/// not they are parts of one, as a process has them of a surface that is spread over several. Throws InputError.
std::vector<InputSurface> ReadCarves(const Inputs& inputs, const Frame& space);

}

#endif
