#pragma once

#include "Bricks.h"
#include "Types.h"

#include <string>
#include <vector>

namespace chainmail
{

/// The name of a probe in messages.
std::string nameOf(const Probe& probe, std::size_t number);

/// The elements that the probes with these numbers grab, at the current places of the elements: for each probe those
/// within its radius, or the nearest one, ascending. Throws ProbeError for a probe without any.
std::vector<std::vector<std::size_t>> elementsAround(
  Bricks& bricks, const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers);

/// Elements that a probe which turns is to hold, with the stiff ones in the notches of the bones among them. Between
/// two neighbours that rotate, stiff tissue can neither turn without moving nor move without turning, and would hold
/// the bone.
std::vector<std::size_t> withNotches(const Bricks& bricks, std::vector<std::size_t> elements);

}
