#pragma once

#include <filesystem>
#include <string>

namespace chainmail
{

/// Checks of a folder before code in it is run, or before code is written to it. On Windows a user's folders are
/// private to the user, so they pass all checks.

/// Whether only this user and the administrator may write to a folder; true if the folder does not exist. Gives notice
/// (Notices.h) if it returns false.
bool isTrusted(const std::filesystem::path& folder);

/// Creates a folder to which only its owner has access, with its parent folders, unless it exists. Returns whether it
/// exists after that.
bool makeFolder(const std::filesystem::path& folder);

/// Why nothing can be written to a folder, as the end of a sentence (for example "is full"); empty if it can be written
/// to.
std::string whyNotWritable(const std::filesystem::path& folder);

/// A folder that only this process uses, with an unpredictable name, from which code can be run. It is removed at the
/// end of the process. Empty if no such folder can be made.
std::filesystem::path makePrivateFolder();

}
