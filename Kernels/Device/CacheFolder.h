#pragma once

#include <filesystem>
#include <string>

namespace chainmail
{

/// What has to be known of a folder before code is read from it and run, or written to it. On Windows a user's folders
/// are the user's alone, and all of this holds.

/// Whether nobody but this user and the administrator may put anything into a folder; true where there is none. Gives
/// notice (Notices.h) where it is not so.
bool isTrusted(const std::filesystem::path& folder);

/// Makes a folder that is its owner's alone, unless it is there, and the folders above it. Returns whether it is there.
bool makeFolder(const std::filesystem::path& folder);

/// Why nothing can be written to a folder, as the end of a sentence, "is full" for example; empty where it can.
std::string whyNotWritable(const std::filesystem::path& folder);

/// A folder that is this process's alone, under a name that nobody can foresee, from which code can be run. It goes
/// when the process ends. Empty where there is no place for one.
std::filesystem::path makePrivateFolder();

}
