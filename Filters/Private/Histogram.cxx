// SPDX-License-Identifier: BSD-3-Clause
#include "Histogram.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vtkChainMail
{

namespace
{

constexpr int significand = 52; // binary digits of a double after the leading one
constexpr std::uint64_t bias = 1023;

}

int Histogram::BinOf(double number)
{
  constexpr std::uint64_t first = (bias - EXPONENT) << DIGITS;
  const double magnitude = std::fabs(number);
  std::uint64_t bits;
  std::memcpy(&bits, &magnitude, sizeof(bits));
  bits >>= significand - DIGITS;
  if (bits < first)
  {
    return 0;
  }
  constexpr std::uint64_t last = ((2 * static_cast<std::uint64_t>(EXPONENT) + 2) << DIGITS) - 1;
  const int bin = static_cast<int>(std::min(bits - first + PAGE, last));
  return number < 0.0 ? -bin : bin;
}

double Histogram::ValueOf(int bin)
{
  if (bin == 0)
  {
    return 0.0;
  }
  const std::uint64_t bits = (static_cast<std::uint64_t>(std::abs(bin) - PAGE) + ((bias - EXPONENT) << DIGITS))
                             << (significand - DIGITS);
  double magnitude;
  std::memcpy(&magnitude, &bits, sizeof(magnitude));
  return bin < 0 ? -magnitude : magnitude;
}

void Histogram::Add(const Histogram& other)
{
  for (std::size_t sign : { 0, 1 })
  {
    for (std::size_t p = 0; p < this->Pages[sign].size(); ++p)
    {
      const auto& from = other.Pages[sign][p];
      auto& to = this->Pages[sign][p];
      if (from && !to)
      {
        to = std::make_unique<Page>(*from);
      }
      else if (from)
      {
        std::transform(from->begin(), from->end(), to->begin(), to->begin(),
          [](std::uint32_t one, std::uint32_t another) { return one + another; });
      }
    }
  }
}

std::vector<Histogram::Bin> Histogram::GetBins() const
{
  std::vector<Bin> bins;
  const auto take = [&](std::size_t sign, std::size_t p, int n)
  {
    const auto& page = this->Pages[sign][p];
    const std::uint32_t count = page ? (*page)[static_cast<std::size_t>(n)] : 0;
    if (count > 0)
    {
      const int bin = (static_cast<int>(p) << DIGITS) + n;
      bins.push_back({ ValueOf(sign == 1 ? -bin : bin), count });
    }
  };
  for (std::size_t p = this->Pages[1].size(); p-- > 0;)
  {
    for (int n = this->Pages[1][p] ? PAGE : 0; n-- > 0;)
    {
      take(1, p, n);
    }
  }
  for (std::size_t p = 0; p < this->Pages[0].size(); ++p)
  {
    for (int n = 0; n < (this->Pages[0][p] ? PAGE : 0); ++n)
    {
      take(0, p, n);
    }
  }
  return bins;
}

}
