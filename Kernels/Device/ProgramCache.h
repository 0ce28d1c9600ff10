#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

namespace chainmail
{

/// Keeps compiled programs in files, from one process to the next. Each program has a key that names everything it
/// depends on. No function here throws or fails: a file that cannot be read counts as missing, and a program that
/// cannot be written is not kept.
///
/// Any number of processes may use a folder at once, and it may be deleted at any time. A file is written under a
/// temporary name and then renamed, so no process reads an incomplete one. It begins with its key and the hash of its
/// content. A file that is truncated, damaged or of another key is not used, and is replaced. A folder to which others
/// may write is not used either (isTrusted).
class ProgramCache
{
public:
  /// Bytes of all files together. Where a new file would exceed this, those written first are deleted.
  static constexpr std::uintmax_t defaultLimit = std::uintmax_t(256) << 20;

  /// The folder for this user's programs: the one that the environment variable CHAINMAIL_CACHE_DIR names, else
  /// `chainmail` in the system's place for caches. Empty, which means no cache, where the variable is set but empty or
  /// the system has no such place.
  static std::filesystem::path userFolder();

  /// A folder of this name in the system's place for this user's caches; empty where there is no such place.
  static std::filesystem::path systemFolder(const char* name);

  /// With an empty path nothing is ever found or kept. The folder is created when the first program is kept.
  explicit ProgramCache(std::filesystem::path folder, std::uintmax_t limit = defaultLimit)
    : folder_(std::move(folder))
    , limit_(limit)
  {
  }

  /// The program kept under `key`; empty where there is none.
  std::string find(const std::string& key) const noexcept;

  /// Keeps the result of `program`, unless it is empty. Calls `program` only if a file can be written, because some
  /// drivers take long to return a program.
  void keep(const std::string& key, const std::function<std::string()>& program) const noexcept;

private:
  std::filesystem::path fileOf(const std::string& key) const;
  std::string read(const std::string& key) const;
  void write(const std::string& key, const std::function<std::string()>& program) const;
  void prune() const;

  std::filesystem::path folder_;
  std::uintmax_t limit_;
};

}
