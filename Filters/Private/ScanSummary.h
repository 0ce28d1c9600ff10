// SPDX-License-Identifier: BSD-3-Clause
// The rules by which vtkChainMailScanStatistics tells what the scalars of a scan are. Its head says why.

#ifndef ScanSummary_h
#define ScanSummary_h

#include "Histogram.h"

#include <array>
#include <cstdint>
#include <limits>

namespace vtkChainMail
{

/// How alike neighbours along the rows of an image of integers are. Pairs of two zeros do not count.
struct NeighbourPairs
{
  std::uint64_t Equal = 0;
  std::uint64_t Unequal = 0;
  std::uint64_t Apart = 0;    ///< of the unequal ones, those that differ by more than 1
  std::uint64_t FarApart = 0; ///< by more than 2

  void Add(const NeighbourPairs& other);
};

/// What is to be known of a scan, in numbers alone, so that it can be sent as it is.
struct ScanSummary
{
  double Kind = 0.0;
  double LowPadding = -std::numeric_limits<double>::infinity();
  double HighPadding = std::numeric_limits<double>::infinity();
  double PaddingShare = 0.0; ///< of all voxels
  double Air = 0.0;          ///< what air is shown as
  double High = 0.0;         ///< near the brightest voxels
  double AirShare = 0.0;     ///< of the voxels that are no padding: near -1000 in CT, else below the threshold
  double SoftShare = 0.0;    ///< CT: from -200 to 200
  double Values = 0.0;       ///< number of different ones
  double Low = 0.0;          ///< near the darkest voxels
  double HasAir = 0.0;       ///< CT with air, or a peak of dark voxels elsewhere
  double IsInverted = 0.0;   ///< most common are the brightest voxels, and there is no peak of dark ones
};

/// `ends` are the smallest and the largest number that is finite.
ScanSummary Summarize(
  const Histogram& voxels, const std::array<double, 2>& ends, const NeighbourPairs& pairs, bool isInteger);

/// Where air ends in a scan without a unit.
double RelativeThreshold(const ScanSummary& scan);

}

#endif
