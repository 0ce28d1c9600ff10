// Scans from the folder CHAINMAIL_VOLUMES.

#pragma once

#include "Model.h"

#include <zlib.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

struct Scan
{
  chainmail::Grid grid;
  std::vector<float> scalar;
};

inline std::string folderOfScans()
{
  const char* folder = std::getenv("CHAINMAIL_VOLUMES");
  return folder ? folder : CHAINMAIL_TEST_VOLUMES;
}

/// A compressed MetaImage with values of 8 or 16 bits. Without voxels if there is no such file.
inline Scan readScan(const std::string& name)
{
  Scan scan;
  std::ifstream header(folderOfScans() + "/" + name + ".mhd");
  bool wide = false;
  std::string key;
  std::string equals;
  while (header >> key >> equals)
  {
    if (key == "DimSize")
    {
      header >> scan.grid.size[0] >> scan.grid.size[1] >> scan.grid.size[2];
    }
    else if (key == "ElementSpacing")
    {
      header >> scan.grid.spacing[0] >> scan.grid.spacing[1] >> scan.grid.spacing[2];
    }
    else if (key == "ElementType")
    {
      std::string type;
      header >> type;
      wide = type == "MET_SHORT";
    }
    header.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  std::ifstream file(folderOfScans() + "/" + name + ".zraw", std::ios::binary);
  const std::vector<char> packed((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::uint8_t> bytes(scan.grid.voxels() * (wide ? 2 : 1));
  uLongf length = bytes.size();
  if (packed.empty() ||
      uncompress(bytes.data(), &length, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      length != bytes.size())
  {
    return {};
  }
  for (std::size_t v = 0; v < scan.grid.voxels(); ++v)
  {
    scan.scalar.push_back(wide ? static_cast<std::int16_t>(bytes[2 * v] | bytes[2 * v + 1] << 8) : bytes[v]);
  }
  return scan;
}
