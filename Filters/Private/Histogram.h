// SPDX-License-Identifier: BSD-3-Clause
// Counts numbers in bins that depend on the number only, so histograms of parts add up to that of the whole.

#ifndef Histogram_h
#define Histogram_h

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace vtkChainMail
{

/// The bins follow the floating-point format: sign, exponent, and the first 15 binary digits after the leading one.
/// Whole numbers up to 65,536 have a bin each. Any other number shares its bin with numbers that differ by less than
/// one part in 32,768. Magnitudes below 2^-200 count as 0.
class Histogram
{
public:
  struct Bin
  {
    double Value; ///< the number of the bin that is nearest to 0
    std::uint64_t Count;
  };

  void Add(double finite, std::uint32_t count = 1)
  {
    const int bin = BinOf(finite);
    const bool isNegative = bin < 0;
    const int place = isNegative ? -bin : bin;
    auto& page = this->Pages[isNegative][static_cast<std::size_t>(place >> DIGITS)];
    if (!page)
    {
      page = std::make_unique<Page>();
    }
    (*page)[static_cast<std::size_t>(place & (PAGE - 1))] += count;
  }

  void Add(const Histogram& other);

  /// The bins that are not empty, in ascending order.
  std::vector<Bin> GetBins() const;

private:
  static constexpr int DIGITS = 15;
  static constexpr int PAGE = 1 << DIGITS; // one exponent
  static constexpr int EXPONENT = 200;     // largest magnitude of an exponent

  using Page = std::array<std::uint32_t, PAGE>;

  /// The signed bin: ascending with the number, 0 for 0, and antisymmetric.
  static int BinOf(double number);
  static double ValueOf(int bin);

  // By sign, then by exponent. Pages without counts are null.
  std::array<std::array<std::unique_ptr<Page>, 2 * EXPONENT + 2>, 2> Pages;
};

}

#endif
