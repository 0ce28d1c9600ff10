// SPDX-License-Identifier: BSD-3-Clause
// Reads the polygons of Cuts and Carves as the engine's surfaces.

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
  std::string Name; ///< the name for messages: "Cuts input 0"
  chainmail::Surface Triangles;
  std::string Flaw; ///< what is wrong with its polygons, as a sentence for the user; may be empty
};

bool Same(const InputSurface& a, const InputSurface& b);

/// One surface for each dataset of Cuts. Throws InputError where a dataset cannot be read as triangles.
std::vector<InputSurface> ReadCuts(const Inputs& inputs, const Frame& space);

/// Each closed dataset of a composite input is a surface of its own; such surfaces may overlap. Datasets that are not
/// closed are joined to one surface: they may be parts that several processes have of one surface. Throws InputError.
std::vector<InputSurface> ReadCarves(const Inputs& inputs, const Frame& space);

}

#endif
