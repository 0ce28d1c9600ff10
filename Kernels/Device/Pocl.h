#pragma once

#include "ArgumentList.h"

#include <string>

namespace chainmail
{

/// Whether a device is one of PoCL (http://portablecl.org), which runs OpenCL on processors.
bool isPocl(const cl::Device& device);

/// A program for PoCL as LLVM bitcode, which PoCL takes as a binary. Empty where it cannot be had.
///
/// With PoCL comes Clang's header of all built-in functions of OpenCL, about 15,000 declarations, which take longer to
/// read than most programs. `wholeHeader` says whether it is read, or the declarations of builtins.clh are in its
/// place.
///
/// PoCL translates a source to bitcode, and each kernel to machine code when it is first launched with work-groups of
/// some size. Asked for its own kind of binary, it would first compile every kernel of the program for work-groups of
/// any size, which takes as long as all the rest and which no launch uses. Bitcode is found inside the binary of a
/// program that is compiled and not linked. PoCL itself keeps the machine code for the next process.
std::string poclBitcode(
  const cl::Device& device, const std::string& source, const std::string& options, bool wholeHeader);

}
