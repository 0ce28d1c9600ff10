// SPDX-License-Identifier: BSD-3-Clause
#include "ScanSummary.h"

#include "../vtkChainMailScanStatistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vtkChainMail
{

namespace
{

using Bins = std::vector<Histogram::Bin>;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::uint64_t CountAll(const Bins& bins)
{
  return std::accumulate(
    bins.begin(), bins.end(), std::uint64_t(0), [](std::uint64_t sum, const auto& bin) { return sum + bin.Count; });
}

/// The number of voxels in [low, high].
double Count(const Bins& bins, double low, double high)
{
  std::uint64_t count = 0;
  for (const auto& bin : bins)
  {
    count += bin.Value >= low && bin.Value <= high ? bin.Count : 0;
  }
  return static_cast<double>(count);
}

/// The smallest value v such that at least `rank` + 1 voxels are at most v.
double ValueAt(const Bins& bins, std::uint64_t rank)
{
  std::uint64_t count = 0;
  for (const auto& bin : bins)
  {
    count += bin.Count;
    if (count > rank)
    {
      return bin.Value;
    }
  }
  return bins.empty() ? 0.0 : bins.back().Value;
}

/// The median of the voxels in [low, high], which must not be empty.
double MedianWithin(const Bins& bins, double low, double high)
{
  Bins within;
  std::copy_if(bins.begin(), bins.end(), std::back_inserter(within),
    [&](const auto& bin) { return bin.Value >= low && bin.Value <= high; });
  return ValueAt(within, CountAll(within) / 2);
}

/// The robust minimum and maximum: one voxel in a thousand is left out at each end if it is far from the others.
/// `ends`: the exact minimum and maximum.
std::array<double, 2> RobustRange(const Bins& bins, const std::array<double, 2>& ends)
{
  const std::uint64_t voxels = CountAll(bins);
  const std::uint64_t left = voxels / 1000;
  // Where nearly all voxels are equal, the few others are the content. So at the top one in a thousand of these is left
  // out.
  const auto most = std::max_element(
    bins.begin(), bins.end(), [](const auto& one, const auto& other) { return one.Count < other.Count; });
  const std::uint64_t leftOnTop = most == bins.end() ? 0 : (voxels - most->Count) / 1000;
  std::array<double, 2> range{ { ValueAt(bins, left), ValueAt(bins, voxels - std::min(voxels, 1 + leftOnTop)) } };
  // Voxels that are not far from the others (5 % of the range) are no outliers. A bin only has its number nearest to 0;
  // the exact ends replace it where they are in the same bin.
  const std::array<double, 2> outer{ { bins.front().Value, bins.back().Value } };
  const double near = 0.05 * (range[1] - range[0]);
  for (std::size_t side : { 0, 1 })
  {
    range[side] = std::fabs(outer[side] - range[side]) <= near ? outer[side] : range[side];
    range[side] = std::fabs(ends[side] - range[side]) <= std::fabs(range[side]) / 32768.0 ? ends[side] : range[side];
  }
  return range;
}

struct CTShares
{
  double Air = 0.0; ///< near -1000
  double Soft = 0.0;
  bool HasAir = false;
  bool IsCT = false;
};

CTShares LookForCT(const Bins& bins)
{
  const auto all = static_cast<double>(CountAll(bins));
  if (all == 0.0)
  {
    return {};
  }
  CTShares shares;
  shares.Air = Count(bins, -1100.0, -850.0) / all;
  shares.Soft = Count(bins, -200.0, 200.0) / all;
  const double tissue = Count(bins, -300.0, infinity) / all;
  const double airAndLung = Count(bins, -1100.0, -600.0) / all;
  const double between = Count(bins, -500.0, -250.0) / all;
  const bool fits = Count(bins, -infinity, std::nextafter(-1100.0, -infinity)) < 0.01 * all &&
                    Count(bins, 4096.0, infinity) < 0.01 * all && shares.Soft >= 0.1 * tissue;
  // Ringing decreases with the distance below tissue, whereas air is a peak.
  const bool isPeak = shares.Air >= 2.0 * (airAndLung - shares.Air) && airAndLung >= between;
  shares.HasAir = fits && shares.Soft > 0.0 && airAndLung >= 1e-3 && (isPeak || airAndLung / 500.0 >= between / 250.0);
  const double fat = Count(bins, -140.0, -40.0) / all;
  const bool isSoft = fits && shares.Soft >= 0.8 && fat >= 0.05 && Count(bins, 0.0, 100.0) >= 0.2 * all &&
                      Count(bins, -1100.0, -150.0) <= 0.2 * fat * all &&
                      Count(bins, std::nextafter(150.0, infinity), infinity) > 0.0;
  shares.IsCT = shares.HasAir || isSoft;
  return shares;
}

/// Moves padding from the bins to the summary.
void SetPaddingAside(Bins& bins, ScanSummary& scan)
{
  const auto all = static_cast<double>(CountAll(bins));
  const double few = std::max(8.0, 1e-4 * all); // outliers are fewer than this
  const auto isMarkAbove = [](double v) { return v == 32767.0 || v == 32768.0 || (v >= 61440.0 && v <= 65535.0); };
  Bins above;
  double others = 0.0;
  for (const auto& bin : bins)
  {
    const bool isMark = isMarkAbove(bin.Value) && static_cast<double>(bin.Count) >= few;
    if (isMark)
    {
      above.push_back(bin);
    }
    others += !isMark && bin.Value >= 16384.0 ? static_cast<double>(bin.Count) : 0.0;
  }
  const auto marked = static_cast<double>(CountAll(above));
  if (!above.empty() && above.size() <= 3 && others < few && marked + others < all)
  {
    scan.HighPadding = above.front().Value;
    bins.erase(std::find_if(bins.begin(), bins.end(), [&](const auto& bin) { return bin.Value >= scan.HighPadding; }),
      bins.end());
  }

  constexpr std::array<double, 10> inUse = { { -32768.0, -32767.0, -9999.0, -4096.0, -3072.0, -3071.0, -3024.0, -3000.0,
    -2048.0, -2000.0 } };
  for (int mark = 0; mark < 3; ++mark)
  {
    double below = 0.0;
    auto found = bins.begin();
    while (found != bins.end() && static_cast<double>(found->Count) < few)
    {
      below += static_cast<double>(found->Count);
      ++found;
    }
    if (found == bins.end() || found->Value >= -1200.0 || below >= few || std::next(found) == bins.end())
    {
      break;
    }
    const double value = found->Value;
    const Bins rest(std::next(found), bins.end());
    const bool isAlone = Count(rest, value, value + 200.0) < std::min(few, static_cast<double>(found->Count));
    const bool isInUse = std::find(inUse.begin(), inUse.end(), value) != inUse.end();
    if (!isAlone || !(isInUse || LookForCT(rest).IsCT))
    {
      break;
    }
    scan.LowPadding = value;
    bins = rest;
  }
  scan.PaddingShare = all > 0.0 ? 1.0 - static_cast<double>(CountAll(bins)) / all : 0.0;
}

bool AreLabels(const Bins& bins, const NeighbourPairs& pairs)
{
  const bool hasZero = !bins.empty() && bins.front().Value == 0.0;
  const std::size_t labels = bins.size() - (hasZero ? 1 : 0);
  if (bins.empty() || bins.front().Value < 0.0 || labels < 2 || labels > 4096)
  {
    return false;
  }
  bool areNumbered = bins[hasZero ? 1 : 0].Value <= 16.0; // starting at a small number, or with consecutive numbers
  std::uint64_t divisor = 0;
  for (std::size_t n = 0; n < bins.size(); ++n)
  {
    divisor = std::gcd(divisor, static_cast<std::uint64_t>(bins[n].Value));
    areNumbered = areNumbered || (n > 0 && bins[n - 1].Value > 0.0 && bins[n].Value == bins[n - 1].Value + 1.0);
  }
  const auto unequal = static_cast<double>(pairs.Unequal);
  const bool areFlat = pairs.Equal >= 8 && static_cast<double>(pairs.Equal) >= 1.5 * unequal;
  // A smooth picture of few grey values is flat, too, but passes through the values between two others.
  const bool jump = labels <= 3    ? true
                    : labels <= 16 ? static_cast<double>(pairs.Apart) >= 0.3 * unequal
                                   : static_cast<double>(pairs.FarApart) >= 0.5 * unequal;
  return divisor == 1 && areNumbered && areFlat && jump;
}

/// The median of the largest peak within the darkest tenth of the range; NaN where there is none. A peak has at least
/// `share` of all voxels, and `steep` times as many as an equally wide window behind it.
double FindDarkPeak(const Bins& bins, const std::array<double, 2>& range, double share, double steep)
{
  constexpr int cells = 200;
  constexpr int width = 5; // width of a peak [cells]
  constexpr int reach = cells / 10;
  const double scale = cells / (range[1] - range[0]);
  if (!(range[1] > range[0]) || !std::isfinite(scale))
  {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::array<double, cells + 1> counts{};
  for (const auto& bin : bins)
  {
    const double cell = std::clamp((bin.Value - range[0]) * scale, 0.0, static_cast<double>(cells));
    counts[static_cast<std::size_t>(cell)] += static_cast<double>(bin.Count);
  }
  const auto window = [&](int first)
  { return std::accumulate(counts.begin() + first, counts.begin() + first + width, 0.0); };
  int best = 0;
  for (int first = 1; first + width <= reach; ++first)
  {
    best = window(first) > window(best) ? first : best;
  }
  // Significance test: the peak has to exceed the window behind it by four standard deviations.
  const double peak = window(best);
  const double behind = window(best + 2 * width);
  if (peak < share * static_cast<double>(CountAll(bins)) || peak < steep * behind ||
      peak - behind < 4.0 * std::sqrt(peak + behind))
  {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double low = best == 0 ? -infinity : range[0] + best / scale;
  return MedianWithin(bins, low, range[0] + (best + width) / scale);
}

}

void NeighbourPairs::Add(const NeighbourPairs& other)
{
  this->Equal += other.Equal;
  this->Unequal += other.Unequal;
  this->Apart += other.Apart;
  this->FarApart += other.FarApart;
}

ScanSummary Summarize(
  const Histogram& voxels, const std::array<double, 2>& ends, const NeighbourPairs& pairs, bool isInteger)
{
  ScanSummary scan;
  Bins bins = voxels.GetBins();
  if (bins.empty())
  {
    return scan;
  }
  SetPaddingAside(bins, scan);
  const auto all = static_cast<double>(CountAll(bins));
  const std::array<double, 2> range = RobustRange(bins, ends);
  scan.Values = static_cast<double>(bins.size());
  scan.Low = range[0];
  scan.High = range[1];
  if (isInteger && AreLabels(bins, pairs))
  {
    scan.Kind = vtkChainMailScanStatistics::KIND_LABELS;
    scan.High = bins.back().Value;
    scan.AirShare = Count(bins, 0.0, 0.0) / all;
    return scan;
  }
  const CTShares shares = LookForCT(bins);
  if (shares.IsCT)
  {
    scan.Kind = vtkChainMailScanStatistics::KIND_CT;
    scan.HasAir = shares.HasAir;
    scan.AirShare = shares.Air;
    scan.SoftShare = shares.Soft;
    scan.Air = shares.Air > 0.0 ? MedianWithin(bins, -1100.0, -850.0)
               : shares.HasAir  ? MedianWithin(bins, -1100.0, -600.0)
                                : -1000.0;
    return scan;
  }
  double peak = FindDarkPeak(bins, range, 0.02, 3.0);
  if (std::isnan(peak) && range[0] < 0.0)
  {
    // Ringing beside edges goes below an air of 0. It affects few voxels, and air has many. So look again without the
    // lowest 5 % of the voxels.
    const double rings = ValueAt(bins, static_cast<std::uint64_t>(0.05 * all));
    const double beside = FindDarkPeak(bins, { { rings, range[1] } }, 0.05, 3.0);
    peak = std::fabs(beside) <= 0.05 * range[1] ? beside : peak;
  }
  scan.HasAir = !std::isnan(peak);
  scan.Air = std::isnan(peak) ? range[0] : peak;
  scan.AirShare = Count(bins, -infinity, std::nextafter(RelativeThreshold(scan), -infinity)) / all;
  const double bright = range[1] - 0.1 * (range[1] - range[0]);
  scan.IsInverted = std::isnan(peak) && bins.size() > 2 && all >= 1000.0 && range[1] > range[0] &&
                    Count(bins, bright, infinity) >= 0.3 * all && Count(bins, -infinity, scan.Air) < 0.02 * all;
  return scan;
}

double RelativeThreshold(const ScanSummary& scan)
{
  return scan.Air + 0.1 * (scan.High - scan.Air);
}

}
