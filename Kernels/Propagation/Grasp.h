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

}
