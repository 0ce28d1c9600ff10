#pragma once

#include "Blocks.h"
#include "Session.h"

#include <array>
#include <functional>

namespace bench
{

/// Tissue counts as settled where its energy is within this share of the lowest that the constraints allow.
constexpr double settledShare = 0.01;

/// The energy that relaxation ends at, from the state as it is, with the proof that more of it changes nothing: fifty
/// more sweeps, twice over, lower it by less than a hundredth of settledShare.
double convergedEnergy(chainmail::Simulation& simulation);

/// The sweeps that tissue needs to settle. `start` puts it where relaxation begins. Throws where `most` are not enough.
int sweepsToSettle(
  chainmail::Simulation& simulation, const std::function<void()>& start, double optimum, int most, double tolerance);

/// Milliseconds of one sweep in which all tissue of the block is in motion. Checks that it is.
std::vector<double> denseSweep(Session& session, const Block& block);

/// The same, taking turns with plain C++ (baseline::DenseSweep): the engine's milliseconds, then the other's. These are
/// none where this processor cannot run it.
std::array<std::vector<double>, 2> denseSweeps(Session& session, const Block& block);

/// Milliseconds of one sweep of tissue that turns, taking turns with the same tissue that does not, whose are the
/// second.
std::array<std::vector<double>, 2> turningSweeps(Session& session, const Block& block);

}
