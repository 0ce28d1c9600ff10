#pragma once

#include "Bricks.h"
#include "Simulation.h"

namespace chainmail
{

/// Removes the links that a surface crosses at the current places of their elements. Returns how many.
///
/// Places and surface are rounded to 1/4096 voxel; from there all decisions are exact (128-bit integers), and an
/// element or edge that the surface passes through exactly is decided as if all tissue were shifted by an infinitesimal
/// (e, e^2, e^3) (simulation of simplicity: Edelsbrunner and Muecke, 1990). So a surface without holes leaves none.
std::size_t cutLinks(Bricks& bricks, const Surface& surface);

}
