// SPDX-License-Identifier: BSD-3-Clause
// The rules by which vtkChainMailScanStatistics tells what the scalars of a scan are; see its header for the reasons.

#ifndef ScanSummary_h
#define ScanSummary_h

#include "Histogram.h"

#include <array>
#include <cstdint>
#include <limits>

namespace vtkChainMail
{

/// Counts of neighbour pairs along the rows of an image of integers, by their difference. Pairs of two zeros do not
/// count.
struct NeighbourPairs
{
  std::uint64_t Equal = 0;
  std::uint64_t Unequal = 0;
  std::uint64_t Apart = 0;    ///< of the unequal ones, those that differ by more than 1
  std::uint64_t FarApart = 0; ///< of the unequal ones, those that differ by more than 2

  void Add(const NeighbourPairs& other);
};

/// The results about a scan. All members are doubles, so it is sent between processes as raw memory.
struct ScanSummary
{
  double Kind = 0.0;
  double LowPadding = -std::numeric_limits<double>::infinity();
  double HighPadding = std::numeric_limits<double>::infinity();
  double PaddingShare = 0.0; ///< share of padding among all voxels
  double Air = 0.0;          ///< the value that air is shown as
  double High = 0.0;         ///< near the brightest voxels
  double AirShare = 0.0;     ///< share of air, without padding: near -1000 in CT, else below the threshold
  double SoftShare = 0.0;    ///< share of soft tissue in CT: from -200 to 200
  double Values = 0.0;       ///< number of different values
  double Low = 0.0;          ///< near the darkest voxels
  double HasAir = 0.0;       ///< whether CT has air, or other scans a peak of dark voxels
  double IsInverted = 0.0;   ///< whether the brightest voxels are the most common, without a peak of dark ones
};

/// `ends`: the smallest and the largest finite number.
ScanSummary Summarize(
  const Histogram& voxels, const std::array<double, 2>& ends, const NeighbourPairs& pairs, bool isInteger);

/// The threshold of air in a scan without a unit: a tenth of the way from Air to High.
double RelativeThreshold(const ScanSummary& scan);

}

#endif
