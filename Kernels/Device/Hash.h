#pragma once

#include <cstdint>
#include <string>

namespace chainmail
{

/// The FNV-1a hash by Fowler, Noll and Vo, http://www.isthe.com/chongo/tech/comp/fnv/
inline std::uint64_t hashOf(const std::string& bytes)
{
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const unsigned char c : bytes)
  {
    hash = (hash ^ c) * 0x100000001b3u;
  }
  return hash;
}

}
