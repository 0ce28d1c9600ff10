#include "CacheFolder.h"

#include "Notices.h"

#include <cstdint>
#include <cstdlib>
#include <system_error>

#ifndef _WIN32
#include <cerrno>
#include <cstring>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#endif

namespace chainmail
{

namespace fs = std::filesystem;

bool makeFolder(const fs::path& folder)
{
  std::error_code failed;
  fs::create_directories(folder.parent_path(), failed);
#ifdef _WIN32
  fs::create_directory(folder, failed);
#else
  mkdir(folder.c_str(), S_IRWXU); // its content will be run, so only its owner may write
#endif
  return fs::is_directory(folder, failed);
}

#ifdef _WIN32

bool isTrusted(const fs::path&)
{
  return true;
}

std::string whyNotWritable(const fs::path&)
{
  return {};
}

fs::path makePrivateFolder()
{
  return {};
}

#else

bool isTrusted(const fs::path& folder)
{
  struct stat status;
  if (stat(folder.c_str(), &status) != 0)
  {
    return true;
  }
  const bool isOwn = status.st_uid == geteuid() || status.st_uid == 0;
  if (isOwn && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0)
  {
    return true;
  }
  giveNotice("The folder " + folder.string() + " is not used for compiled kernels, because " +
             (isOwn ? "others may write to it" : "it belongs to another user") +
             " and its files would be run. Each start compiles the kernels again. Set the environment variable "
             "CHAINMAIL_CACHE_DIR to a folder of your own" +
             (isOwn ? ", or run: chmod go-w " + folder.string() : std::string(".")));
  return false;
}

namespace
{

/// Bytes that must be free: the machine code of a scene's kernels takes some MB.
constexpr std::uint64_t leastRoom = std::uint64_t(8) << 20;

}

std::string whyNotWritable(const fs::path& folder)
{
  std::string file = (folder / "writable-XXXXXX").string();
  const int descriptor = mkstemp(file.data());
  if (descriptor < 0)
  {
    return std::string("cannot be written to (") + std::strerror(errno) + ")";
  }
  close(descriptor);
  unlink(file.c_str());
  struct statvfs status;
  if (statvfs(folder.c_str(), &status) == 0 && std::uint64_t(status.f_bavail) * status.f_frsize < leastRoom)
  {
    return "is on a disk that is full";
  }
  return {};
}

namespace
{

/// Removes a folder at the end of the process that made it. Processes forked from that one do not remove it.
class UntilTheEnd
{
public:
  ~UntilTheEnd()
  {
    std::error_code ignored;
    if (!this->folder.empty() && this->process == getpid())
    {
      fs::remove_all(this->folder, ignored);
    }
  }

  fs::path folder;
  pid_t process = getpid();
};

/// Whether code may be run from a place and no other user may rename what is there.
bool isGoodPlace(const fs::path& place)
{
  struct statvfs system;
  struct stat status;
  return statvfs(place.c_str(), &system) == 0 && (system.f_flag & ST_NOEXEC) == 0 &&
         stat(place.c_str(), &status) == 0 &&
         ((status.st_mode & S_ISVTX) != 0 || (status.st_mode & (S_IWGRP | S_IWOTH)) == 0);
}

}

fs::path makePrivateFolder()
{
  static UntilTheEnd made;
  const char* const named = std::getenv("TMPDIR");
  for (const fs::path& place :
    { fs::path(named ? named : ""), fs::path("/tmp"), fs::path("/var/tmp"), fs::path("/dev/shm") })
  {
    if (!made.folder.empty() || !place.is_absolute() || !isGoodPlace(place))
    {
      continue;
    }
    std::string folder = (place / "chainmail-XXXXXX").string();
    if (mkdtemp(folder.data()))
    {
      made.folder = folder;
      if (!whyNotWritable(folder).empty())
      {
        std::error_code ignored;
        fs::remove(folder, ignored);
        made.folder.clear();
      }
    }
  }
  return made.folder;
}

#endif

}
