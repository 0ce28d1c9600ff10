// SPDX-License-Identifier: BSD-3-Clause
// A new, empty folder, gone at the end with all that is in it, also where a test or a measurement fails.

#ifndef TemporaryFolder_h
#define TemporaryFolder_h

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>

struct TemporaryFolder
{
  std::filesystem::path path;

  TemporaryFolder()
    : path(std::filesystem::temp_directory_path() / ("chainmail-" + std::to_string(std::random_device()())))
  {
    if (!std::filesystem::create_directory(this->path))
    {
      throw std::runtime_error(
        this->path.string() + " could not be made: set TMPDIR to a folder that can be written to");
    }
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->path, ignored);
  }
};

#endif
