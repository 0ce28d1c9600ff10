#include "PoclCache.h"

#include "CacheFolder.h"
#include "Error.h"
#include "Hash.h"
#include "Notices.h"
#include "ProgramCache.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <system_error>

#ifndef _WIN32
#include <unistd.h>
#endif

namespace chainmail
{

namespace fs = std::filesystem;

#ifdef _WIN32 // on Windows PoCL, if installed, writes to a place of the user's own

PoclCacheNamed::PoclCacheNamed() = default;
PoclCacheNamed::~PoclCacheNamed() = default;

void requirePoclCache()
{
}

std::string problemOfPoclCache()
{
  return {};
}

void checkPoclCache(const fs::path&)
{
}

#else

namespace
{

constexpr const char* variable = "POCL_CACHE_DIR";

/// The list's entry for a file of code.
struct Entry
{
  std::uintmax_t bytes = 0;
  std::int64_t toString = 0; ///< time of the last write
  std::uint64_t hash = 0;

  bool operator==(const Entry& other) const
  {
    return this->bytes == other.bytes && this->toString == other.toString && this->hash == other.hash;
  }
};

/// The list of entries, by the paths of files in the folder.
using List = std::map<std::string, Entry>;

fs::path listOf(const fs::path& folder)
{
  return folder.parent_path() / (folder.filename().string() + ".checksums");
}

List readList(const fs::path& folder)
{
  List list;
  std::ifstream file(listOf(folder));
  Entry entry;
  for (std::string path; file >> entry.bytes >> entry.toString >> entry.hash >> std::ws && std::getline(file, path);)
  {
    list[path] = entry;
  }
  return list;
}

/// Writes to a temporary name and renames it when complete, because other processes may read the list meanwhile.
void writeList(const fs::path& folder, const List& list)
{
  const fs::path unfinished = listOf(folder).string() + '.' + std::to_string(getpid());
  std::ofstream file(unfinished);
  for (const auto& [path, entry] : list)
  {
    file << entry.bytes << ' ' << entry.toString << ' ' << entry.hash << ' ' << path << '\n';
  }
  file.close();
  std::error_code failed;
  if (file)
  {
    fs::rename(unfinished, listOf(folder), failed);
  }
  if (!file || failed)
  {
    fs::remove(unfinished, failed);
  }
}

std::string contentOf(const fs::path& path)
{
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Whether a library without an entry is complete: linkers write the table of sections last.
bool isWholeLibrary(const std::string& content)
{
  constexpr std::size_t headBytes = 64; // of a 64-bit ELF file
  if (content.size() < headBytes || content.compare(0, 5, "\177ELF\2") != 0)
  {
    return false;
  }
  std::uint64_t table = 0;
  std::uint16_t entryBytes = 0, entries = 0;
  std::memcpy(&table, content.data() + 40, sizeof table);
  std::memcpy(&entryBytes, content.data() + 58, sizeof entryBytes);
  std::memcpy(&entries, content.data() + 60, sizeof entries);
  return table <= content.size() && std::uint64_t(entryBytes) * entries <= content.size() - table;
}

/// The same for LLVM's bitcode: blocks follow each other, each with its length in its second word, counted in words.
bool isWholeBitcode(const std::string& content)
{
  std::size_t end = 4;
  while (content.compare(0, 2, "BC") == 0 && end + 8 <= content.size())
  {
    std::uint32_t words = 0;
    std::memcpy(&words, content.data() + end + 4, sizeof words);
    end += 8 + 4 * std::size_t(words);
  }
  return end > 4 && end == content.size();
}

/// Whether a file of code has the final name that PoCL gives it: program.bc, or KERNEL/SIZES/KERNEL.so. A file that
/// PoCL is still writing, perhaps in another process, has a different name. It begins with "tempfile" or, since PoCL 7,
/// it lies beside the final one as "parallel" and some letters.
bool isFinished(const fs::path& file)
{
  return file.extension() == ".so"   ? file.stem() == file.parent_path().parent_path().filename()
         : file.extension() == ".bc" ? file.filename() == "program.bc"
                                     : false;
}

/// Calls f(file, its path in the folder) for all finished files of code in the folder.
template <typename F> void forFiles(const fs::path& folder, const F& f)
{
  std::error_code failed;
  auto entry = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, failed);
  for (; !failed && entry != fs::recursive_directory_iterator(); entry.increment(failed))
  {
    std::error_code gone;
    if (isFinished(entry->path()) && entry->is_regular_file(gone))
    {
      f(*entry, entry->path().lexically_relative(folder).string());
    }
  }
}

}

void checkPoclCache(const fs::path& folder)
{
  const List before = readList(folder);
  List now;
  forFiles(folder,
    [&](const fs::directory_entry& file, const std::string& path)
    {
      std::error_code gone; // set if another process has removed the file
      Entry entry;
      entry.bytes = file.file_size(gone);
      entry.toString = file.last_write_time(gone).time_since_epoch().count();
      const auto known = before.find(path);
      const bool isKnown = known != before.end();
      if (isKnown && known->second.bytes == entry.bytes && known->second.toString == entry.toString)
      {
        now.insert(*known);
        return;
      }
      const std::string content = contentOf(file.path());
      entry.hash = hashOf(content);
      const bool isRight = isKnown ? known->second.hash == entry.hash && known->second.bytes == entry.bytes
                           : file.path().extension() == ".so" ? isWholeLibrary(content)
                                                              : isWholeBitcode(content);
      if (isRight && !gone)
      {
        now[path] = entry;
      }
      else
      {
        fs::remove(file.path(), gone);
      }
    });
  if (now != before)
  {
    writeList(folder, now);
  }
}

namespace
{

/// Makes links to the files of a read-only folder in a folder of this process, where PoCL finds them. Returns the
/// number of files.
std::size_t linkFiles(const fs::path& from, const fs::path& to)
{
  std::size_t files = 0;
  forFiles(from,
    [&](const fs::directory_entry& file, const std::string& path)
    {
      std::error_code failed;
      fs::create_directories((to / path).parent_path(), failed);
      fs::create_symlink(file.path(), to / path, failed);
      ++files;
    });
  return files;
}

/// The folder that PoCL uses in this process, and its check at the end of the process.
class PoclCache
{
public:
  PoclCache()
  {
    const char* const named = std::getenv(variable);
    const fs::path own = ProgramCache::userFolder();
    const bool isNamed = named && *named;
    const fs::path wish = isNamed        ? fs::absolute(named)
                          : !own.empty() ? own / "pocl"
                                         : ProgramCache::systemFolder("pocl") / "kcache";
    const bool mayUse = wish.is_absolute() && (isNamed || own.empty() || isTrusted(own)) && isTrusted(wish);
    const std::string why = !mayUse ? std::string() : !makeFolder(wish) ? "cannot be made" : whyNotWritable(wish);
    if (mayUse && why.empty())
    {
      this->folder_ = wish;
      checkPoclCache(wish);
      this->checks_ = true;
      return;
    }
    this->folder_ = makePrivateFolder();
    if (mayUse && linkFiles(wish, this->folder_) == 0)
    {
      giveNotice("The folder " + wish.string() + ' ' + why +
                 ", so kernels that are compiled now are lost when this process ends. Set the environment variable "
                 "CHAINMAIL_CACHE_DIR to a folder that you can write to.");
    }
  }
  ~PoclCache()
  {
    if (this->checks_ && this->process_ == getpid())
    {
      checkPoclCache(this->folder_);
    }
  }

  const fs::path& folder() const { return this->folder_; }

private:
  fs::path folder_; ///< empty if no place was found
  bool checks_ = false;
  pid_t process_ = getpid();
};

PoclCache& poclCache()
{
  static PoclCache cache;
  return cache;
}

bool wasNamed = false;

}

PoclCacheNamed::PoclCacheNamed()
{
  if (!wasNamed && !poclCache().folder().empty())
  {
    const char* const before = std::getenv(variable);
    this->before_ = before ? before : "";
    setenv(variable, poclCache().folder().c_str(), 1);
    this->isSet_ = true;
  }
  wasNamed = true;
}

PoclCacheNamed::~PoclCacheNamed()
{
  if (this->isSet_) // child processes choose their own folder
  {
    this->before_.empty() ? unsetenv(variable) : setenv(variable, this->before_.c_str(), 1);
  }
}

std::string problemOfPoclCache()
{
  const fs::path& folder = poclCache().folder();
  if (folder.empty())
  {
    return "PoCL needs a folder to write to, but neither the user's cache folder nor /tmp can be written to. Set the "
           "environment variable CHAINMAIL_CACHE_DIR to a folder that you can write to.";
  }
  const std::string why = makeFolder(folder) ? whyNotWritable(folder) : "is gone and cannot be made again";
  return why.empty() ? std::string()
                     : "The folder " + folder.string() + ", in which PoCL keeps compiled kernels, " + why +
                         ". Free space there, or set the environment variable CHAINMAIL_CACHE_DIR to another folder, "
                         "and start again.";
}

void requirePoclCache()
{
  const std::string problem = problemOfPoclCache();
  if (!problem.empty())
  {
    throw DeviceError(problem);
  }
}

#endif

}
