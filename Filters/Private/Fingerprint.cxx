// SPDX-License-Identifier: BSD-3-Clause
#include "Fingerprint.h"

#include "Arrays.h"
#include "Threads.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace vtkChainMail
{

namespace
{

/// Multiplication spreads every bit upwards, and the shifts spread them downwards (the finaliser of SplitMix64: Steele,
/// Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
Fingerprint Mix(Fingerprint h)
{
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return h ^ (h >> 31);
}

Fingerprint Word(const char* at)
{
  Fingerprint word;
  std::memcpy(&word, at, sizeof(word));
  return word;
}

}

Fingerprint FingerprintOfPart(const char* data, std::size_t bytes)
{
  // Four independent lanes hide the latency of the multiplications.
  constexpr Fingerprint odd = 0x9e3779b97f4a7c15u;
  Fingerprint lanes[4] = { 1, 2, 3, 4 };
  std::size_t n = 0;
  for (; n + 32 <= bytes; n += 32)
  {
    for (int lane = 0; lane < 4; ++lane)
    {
      const Fingerprint h = (lanes[lane] ^ Word(data + n + 8 * lane)) * odd;
      lanes[lane] = h ^ (h >> 29);
    }
  }
  char rest[32] = {};
  std::memcpy(rest, data + n, bytes - n);
  Fingerprint h = bytes;
  for (int lane = 0; lane < 4; ++lane)
  {
    h = Mix(h ^ Mix(lanes[lane] ^ Mix(Word(rest + 8 * lane))));
  }
  return h;
}

Fingerprint FingerprintOf(const void* data, std::size_t bytes, Fingerprint before)
{
  // The parts do not depend on the number of threads, so neither does the result.
  constexpr std::size_t part = std::size_t(1) << 20;
  std::vector<Fingerprint> parts((bytes + part - 1) / part);
  chainmail::inParallel(parts.size(),
    [&](std::size_t n)
    {
      const std::size_t from = n * part;
      parts[n] = FingerprintOfPart(static_cast<const char*>(data) + from, std::min(part, bytes - from));
    });
  Fingerprint h = Mix(before ^ bytes);
  for (const Fingerprint one : parts)
  {
    h = Mix(h ^ one);
  }
  return h;
}

Fingerprint FingerprintOf(vtkDataArray* array)
{
  if (!array)
  {
    return 0;
  }
  const int kind[] = { array->GetDataType(), array->GetNumberOfComponents() };
  const Fingerprint before = FingerprintOf(kind, sizeof(kind));
  const auto values = static_cast<std::size_t>(array->GetNumberOfValues());
  if (array->GetDataType() == VTK_BIT)
  {
    return FingerprintOf(array->GetVoidPointer(0), (values + 7) / 8, Mix(before ^ values));
  }
  const vtkSmartPointer<vtkDataArray> interleaved = Interleaved(array);
  return FingerprintOf(interleaved->GetVoidPointer(0), values * array->GetDataTypeSize(), before);
}

}
