#pragma once

#include "HeldBy.h"
#include "ModelReduction.h"
#include "Waves.h"

#include <functional>

namespace chainmail
{

/// What reachFurther() did.
struct Further
{
  int iterations = 0;     ///< of the waves
  bool travelled = false; ///< whether a wave travelled again, but for the small step
};

/// Lets tissue settle between one wave and the next: a little or, where probes turn, until what is around them has
/// followed. `thoroughly`: after a wave that gained nothing.
using Settle = std::function<void(bool anyTurns, bool thoroughly)>;

/// Lets the waves of probes that came less far than asked travel again, for as long as they gain. Waves move bones and
/// do not turn them, and where elements turn, what a probe can reach grows with the rotation of bones. Probes that turn
/// go in steps. After the first time a small step of those that do not tells whether settling helps at all.
Further reachFurther(Waves& waves, Handles& handles, const Settle& settle, const Checkpoint& checkpoint);

/// Simulation::heldBy(), where no wave is under way. `reduction` is null where the model is not reduced; `bricks` are
/// the elements that deform, and `model` is that of the voxels.
HeldBy findHolder(
  Bricks& bricks, const Model& model, const ModelReduction* reduction, Handles& handles, std::size_t probe);

}
