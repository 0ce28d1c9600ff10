#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

namespace chainmail
{

/// Compiled programs in files, from one start of a process to the next: bytes under a key, which holds all that they
/// depend on. Nothing here throws or fails: what cannot be read is not there, and what cannot be written is not kept.
///
/// Any number of processes may use a folder at once, and it may be deleted at any time. A file is written under a name
/// of its own and then renamed, so that nobody sees half of one. It begins with its key and the hash of its content:
/// one that is truncated, damaged or of another key is not used, and is replaced.
class ProgramCache
{
public:
  /// Of the files together [bytes]. Where more comes in, those that were written first go.
  static constexpr std::uintmax_t defaultLimit = std::uintmax_t(256) << 20;

  /// Where programs of this user are kept: in the folder that the environment variable CHAINMAIL_CACHE_DIR names, else
  /// in `chainmail` where the system has its caches. Empty, for no cache, where the variable is, or there is no such
  /// place.
  static std::filesystem::path userFolder();

  /// With an empty path nothing is ever found or kept. The folder is made when something is.
  explicit ProgramCache(std::filesystem::path folder, std::uintmax_t limit = defaultLimit)
    : folder_(std::move(folder))
    , limit_(limit)
  {
  }

  /// What was kept under `key`; empty where nothing was.
  std::string find(const std::string& key) const noexcept;

  /// Keeps what `program` returns, unless that is empty. It is called only where there is a place to write to: a driver
  /// may take its time to give a program away.
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
