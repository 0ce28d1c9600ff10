#include "../../TemporaryFolder.h"
#include "ChildProcess.h"
#include "Device.h"
#include "Environment.h"
#include "ProgramCache.h"
#include "Scene.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

namespace
{

namespace fs = std::filesystem;
using namespace chainmail;

/// All files in a folder, except PoCL's (see TestPoclCache.cpp).
std::vector<fs::path> filesOf(const fs::path& folder)
{
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
  {
    if (entry.path().stem() != "pocl")
    {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string contentOf(const fs::path& path)
{
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

void write(const fs::path& path, const std::string& content)
{
  std::ofstream(path, std::ios::binary) << content;
}

void keep(const ProgramCache& cache, const std::string& key, const std::string& program)
{
  cache.keep(key, [&] { return program; });
}

// --- Bytes under a key

TEST(ProgramCache, GivesBackWhatWasKeptUnderAKeyAndNothingElse)
{
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path / "made" / "when needed";
  const std::string program("with\0zeros\n\xff", 12);
  EXPECT_EQ(ProgramCache(folder).find("key"), "");
  EXPECT_FALSE(fs::exists(folder)) << "looking made the folder";
  keep(ProgramCache(folder), "key", program);
  keep(ProgramCache(folder), "key of another", "other");
  EXPECT_EQ(ProgramCache(folder).find("key"), program);
  EXPECT_EQ(ProgramCache(folder).find("key of another"), "other");
  EXPECT_EQ(ProgramCache(folder).find("ke"), "");
  EXPECT_EQ(ProgramCache(folder).find(""), "");
  EXPECT_EQ(filesOf(folder).size(), 2u);
#ifndef _WIN32 // on Windows folders of a user are private by default
  EXPECT_EQ(fs::status(folder).permissions(), fs::perms::owner_all);
#endif

  keep(ProgramCache(folder), "key", ""); // a driver without binaries
  keep(ProgramCache(folder), "nothing", "");
  EXPECT_EQ(ProgramCache(folder).find("key"), program);
  EXPECT_EQ(filesOf(folder).size(), 2u) << "an unfinished file stays";
}

TEST(ProgramCache, WithoutAFolderNothingIsKeptOrAskedFor)
{
  const TemporaryFolder temporary;
  write(temporary.path / "file", "");
  // No folder, and a folder that cannot be created, not even by root.
  for (const fs::path& folder : { fs::path(), temporary.path / "file" / "folder", temporary.path / "file" })
  {
    const ProgramCache cache(folder);
    cache.keep("key",
      []() -> std::string
      {
        ADD_FAILURE() << "the program was asked for";
        return "program";
      });
    EXPECT_EQ(cache.find("key"), "") << folder;
  }
  EXPECT_EQ(filesOf(temporary.path).size(), 1u);
}

TEST(ProgramCache, ADamagedFileIsNotUsedAndReplaced)
{
  const TemporaryFolder temporary;
  const ProgramCache cache(temporary.path);
  const std::string key(100, 'k');
  const std::string program(1000, 'p');
  keep(cache, key, program);
  const fs::path file = filesOf(temporary.path).front();
  const std::string whole = contentOf(file);

  std::vector<std::string> damaged{ "", whole + "x", std::string(whole.size(), '\0'), whole + whole };
  for (std::size_t length = 1; length < whole.size(); length += 7)
  {
    damaged.push_back(whole.substr(0, length));
  }
  for (std::size_t place = 0; place < whole.size(); place += 3)
  {
    damaged.push_back(whole);
    damaged.back()[place] ^= 0x10;
  }
  for (const std::string& content : damaged)
  {
    write(file, content);
    EXPECT_EQ(cache.find(key), "");
  }
  keep(cache, key, program);
  EXPECT_EQ(contentOf(file), whole);
  EXPECT_EQ(cache.find(key), program);

  // Another key with the same hash, or a renamed file.
  keep(cache, std::string(100, 'K'), "foreign");
  for (const fs::path& other : filesOf(temporary.path))
  {
    if (other != file)
    {
      fs::rename(other, file);
    }
  }
  EXPECT_EQ(cache.find(key), "");
  keep(cache, key, program);
  EXPECT_EQ(cache.find(key), program);
}

TEST(ProgramCache, WhereAFileCannotBeReplacedNothingIsLeft)
{
  const TemporaryFolder temporary;
  const ProgramCache cache(temporary.path);
  keep(cache, "key", "program");
  const fs::path file = filesOf(temporary.path).front();
  fs::remove(file);
  fs::create_directories(file / "in the way");
  EXPECT_EQ(cache.find("key"), "");
  keep(cache, "key", "program");
  EXPECT_EQ(cache.find("key"), "");
  EXPECT_EQ(filesOf(temporary.path).size(), 1u);
}

TEST(ProgramCache, WhatWasWrittenFirstMakesRoom)
{
  const TemporaryFolder temporary;
  const std::string program(1000, 'p');
  write(temporary.path / "of the user", std::string(5000, 'u'));
  const ProgramCache cache(temporary.path, 3500);
  for (const char* key : { "0", "1", "2" })
  {
    keep(cache, key, program);
    for (const fs::path& file : filesOf(temporary.path))
    {
      fs::last_write_time(
        file, fs::last_write_time(file) - std::chrono::seconds(1)); // times of files have a coarse resolution
    }
  }
  EXPECT_EQ(cache.find("0"), program);
  keep(cache, "3", program);
  EXPECT_EQ(cache.find("0"), "");
  for (const char* key : { "1", "2", "3" })
  {
    EXPECT_EQ(cache.find(key), program) << key;
  }
  EXPECT_TRUE(fs::exists(temporary.path / "of the user"));
}

TEST(ProgramCache, ManyMayUseAFolderAtOnce)
{
  const TemporaryFolder temporary;
  const auto programOf = [](int key, int writer) { return std::string(20000 + key, static_cast<char>('a' + writer)); };
  std::vector<std::thread> threads;
  for (int writer = 0; writer < 8; ++writer)
  {
    threads.emplace_back(
      [&, writer]
      {
        const ProgramCache cache(temporary.path);
        for (int n = 0; n < 40; ++n)
        {
          const std::string key = std::to_string(n % 4);
          const std::string found = cache.find(key);
          EXPECT_TRUE(found.empty() || found == programOf(n % 4, found[0] - 'a')) << "half of one, or two in one";
          keep(cache, key, programOf(n % 4, writer));
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(filesOf(temporary.path).size(), 4u);
}

TEST(ProgramCache, IsWhereTheUserOrTheSystemHasCaches)
{
#ifdef _WIN32
  const Variable own("CHAINMAIL_CACHE_DIR", nullptr);
  const Variable caches("LOCALAPPDATA", "C:\\caches");
  EXPECT_EQ(ProgramCache::userFolder(), fs::path("C:\\caches\\chainmail"));
#else
  const auto folder = [](const char* own, const char* xdg, const char* home)
  {
    const Variable first("CHAINMAIL_CACHE_DIR", own);
    const Variable second("XDG_CACHE_HOME", xdg);
    const Variable third("HOME", home);
    return ProgramCache::userFolder().string();
  };
  EXPECT_EQ(folder("/own", "/xdg", "/home/user"), "/own");
  EXPECT_EQ(folder("", "/xdg", "/home/user"), "");
#ifndef __APPLE__
  EXPECT_EQ(folder(nullptr, "/xdg", "/home/user"), "/xdg/chainmail");
  EXPECT_EQ(folder(nullptr, "relative", "/home/user"), "/home/user/.cache/chainmail");
  EXPECT_EQ(folder(nullptr, "", "/home/user"), "/home/user/.cache/chainmail");
  EXPECT_EQ(folder(nullptr, nullptr, "/home/user"), "/home/user/.cache/chainmail");
#endif
  EXPECT_EQ(folder(nullptr, nullptr, ""), "");
  EXPECT_EQ(folder(nullptr, nullptr, nullptr), "");
#endif
}

// --- Programs of a device

int deform(const Index3& brick)
{
  Scene scene({ 12, 12, 12 }, 0.2f);
  scene.anchors.faces[0] = true;
  Simulation simulation = simulate(scene, brick);
  Probe probe;
  probe.position = scene.place(8, 6, 6);
  probe.displacement = { 1.5, 0.5, 0.0 };
  probe.radius = 2.0;
  simulation.pull({ probe });
  simulation.relax(5, 0.0);
  std::vector<float> displacement(3 * scene.grid.voxels());
  simulation.displacements(displacement.data());
  std::cout << std::hexfloat;
  for (const float value : displacement)
  {
    std::cout << value << ' ';
  }
  return 0;
}
const ChildPart deformPart("deform", [] { return deform({ 0, 0, 0 }); });
const ChildPart deformSmallBricksPart("deformSmallBricks", [] { return deform({ 4, 4, 4 }); });

/// The result of a new process whose cache is `folder`.
std::string computed(const fs::path& folder, const std::string& part = "deform")
{
  const ChildResult child = runChild({ { "CHAINMAIL_CACHE_DIR", folder.string() } }, part);
  EXPECT_EQ(child.status, 0) << child.output;
  return child.output.substr(child.output.rfind('\n') + 1); // Mesa's driver may print warnings before
}

using Written = std::map<fs::path, std::tuple<fs::file_time_type, std::string>>;
Written toString(const fs::path& folder)
{
  Written files;
  for (const fs::path& file : filesOf(folder))
  {
    files[file] = { fs::last_write_time(file), contentOf(file) };
  }
  return files;
}

class ProgramCacheOfDevice : public testing::Test
{
protected:
  void SetUp() override
  {
    if (chooseDevice(testDevice()).platform == "Host C++")
    {
      GTEST_SKIP() << "kernels as C++ have no binaries";
    }
    this->expected_ = computed("");
  }

  TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path;
  std::string expected_; ///< without a cache
};

// A program that is not read from the cache is compiled and stored again.
TEST_F(ProgramCacheOfDevice, ASecondStartFindsAllAndWritesNothing)
{
  EXPECT_EQ(computed(this->folder_), this->expected_);
  const Written first = toString(this->folder_);
  EXPECT_GT(first.size(), 1u);
  EXPECT_EQ(computed(this->folder_), this->expected_);
  EXPECT_EQ(toString(this->folder_), first);
}

TEST_F(ProgramCacheOfDevice, OtherOptionsAreOtherPrograms)
{
  const std::string other = computed("", "deformSmallBricks");
  computed(this->folder_);
  const Written first = toString(this->folder_);
  EXPECT_EQ(computed(this->folder_, "deformSmallBricks"), other);
  const Written both = toString(this->folder_);
  EXPECT_GT(both.size(), first.size());
  EXPECT_TRUE(std::includes(both.begin(), both.end(), first.begin(), first.end())) << "files were replaced";
}

// Damage that the cache detects, and damage that only the driver can reject.
TEST_F(ProgramCacheOfDevice, DamagedFilesAreReplaced)
{
  computed(this->folder_);
  const std::size_t count = filesOf(this->folder_).size();
  const auto truncate = [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) / 2); };
  const auto empty = [](const fs::path& file) { fs::resize_file(file, 0); };
  const auto spoil = [this](const fs::path& file)
  {
    const std::string content = contentOf(file);
    std::uint64_t length = 0;
    content.copy(reinterpret_cast<char*>(&length), sizeof length, 24); // the field of the key's length in the header
    keep(ProgramCache(this->folder_), content.substr(32, length), "no program of any driver");
  };
  std::vector<std::function<void(const fs::path&)>> damages{ truncate, empty };
  if (chooseDevice(testDevice()).platform != "rusticl") // rusticl ends the process if a program is of another driver
  {
    damages.emplace_back(spoil);
  }
  for (const auto& damage : damages)
  {
    for (const fs::path& file : filesOf(this->folder_))
    {
      damage(file);
    }
    const Written damaged = toString(this->folder_);
    ASSERT_EQ(damaged.size(), count);
    EXPECT_EQ(computed(this->folder_), this->expected_);
    const Written replaced = toString(this->folder_);
    EXPECT_EQ(replaced.size(), count);
    for (const auto& [file, content] : damaged)
    {
      EXPECT_NE(replaced.at(file), content) << file;
    }
    EXPECT_EQ(computed(this->folder_), this->expected_);
    EXPECT_EQ(toString(this->folder_), replaced);
  }
}

TEST_F(ProgramCacheOfDevice, WorksWhereNothingCanBeWritten)
{
  write(this->folder_ / "file", "");
  EXPECT_EQ(computed(this->folder_ / "file" / "folder"), this->expected_);
  EXPECT_EQ(filesOf(this->folder_).size(), 1u);
}

TEST_F(ProgramCacheOfDevice, ProcessesMayStartAtOnce)
{
  std::vector<std::future<std::string>> processes;
  for (int n = 0; n < 3; ++n)
  {
    processes.push_back(std::async(std::launch::async, [this] { return computed(this->folder_); }));
  }
  for (std::future<std::string>& process : processes)
  {
    EXPECT_EQ(process.get(), this->expected_);
  }
  const Written first = toString(this->folder_);
  EXPECT_EQ(computed(this->folder_), this->expected_);
  EXPECT_EQ(toString(this->folder_), first) << "something is missing, or an unfinished file stays";
}

}
