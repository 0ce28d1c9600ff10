#pragma once

#include "Bricks.h"
#include "Types.h"

#include <string>
#include <vector>

namespace chainmail
{

/// What messages call a probe.
std::string nameOf(const Probe& probe, std::size_t number);

/// What probes with these numbers grab at the places where the elements are now: for each those within its radius, or
/// the nearest one, ascending. Throws ProbeError where there are none.
std::vector<std::vector<std::size_t>> elementsAround(
  Bricks& bricks, const std::vector<Probe>& probes, const std::vector<std::size_t>& numbers);

}
