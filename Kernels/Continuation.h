#pragma once

#include "HoldingElement.h"
#include "ModelReduction.h"
#include "Waves.h"

#include <functional>

namespace chainmail
{

/// What continueWaves() did.
struct Continued
{
  int iterations = 0;     ///< of the waves
  bool travelled = false; ///< whether a wave travelled again, not counting the small trial step
};

/// Relaxes tissue between two waves: a little or, where probes rotate (`anyRotates`), until the tissue around them has
/// followed. `thoroughly`: after a wave that gained nothing.
using Settle = std::function<void(bool anyRotates, bool thoroughly)>;

/// Repeats the waves of probes that fell short of their targets, as long as they gain: 2 % of the requested
/// displacement or a quarter of what is missing, where no probe rotates. Waves translate bones and do not rotate them.
/// Where elements rotate, a probe can reach further once bones have rotated. Probes that rotate move in steps. If none
/// rotates, a small trial step after the first settling tests whether settling helps at all.
Continued continueWaves(Waves& waves, Handles& handles, const Settle& settle, const Checkpoint& checkpoint);

/// Simulation::limiter(), where no wave is under way. `reduction` is null where the model is not reduced; `bricks` are
/// the elements that deform, and `model` is that of the voxels.
Limiter findLimiter(
  Bricks& bricks, const Model& model, const ModelReduction* reduction, Handles& handles, std::size_t probe);

}
