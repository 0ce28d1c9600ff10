#include "ProgramCache.h"

#include "CacheFolder.h"
#include "Hash.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <random>
#include <sstream>
#include <system_error>
#include <vector>

namespace chainmail
{

namespace fs = std::filesystem;

namespace
{

/// The extension of the cache's files. No others are ever deleted, because the user may name a folder that holds other
/// things.
constexpr const char* extension = ".clprogram";

std::string hexadecimal(std::uint64_t number)
{
  std::ostringstream text;
  text << std::hex << std::setfill('0') << std::setw(16) << number;
  return text.str();
}

/// The head of a file: its format, the hash of everything after the head, and the length of the key. The key follows
/// the head.
struct Head
{
  char format[16] = "ChainMail CL 1\n";
  std::uint64_t hash = 0;
  std::uint64_t keyLength = 0;
};

fs::path variable(const char* name)
{
  const char* value = std::getenv(name);
  return value ? value : "";
}

}

fs::path ProgramCache::userFolder()
{
  if (std::getenv("CHAINMAIL_CACHE_DIR"))
  {
    return variable("CHAINMAIL_CACHE_DIR");
  }
  return systemFolder("chainmail");
}

fs::path ProgramCache::systemFolder(const char* name)
{
#ifdef _WIN32
  const fs::path caches = variable("LOCALAPPDATA");
#else
#ifdef __APPLE__
  const fs::path inHome = "Library/Caches";
  fs::path caches;
#else
  const fs::path inHome = ".cache";
  fs::path caches = variable("XDG_CACHE_HOME"); // a relative path counts as none
#endif
  if (!caches.is_absolute() && !variable("HOME").empty())
  {
    caches = variable("HOME") / inHome;
  }
#endif
  return caches.is_absolute() ? caches / name : fs::path();
}

fs::path ProgramCache::fileOf(const std::string& key) const
{
  return this->folder_ / (hexadecimal(hashOf(key)) + extension);
}

std::string ProgramCache::find(const std::string& key) const noexcept
{
  try
  {
    return this->read(key);
  }
  catch (const std::exception&)
  {
    return {};
  }
}

void ProgramCache::keep(const std::string& key, const std::function<std::string()>& program) const noexcept
{
  try
  {
    if (!this->folder_.empty())
    {
      this->write(key, program);
      this->prune();
    }
  }
  catch (const std::exception&)
  {
  }
}

std::string ProgramCache::read(const std::string& key) const
{
  if (this->folder_.empty() || !isTrusted(this->folder_))
  {
    return {};
  }
  std::ifstream file(this->fileOf(key), std::ios::binary);
  const Head expected;
  Head head;
  if (!file.read(reinterpret_cast<char*>(&head), sizeof head) ||
      std::memcmp(head.format, expected.format, sizeof head.format) != 0 || head.keyLength != key.size())
  {
    return {};
  }
  const std::string content(std::istreambuf_iterator<char>(file), {});
  const bool right = content.compare(0, key.size(), key) == 0 && hashOf(content) == head.hash;
  return right ? content.substr(key.size()) : std::string();
}

void ProgramCache::write(const std::string& key, const std::function<std::string()>& program) const
{
  if (!makeFolder(this->folder_) || !isTrusted(this->folder_))
  {
    return;
  }
  std::random_device random;
  const fs::path unfinished = this->folder_ / (hexadecimal(std::uint64_t(random()) << 32 | random()) + extension);
  std::ofstream file(unfinished, std::ios::binary);
  if (!file)
  {
    return;
  }
  const std::string bytes = program();
  const std::string content = key + bytes;
  Head head;
  head.hash = hashOf(content);
  head.keyLength = key.size();
  file.write(reinterpret_cast<const char*>(&head), sizeof head);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  std::error_code failed;
  if (file && !bytes.empty())
  {
    fs::rename(unfinished, this->fileOf(key), failed);
  }
  if (!file || bytes.empty() || failed)
  {
    fs::remove(unfinished, failed);
  }
}

void ProgramCache::prune() const
{
  struct File
  {
    fs::path path;
    std::uintmax_t bytes;
    fs::file_time_type toString;
  };
  std::vector<File> files;
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(this->folder_))
  {
    std::error_code gone; // set if another process has deleted the file
    const File file{ entry.path(), entry.file_size(gone), entry.last_write_time(gone) };
    if (file.path.extension() == extension && !gone)
    {
      files.push_back(file);
      bytes += file.bytes;
    }
  }
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.toString < b.toString; });
  for (auto file = files.begin(); bytes > this->limit_ && file != files.end(); ++file)
  {
    std::error_code ignored;
    fs::remove(file->path, ignored);
    bytes -= file->bytes;
  }
}

}
