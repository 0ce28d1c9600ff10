// PoCL's cache folder: after damage by users, and where it cannot be created.
#ifndef _WIN32

#include "../../TemporaryFolder.h"
#include "ChildProcess.h"
#include "Device.h"
#include "Environment.h"
#include "Notices.h"
#include "PoclCache.h"
#include "Scene.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <sys/mount.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;
using namespace chainmail;

constexpr int skipped = 125;

/// Pulls at a small block and prints the result, then the notices.
int deform(const Index3& brick)
{
  try
  {
    Scene scene({ 12, 12, 12 }, 0.2f);
    scene.anchors.faces[0] = true;
    Simulation simulation = simulate(scene, brick);
    Probe probe;
    probe.position = scene.place(8, 6, 6);
    probe.displacement = { 1.5, 0.5, 0.0 };
    probe.radius = 2.0;
    simulation.pull({ probe });
    std::cout << "energy " << std::hexfloat << simulation.measure().energy << '\n';
  }
  catch (const Error& error)
  {
    std::cout << "error: " << error.what() << '\n';
  }
  for (const std::string& notice : takeNotices())
  {
    std::cout << "notice: " << notice << '\n';
  }
  return 0;
}

/// Continues as a user who is not root: permissions do not restrict root.
bool becomeUser()
{
  constexpr unsigned nobody = 65534;
  return getuid() != 0 || (setgid(nobody) == 0 && setuid(nobody) == 0);
}

const ChildPart deformPart("poclDeform", [] { return deform({}); });
const ChildPart otherPart("poclDeformOther", [] { return deform({ 4, 4, 4 }); });
const ChildPart userPart("poclDeformAsUser", [] { return becomeUser() ? deform({}) : skipped; });
const ChildPart userOtherPart("poclDeformOtherAsUser", [] { return becomeUser() ? deform({ 4, 4, 4 }) : skipped; });
const ChildPart removedPart("poclRemoved",
  []
  {
    deform({});
    fs::remove_all(std::getenv("CHAINMAIL_CACHE_DIR"));
    return deform({ 4, 4, 4 });
  });
/// Removes unfinished libraries of PoCL again and again.
const ChildPart disturbedPart("poclDisturbed",
  []
  {
    std::atomic<bool> done{ false };
    std::thread cleaner(
      [&]
      {
        while (!done)
        {
          std::error_code gone;
          auto entry = fs::recursive_directory_iterator(std::getenv("CHAINMAIL_CACHE_DIR"), gone);
          for (; !gone && entry != fs::recursive_directory_iterator(); entry.increment(gone))
          {
            const std::string name = entry->path().filename().string();
            const bool isUnfinished = name.compare(0, 8, "tempfile") == 0 || name.compare(0, 8, "parallel") == 0;
            if (isUnfinished && entry->path().extension() == ".so")
            {
              std::error_code failed;
              fs::remove(entry->path(), failed);
            }
          }
        }
      });
    const int status = deform({ 4, 4, 4 });
    done = true;
    cleaner.join();
    return status;
  });
const ChildPart fullPart("poclFullDisk",
  []
  {
    const std::string folder = std::getenv("CHAINMAIL_CACHE_DIR");
    if (mount("none", folder.c_str(), "tmpfs", 0, "size=12m,mode=700") != 0)
    {
      return skipped;
    }
    deform({});
    std::ofstream(folder + "/filler") << std::string(std::size_t(16) << 20, 'x');
    const int status = deform({ 4, 4, 4 });
    umount2(folder.c_str(), MNT_DETACH);
    return status;
  });

std::string energyIn(const std::string& output)
{
  const std::size_t at = output.find("energy ");
  return at == std::string::npos ? output : output.substr(at, output.find('\n', at) - at);
}

std::vector<fs::path> filesIn(const fs::path& folder, const std::string& ending)
{
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
  {
    if (entry.path().extension() == ending && entry.is_regular_file())
    {
      files.push_back(entry.path());
    }
  }
  return files;
}

std::string contentOf(const fs::path& path)
{
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

void permit(const fs::path& folder, fs::perms forFolders, fs::perms forFiles)
{
  std::vector<fs::path> all{ folder };
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
  {
    all.push_back(entry.path());
  }
  for (const fs::path& path : all)
  {
    fs::permissions(path, fs::is_directory(path) ? forFolders : forFiles);
  }
}

class PoclCacheTest : public testing::Test
{
protected:
  void SetUp() override
  {
    if (chooseDevice(testDevice()).platform != "Portable Computing Language")
    {
      GTEST_SKIP() << "this device is none of PoCL";
    }
    fs::create_directory(this->cache);
    fs::permissions(this->temporary.path, fs::perms(0755)); // for the user that is not root
    fs::permissions(this->cache, fs::perms::owner_all);
    this->environment = { { "CHAINMAIL_CACHE_DIR", this->cache.string() }, { "POCL_CACHE_DIR", "" },
      { "XDG_CACHE_HOME", "" }, { "HOME", this->temporary.path.string() } };
    this->expected = energyIn(this->run("poclDeform").output);
    EXPECT_TRUE(contains(this->expected, "energy")) << this->expected;
  }
  /// Removes folders of the test, if needed as the user who is not root.
  void TearDown() override
  {
    if (fs::exists(this->cache))
    {
      permit(this->cache, fs::perms(0700), fs::perms(0600));
    }
  }

  ChildResult run(const std::string& part) const
  {
    ChildResult child = runChild(this->environment, part);
    EXPECT_TRUE(child.status == 0 || child.status == skipped) << part << ": " << child.status << '\n' << child.output;
    return child;
  }

  TemporaryFolder temporary;
  const fs::path cache = this->temporary.path / "cache";
  std::map<std::string, std::string> environment;
  std::string expected;
};

TEST_F(PoclCacheTest, IsWithOtherProgramsAndNothingIsCompiledTwice)
{
  EXPECT_FALSE(filesIn(this->cache / "pocl", ".so").empty());
  EXPECT_TRUE(fs::exists(this->cache / "pocl.checksums"));
  EXPECT_FALSE(fs::exists(this->temporary.path / ".cache")) << "PoCL has a folder of its own";
  std::map<fs::path, fs::file_time_type> before;
  for (const fs::path& file : filesIn(this->cache / "pocl", ".so"))
  {
    before[file] = fs::last_write_time(file);
  }
  EXPECT_EQ(energyIn(this->run("poclDeform").output), this->expected);
  EXPECT_EQ(filesIn(this->cache / "pocl", ".so").size(), before.size());
  for (const auto& [file, time] : before)
  {
    EXPECT_EQ(fs::last_write_time(file), time);
  }
}

// PoCL ends a process that reads bitcode while another process writes to the folder.
TEST_F(PoclCacheTest, ProcessesTranslateInFoldersOfTheirOwn)
{
  const std::vector<fs::path> kept = filesIn(this->cache, ".clprogram");
  const std::size_t programs = filesIn(this->cache / "pocl", ".bc").size();
  ASSERT_FALSE(kept.empty());
  std::for_each(kept.begin(), kept.end(), [](const fs::path& file) { fs::remove(file); });
  EXPECT_EQ(energyIn(this->run("poclDeform").output), this->expected);
  EXPECT_EQ(filesIn(this->cache, ".clprogram").size(), kept.size());
  EXPECT_GE(filesIn(this->cache / "pocl", ".bc").size(), programs + kept.size());
}

// The system ends a process that runs a truncated library, and PoCL ends one that reads a truncated program.
TEST_F(PoclCacheTest, DamagedFilesAreReplaced)
{
  const auto halve = [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) / 2); };
  const auto empty = [](const fs::path& file) { fs::resize_file(file, 0); };
  const auto flip = [](const fs::path& file)
  {
    std::string content = contentOf(file);
    for (std::size_t n = 0; n < content.size(); n += 8)
    {
      content[n] ^= 0x10;
    }
    std::ofstream(file, std::ios::binary) << content;
  };
  struct Case
  {
    const char* ending;
    std::function<void(const fs::path&)> damage;
    bool isListed;
  };
  for (const Case& one : { Case{ ".so", halve, true }, Case{ ".so", halve, false }, Case{ ".so", flip, true },
         Case{ ".bc", halve, false }, Case{ ".bc", flip, true }, Case{ ".bc", empty, true } })
  {
    const std::vector<fs::path> files = filesIn(this->cache / "pocl", one.ending);
    ASSERT_FALSE(files.empty());
    std::for_each(files.begin(), files.end(), one.damage);
    if (!one.isListed)
    {
      fs::remove(this->cache / "pocl.checksums"); // a process that is killed leaves the folder in this state
    }
    EXPECT_EQ(energyIn(this->run("poclDeform").output), this->expected) << one.ending << one.isListed;
  }
}

// Another process may have files there at any time.
TEST_F(PoclCacheTest, WholeFilesAreLeftAlone)
{
  const fs::path folder = this->cache / "pocl";
  const std::vector<fs::path> files = filesIn(folder, ".so");
  fs::create_directories(folder / "XX" / "kernel" / "1-1-1");
  std::ofstream(folder / "XX" / "tempfile_abc.so") << "half of a";
  std::ofstream(folder / "XX" / "kernel" / "1-1-1" / "parallelAbC12x.so") << "half of another, as of PoCL 7";
  fs::remove(this->cache / "pocl.checksums");
  for (int n = 0; n < 2; ++n)
  {
    checkPoclCache(folder);
    EXPECT_EQ(filesIn(folder, ".so").size(), files.size() + 2);
  }
  fs::last_write_time(files.front(), fs::last_write_time(files.front()) + std::chrono::seconds(5));
  checkPoclCache(folder);
  EXPECT_TRUE(fs::exists(files.front())) << "only the time is another";
}

TEST_F(PoclCacheTest, WhereNothingCanBeWrittenItIsPrivateAndGoes)
{
  for (const char* home : { "/proc/none", "" })
  {
    for (const bool named : { false, true })
    {
      const fs::path own = this->temporary.path / "tmp";
      fs::create_directory(own);
      fs::permissions(own, fs::perms(01777), fs::perm_options::replace);
      this->environment = { { "HOME", home }, { "XDG_CACHE_HOME", "" }, { "POCL_CACHE_DIR", named ? "/proc/none" : "" },
        { "CHAINMAIL_CACHE_DIR", named ? "/proc/none/cache" : "" }, { "TMPDIR", own.string() } };
      const ChildResult child = this->run("poclDeformAsUser");
      if (child.status == skipped)
      {
        GTEST_SKIP() << "this process may not become another user's";
      }
      EXPECT_EQ(energyIn(child.output), this->expected) << home << child.output;
      EXPECT_TRUE(fs::is_empty(own)) << "the private folder stays";
    }
  }
}

// A read-only folder, as in a container.
TEST_F(PoclCacheTest, WhatCanOnlyBeReadIsUsedByAnyScene)
{
  permit(this->cache, fs::perms(0555), fs::perms(0444));
  for (const char* part : { "poclDeformAsUser", "poclDeformOtherAsUser" })
  {
    const ChildResult child = this->run(part);
    if (child.status == skipped || (getuid() != 0 && access(this->cache.c_str(), W_OK) == 0))
    {
      GTEST_SKIP() << "this process may not become another user's";
    }
    EXPECT_TRUE(contains(child.output, "energy")) << child.output;
    EXPECT_FALSE(contains(child.output, "notice")) << child.output;
  }
}

TEST_F(PoclCacheTest, WhatOthersMayWriteToIsNotUsed)
{
  const std::size_t before = filesIn(this->cache, ".clprogram").size();
  ASSERT_GT(before, 0u);
  for (const fs::perms perms : { fs::perms(0720), fs::perms(01777) })
  {
    fs::permissions(this->cache, perms);
    const ChildResult child = this->run("poclDeformOther");
    EXPECT_EQ(filesIn(this->cache, ".clprogram").size(), before) << "something was kept";
    EXPECT_TRUE(contains(child.output, "energy")) << child.output;
    const std::size_t notice = child.output.find("others may write");
    ASSERT_NE(notice, std::string::npos) << child.output;
    EXPECT_EQ(child.output.find("others may write", notice + 1), std::string::npos)
      << "more than one: " << child.output;
    EXPECT_TRUE(contains(child.output, this->cache.string())) << child.output;
  }
  if (getuid() == 0) // a folder of root belongs to the administrator
  {
    fs::permissions(this->cache, fs::perms(0755));
    ASSERT_EQ(chown(this->cache.c_str(), 65533, 65533), 0);
    const ChildResult child = this->run("poclDeform");
    EXPECT_TRUE(contains(child.output, "belongs to another user")) << child.output;
    EXPECT_EQ(energyIn(child.output), this->expected);
  }
}

TEST_F(PoclCacheTest, AFolderThatIsRemovedUnderWayIsMadeAgain)
{
  const ChildResult child = this->run("poclRemoved");
  EXPECT_FALSE(contains(child.output, "error")) << child.output;
  EXPECT_NE(child.output.find("energy"), child.output.rfind("energy")) << child.output;
}

// PoCL reports that it could not compile a kernel and continues without it, or ends the process.
TEST_F(PoclCacheTest, AKernelThatCannotBeCompiledIsAnError)
{
  const std::string right = energyIn(this->run("poclDeformOther").output);
  for (int n = 0; n < 3; ++n)
  {
    fs::remove_all(this->cache);
    fs::create_directory(this->cache);
    const ChildResult child = runChild(this->environment, "poclDisturbed");
    EXPECT_TRUE(child.status != 0 || contains(child.output, "error: ") || energyIn(child.output) == right)
      << child.output;
  }
}

TEST_F(PoclCacheTest, AFullDiskIsTheCauseThatIsGiven)
{
  fs::remove_all(this->cache);
  fs::create_directory(this->cache);
  const ChildResult child = this->run("poclFullDisk");
  if (child.status == skipped)
  {
    GTEST_SKIP() << "this process may not mount anything";
  }
  EXPECT_EQ(energyIn(child.output), this->expected) << child.output;
  EXPECT_TRUE(contains(child.output, "error: The folder " + this->cache.string())) << child.output;
  EXPECT_TRUE(contains(child.output, "full")) << child.output;
  EXPECT_TRUE(contains(child.output, "CHAINMAIL_CACHE_DIR")) << child.output;
}

}

#endif
