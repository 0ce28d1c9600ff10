#pragma once

#include "Context.h"

#include <string>

namespace baseline
{

/// The program of one .cl file of this folder, with the given -D options and those that the engine builds with.
cl::Program buildProgram(chainmail::Context& context, const std::string& file, const std::string& defines);

}
