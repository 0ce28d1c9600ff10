#pragma once

#include <filesystem>
#include <string>

namespace chainmail
{

/// PoCL compiles into files: it writes machine code to a folder and has the system load it from there. Where it cannot
/// write it has no device, or ends the process; a file that is damaged ends it, too. So the engine names the folder
/// (POCL_CACHE_DIR) when OpenCL is first used, and looks after it.
///
/// The folder is, as the first of these that can be used:
/// 1. the one that POCL_CACHE_DIR names in the environment
/// 2. `pocl` in ProgramCache::userFolder(); without that, PoCL's own in the user's place for caches
/// 3. a private one, which goes with the process. If 1 or 2 can be read alone, what it holds is found there, too.
///
/// Of 1 and 2 files of code are checked first, by what a list beside the folder says of their sizes and contents, and
/// those that are damaged are removed, so that PoCL compiles anew.

/// While the first object lives, the environment names the folder. PoCL reads that once.
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

/// To be called before PoCL compiles. Makes the folder again where somebody has removed it. Throws DeviceError where
/// nothing can be written.
void requirePoclCache();

/// What is wrong with the folder, as a sentence; empty where nothing is.
std::string problemOfPoclCache();

/// Removes files of code that are damaged from a folder of PoCL, and writes down the others.
void checkPoclCache(const std::filesystem::path& folder);

}
