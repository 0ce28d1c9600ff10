#pragma once

#include "ArgumentList.h"

#include <string>

namespace chainmail
{

/// Whether a device is one of PoCL (http://portablecl.org), which runs OpenCL on processors.
bool isPocl(const cl::Device& device);

/// A program for PoCL as LLVM bitcode, which PoCL accepts as a binary. Empty if it cannot be produced.
///
/// PoCL uses Clang's header of all built-in functions of OpenCL. Its roughly 15,000 declarations take longer to parse
/// than most programs. `wholeHeader` says whether this header is parsed, or the declarations of builtins.clh replace
/// it.
///
/// PoCL translates a source to bitcode. It translates each kernel to machine code at the first launch with work-groups
/// of some size. If asked for its own kind of binary, it first compiles every kernel of the program for work-groups of
/// any size. No launch uses that, and it takes as long as all the rest. The binary of a program that is compiled and
/// not linked contains the bitcode. PoCL itself keeps the machine code for the next process.
std::string poclBitcode(
  const cl::Device& device, const std::string& source, const std::string& options, bool wholeHeader);

}
