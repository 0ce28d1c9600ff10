#pragma once

#include "Bricks.h"
#include "Types.h"

#include <string>
#include <vector>

namespace chainmail
{

/// The name of a probe in messages.
std::string nameOf(const Probe& probe, std::size_t number);

/// The elements that the probes with these numbers grab, by the current places of the elements: for each probe those
/// within its radius, or the nearest one, ascending. Throws ProbeError for a probe without any.
std::vector<std::vector<std::size_t>> elementsAround(
  Bricks& bricks, const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers);

/// The elements of a probe that prescribes a rotation, and the stiff elements in the notches of their bones, ascending.
/// Stiff tissue between two rotating neighbours can neither rotate without moving nor move without rotating. So it
/// would block the bone unless the probe holds it, too.
std::vector<std::size_t> withNotches(const Bricks& bricks, std::vector<std::size_t> elements);

}
