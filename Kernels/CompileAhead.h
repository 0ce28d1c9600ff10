#pragma once

#include "Types.h"

namespace chainmail
{

/// Has the kernels that most scenes use compiled in the background for simulations with these settings, so that the
/// first of them waits less or not at all. Returns at once, does nothing where the cache has them or where this was
/// called before for the same device and bricks, and reports no errors: the simulation will.
///
/// A process that ends meanwhile waits for the kernel that is being compiled, and for no other.
void compileAhead(const Settings& settings);

}
