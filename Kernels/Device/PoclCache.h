#pragma once

#include <filesystem>
#include <string>

namespace chainmail
{

/// PoCL compiles into files: it writes machine code to a folder and the system loads it from there. If PoCL cannot
/// write, it offers no device, or it ends the process. A damaged file ends the process, too. So the engine sets the
/// folder (POCL_CACHE_DIR) when OpenCL is first used, and checks it.
///
/// The folder is the first of these that can be used:
/// 1. the one that POCL_CACHE_DIR names in the environment
/// 2. `pocl` in ProgramCache::userFolder(); without that, PoCL's own in the user's place for caches
/// 3. a private one, which is removed with the process. If 1 or 2 can only be read, its files are linked into this one.
///
/// In 1 and 2 the files of code are first checked against a list beside the folder (sizes, times and hashes of
/// contents). Damaged files are removed, so PoCL compiles them anew.

/// Sets POCL_CACHE_DIR to the folder while the first object of this class lives. PoCL reads the variable once.
class PoclCacheNamed
{
public:
  PoclCacheNamed();
  ~PoclCacheNamed();
  PoclCacheNamed(const PoclCacheNamed&) = delete;
  PoclCacheNamed& operator=(const PoclCacheNamed&) = delete;

private:
  bool isSet_ = false;
  std::string before_;
};

/// To be called before PoCL compiles. Creates the folder again if it was removed. Throws DeviceError if nothing can be
/// written there.
void requirePoclCache();

/// What is wrong with the folder, as a sentence; empty if nothing is wrong.
std::string problemOfPoclCache();

/// Removes damaged files of code from a folder of PoCL, and lists the others.
void checkPoclCache(const std::filesystem::path& folder);

}
