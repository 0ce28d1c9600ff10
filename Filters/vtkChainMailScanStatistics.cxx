// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailScanStatistics.h"

#include "Private/Arrays.h"
#include "Private/Convert.h"
#include "Private/Presets.h"
#include "Private/ScanSummary.h"
#include "Private/Text.h"

#include "Threads.h"

#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"
#include "vtkWeakPointer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <list>
#include <mutex>
#include <numeric>
#include <type_traits>
#include <utility>

using vtkChainMail::Histogram;
using vtkChainMail::Look;
using vtkChainMail::MaterialPresets;
using vtkChainMail::NeighbourPairs;
using vtkChainMail::ScanSummary;

vtkStandardNewMacro(vtkChainMailScanStatistics);

namespace
{

constexpr vtkIdType mostVoxels = vtkIdType(1) << 24;

/// The histogram of an image or of a part of it, its pairs of neighbours, and its smallest and largest number.
struct Counts
{
  Histogram Voxels;
  NeighbourPairs Pairs;
  std::array<double, 2> Ends{ { std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() } };

  void Add(const Counts& other)
  {
    this->Voxels.Add(other.Voxels);
    this->Pairs.Add(other.Pairs);
    this->Ends = { { std::min(this->Ends[0], other.Ends[0]), std::max(this->Ends[1], other.Ends[1]) } };
  }
};

/// The rows of a part that are read: every n-th row of the whole image, without the planes shared with the part before.
class Rows
{
public:
  Rows(const int part[6], const int whole[6])
  {
    vtkIdType size[3];
    vtkIdType voxels = 1;
    for (int a = 0; a < 3; ++a)
    {
      size[a] = whole[2 * a + 1] - whole[2 * a] + 1;
      voxels *= std::max<vtkIdType>(size[a], 1);
    }
    this->Every = (voxels + mostVoxels - 1) / mostVoxels;
    // Rows go along the first axis with more than one voxel; x may have only one in a slice.
    this->Axis = size[0] > 1 ? 0 : size[1] > 1 ? 1 : 2;
    vtkIdType step = 1;
    for (int a = 0; a < 3; ++a)
    {
      this->Steps[a] = step;
      step *= part[2 * a + 1] - part[2 * a] + 1;
      this->Part[2 * a] = part[2 * a];
      this->Part[2 * a + 1] = part[2 * a + 1];
      this->First[a] = part[2 * a] > whole[2 * a] ? part[2 * a] + 1 : part[2 * a];
    }
    const int v = (this->Axis + 1) % 3;
    const int w = (this->Axis + 2) % 3;
    for (int k = this->First[w]; k <= part[2 * w + 1]; ++k)
    {
      for (int j = this->First[v]; j <= part[2 * v + 1]; ++j)
      {
        if ((j - whole[2 * v] + static_cast<vtkIdType>(k - whole[2 * w])) % this->Every == 0)
        {
          this->Starts.push_back(
            (j - part[2 * v]) * this->Steps[v] + static_cast<vtkIdType>(k - part[2 * w]) * this->Steps[w]);
        }
      }
    }
  }

  std::size_t GetNumber() const { return this->Starts.size(); }
  vtkIdType GetStart(std::size_t row) const { return this->Starts[row]; }
  vtkIdType GetStep() const { return this->Steps[this->Axis]; }
  vtkIdType GetLength() const { return this->Part[2 * this->Axis + 1] - this->Part[2 * this->Axis] + 1; }
  /// The first voxel of a row that is counted. A voxel before it only forms a pair of neighbours with it.
  vtkIdType GetFirst() const { return this->First[this->Axis] - this->Part[2 * this->Axis]; }

private:
  vtkIdType Every = 1;
  int Axis = 0;
  int Part[6];
  int First[3];
  vtkIdType Steps[3];
  std::vector<vtkIdType> Starts;
};

/// Counts the rows from `from` to before `to`.
template <typename T>
void CountRows(const T* scalars, int components, const unsigned char* ghosts, const Rows& rows, std::size_t from,
  std::size_t to, Counts& counts)
{
  constexpr bool isSmall = std::is_integral<T>::value && sizeof(T) <= 2;
  std::vector<std::uint32_t> table(isSmall ? std::size_t(1) << (8 * sizeof(T)) : 0);
  constexpr unsigned char elsewhere = vtkDataSetAttributes::DUPLICATEPOINT;
  for (std::size_t row = from; row < to; ++row)
  {
    const T* first = scalars + rows.GetStart(row) * components;
    const vtkIdType step = rows.GetStep() * components;
    const unsigned char* mark = ghosts ? ghosts + rows.GetStart(row) : nullptr;
    const auto isElsewhere = [&](vtkIdType n) { return mark && (mark[n * rows.GetStep()] & elsewhere); };
    for (vtkIdType n = rows.GetFirst(); n < rows.GetLength(); ++n)
    {
      const T value = first[n * step];
      if (isElsewhere(n))
      {
        continue;
      }
      if constexpr (isSmall)
      {
        ++table[static_cast<std::make_unsigned_t<T>>(value)];
      }
      else if (const auto number = static_cast<double>(value); std::isfinite(number))
      {
        counts.Voxels.Add(number);
        counts.Ends = { { std::min(counts.Ends[0], number), std::max(counts.Ends[1], number) } };
      }
    }
    if constexpr (std::is_integral<T>::value)
    {
      NeighbourPairs pairs;
      for (vtkIdType n = std::max<vtkIdType>(rows.GetFirst(), 1); n < rows.GetLength(); ++n)
      {
        const T value = first[n * step];
        const T before = first[(n - 1) * step];
        const auto apart =
          static_cast<std::uint64_t>(std::max(value, before)) - static_cast<std::uint64_t>(std::min(value, before));
        const bool counted = (value != 0 || before != 0) && !isElsewhere(n);
        pairs.Equal += counted && apart == 0;
        pairs.Unequal += counted && apart > 0;
        pairs.Apart += counted && apart > 1;
        pairs.FarApart += counted && apart > 2;
      }
      counts.Pairs.Add(pairs);
    }
  }
  for (std::size_t n = 0; n < table.size(); ++n)
  {
    if constexpr (isSmall)
    {
      if (table[n] > 0)
      {
        const auto number = static_cast<double>(static_cast<T>(n));
        counts.Voxels.Add(number, table[n]);
        counts.Ends = { { std::min(counts.Ends[0], number), std::max(counts.Ends[1], number) } };
      }
    }
  }
}

std::string Percent(double share)
{
  const double percent = 100.0 * share;
  if (percent > 0.0 && percent < 0.1)
  {
    return "less than 0.1 %";
  }
  const double rounded = percent < 1.0 ? 0.1 * std::round(10.0 * percent) : std::round(percent);
  return vtkChainMail::ToString(rounded) + " %";
}

/// A number as a user would write it.
std::string Short(double number)
{
  return vtkChainMail::ToString(std::fabs(number) >= 100.0 ? std::round(number) : number);
}

}

//------------------------------------------------------------------------------
class vtkChainMailScanStatistics::vtkInternals
{
public:
  void Count(vtkImageData* part, vtkDataArray* scalars, const int whole[6])
  {
    this->Counted = std::make_unique<Counts>();
    this->Summary = ScanSummary();
    this->IsInteger = scalars->GetDataType() != VTK_FLOAT && scalars->GetDataType() != VTK_DOUBLE;
    std::copy_n(whole, 6, this->Whole.begin());
    std::array<int, 6> extent;
    part->GetExtent(extent.data());
    this->IsComplete = extent == this->Whole;

    const vtkSmartPointer<vtkDataArray> array = vtkChainMail::ToEngineArray(scalars);
    vtkUnsignedCharArray* marks =
      this->IsComplete
        ? nullptr
        : vtkUnsignedCharArray::SafeDownCast(part->GetPointData()->GetArray(vtkDataSetAttributes::GhostArrayName()));
    const unsigned char* ghosts = marks ? marks->GetPointer(0) : nullptr;
    const Rows rows(extent.data(), this->Whole.data());
    // Counts do not depend on the division into shares. Shares are large because each has a histogram of its own.
    const std::size_t shares =
      std::clamp<std::size_t>(static_cast<std::size_t>(rows.GetLength()) * rows.GetNumber() >> 18, 1, 16);
    std::mutex mutex;
    chainmail::inParallel(shares,
      [&](std::size_t n)
      {
        Counts mine;
        const std::size_t from = n * rows.GetNumber() / shares;
        const std::size_t to = (n + 1) * rows.GetNumber() / shares;
        const void* data = array->GetVoidPointer(0);
        switch (array->GetDataType())
        {
          vtkTemplateMacro(
            CountRows(static_cast<const VTK_TT*>(data), array->GetNumberOfComponents(), ghosts, rows, from, to, mine));
        }
        const std::lock_guard<std::mutex> lock(mutex);
        this->Counted->Add(mine);
      });
    this->Judge();
  }

  void Judge()
  {
    this->Summary =
      vtkChainMail::Summarize(this->Counted->Voxels, this->Counted->Ends, this->Counted->Pairs, this->IsInteger);
  }

  ScanSummary Summary;
  std::unique_ptr<Counts> Counted; // null where only the summary was received, or nothing will be added
  std::array<int, 6> Whole{ { 0, -1, 0, -1, 0, -1 } };
  bool IsComplete = false;
  bool IsInteger = false;
};

//------------------------------------------------------------------------------
vtkChainMailScanStatistics::vtkChainMailScanStatistics()
  : Internals(new vtkInternals)
{
}

//------------------------------------------------------------------------------
vtkChainMailScanStatistics::~vtkChainMailScanStatistics() = default;

//------------------------------------------------------------------------------
void vtkChainMailScanStatistics::Read(vtkImageData* image, vtkDataArray* scalars)
{
  this->ReadPart(image, scalars, image ? image->GetExtent() : nullptr);
}

void vtkChainMailScanStatistics::ReadPart(vtkImageData* part, vtkDataArray* scalars, const int whole[6])
{
  this->Internals = std::make_unique<vtkInternals>();
  if (part && scalars && whole && part->GetNumberOfPoints() > 0 &&
      scalars->GetNumberOfTuples() == part->GetNumberOfPoints() && scalars->GetNumberOfComponents() > 0)
  {
    this->Internals->Count(part, scalars, whole);
  }
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkChainMailScanStatistics::Merge(vtkChainMailScanStatistics* other)
{
  vtkInternals& mine = *this->Internals;
  const vtkInternals& its = *other->Internals;
  if (mine.IsComplete || (!its.IsComplete && !its.Counted))
  {
    return;
  }
  if (its.IsComplete || !mine.Counted)
  {
    this->Unpack(other->Pack());
    return;
  }
  mine.Counted->Add(*its.Counted);
  mine.IsInteger = mine.IsInteger && its.IsInteger;
  mine.Judge();
  this->Modified();
}

//------------------------------------------------------------------------------
std::vector<double> vtkChainMailScanStatistics::Pack() const
{
  const vtkInternals& mine = *this->Internals;
  constexpr std::size_t size = sizeof(ScanSummary) / sizeof(double);
  std::vector<double> numbers(size + 2);
  std::memcpy(numbers.data(), &mine.Summary, sizeof(ScanSummary));
  numbers[size] = mine.IsComplete;
  numbers[size + 1] = mine.IsInteger;
  if (!mine.IsComplete && mine.Counted)
  {
    const Counts& counts = *mine.Counted;
    for (const std::uint64_t pairs :
      { counts.Pairs.Equal, counts.Pairs.Unequal, counts.Pairs.Apart, counts.Pairs.FarApart })
    {
      numbers.push_back(static_cast<double>(pairs));
    }
    numbers.insert(numbers.end(), counts.Ends.begin(), counts.Ends.end());
    for (const auto& bin : counts.Voxels.GetBins())
    {
      numbers.push_back(bin.Value);
      numbers.push_back(static_cast<double>(bin.Count));
    }
  }
  return numbers;
}

void vtkChainMailScanStatistics::Unpack(const std::vector<double>& numbers)
{
  constexpr std::size_t size = sizeof(ScanSummary) / sizeof(double);
  this->Internals = std::make_unique<vtkInternals>();
  this->Modified();
  if (numbers.size() < size + 2)
  {
    return;
  }
  vtkInternals& mine = *this->Internals;
  std::memcpy(static_cast<void*>(&mine.Summary), numbers.data(), sizeof(ScanSummary));
  mine.IsComplete = numbers[size] != 0.0;
  mine.IsInteger = numbers[size + 1] != 0.0;
  const std::size_t first = size + 2;
  if (numbers.size() >= first + 6)
  {
    mine.Counted = std::make_unique<Counts>();
    NeighbourPairs& pairs = mine.Counted->Pairs;
    std::size_t n = first;
    for (std::uint64_t* count : { &pairs.Equal, &pairs.Unequal, &pairs.Apart, &pairs.FarApart })
    {
      *count = static_cast<std::uint64_t>(numbers[n++]);
    }
    mine.Counted->Ends = { { numbers[n], numbers[n + 1] } };
    for (n += 2; n + 1 < numbers.size(); n += 2)
    {
      mine.Counted->Voxels.Add(numbers[n], static_cast<std::uint32_t>(numbers[n + 1]));
    }
  }
}

//------------------------------------------------------------------------------
vtkSmartPointer<vtkChainMailScanStatistics> vtkChainMailScanStatistics::Of(vtkImageData* image, vtkDataArray* scalars)
{
  struct Kept
  {
    vtkWeakPointer<vtkDataArray> Array;
    vtkMTimeType Time;
    std::array<int, 6> Extent;
    vtkSmartPointer<vtkChainMailScanStatistics> Statistics;
  };
  static std::list<Kept> kept;
  static std::mutex mutex;
  constexpr std::size_t mostKept = 8;

  const vtkMTimeType time = std::max(image->GetMTime(), scalars->GetMTime());
  std::array<int, 6> extent;
  image->GetExtent(extent.data());
  const std::lock_guard<std::mutex> lock(mutex);
  for (auto one = kept.begin(); one != kept.end(); ++one)
  {
    if (one->Array == scalars && one->Time == time && one->Extent == extent)
    {
      kept.splice(kept.begin(), kept, one);
      return kept.front().Statistics;
    }
  }
  Kept one;
  one.Array = scalars;
  one.Time = time;
  one.Extent = extent;
  one.Statistics = vtkSmartPointer<vtkChainMailScanStatistics>::New();
  one.Statistics->Read(image, scalars);
  one.Statistics->Internals->Counted.reset(); // the whole image was read: nothing will be added
  kept.push_front(one);
  kept.resize(std::min(kept.size(), mostKept));
  return kept.front().Statistics;
}

//------------------------------------------------------------------------------
int vtkChainMailScanStatistics::GetKind() const
{
  return static_cast<int>(this->Internals->Summary.Kind);
}

bool vtkChainMailScanStatistics::IsPadding(double scalar) const
{
  return scalar <= this->GetLowPadding() || scalar >= this->GetHighPadding();
}

double vtkChainMailScanStatistics::GetLowPadding() const
{
  return this->Internals->Summary.LowPadding;
}

double vtkChainMailScanStatistics::GetHighPadding() const
{
  return this->Internals->Summary.HighPadding;
}

double vtkChainMailScanStatistics::GetBackgroundValue() const
{
  return this->Internals->Summary.Air;
}

//------------------------------------------------------------------------------
void vtkChainMailScanStatistics::GetMaterial(int preset, double& tissueThreshold, vtkPiecewiseFunction* function) const
{
  const ScanSummary& scan = this->Internals->Summary;
  const int kind = this->GetKind();
  const Look fitting = kind == KIND_CT ? Look::CT : kind == KIND_LABELS ? Look::Labels : Look::Unknown;
  const auto chosen = static_cast<MaterialPresets>(preset);
  const Look look = chosen == MaterialPresets::CT ? Look::CT : chosen == MaterialPresets::MR ? Look::MR : fitting;
  vtkChainMail::GetMaterial(look, scan.Air, scan.High, tissueThreshold, function);
}

//------------------------------------------------------------------------------
std::string vtkChainMailScanStatistics::GetDescription() const
{
  const ScanSummary& scan = this->Internals->Summary;
  std::string text;
  if (this->GetKind() == KIND_CT)
  {
    text = "Taken for CT: " + Percent(scan.AirShare) + " of the voxels are near -1000 (air), " +
           Percent(scan.SoftShare) + " from -200 to 200 (soft tissue)";
  }
  else if (this->GetKind() == KIND_LABELS)
  {
    text = "Taken for labels: 0 is air, all other labels are the same tissue, sampled by the nearest voxel";
  }
  else if (scan.Values == 0.0)
  {
    text = "No voxel has a finite scalar";
  }
  else if (scan.Low == scan.High)
  {
    text = "All voxels have the same scalar (" + Short(scan.Low) + ") and are taken for tissue";
  }
  else
  {
    text = "Taken for MR or another scan without a unit: air below " + Short(vtkChainMail::RelativeThreshold(scan)) +
           " (" + Percent(scan.AirShare) + " of the voxels), the brightest voxels near " + Short(scan.High);
  }
  if (scan.PaddingShare > 0.0)
  {
    text += "; " + Percent(scan.PaddingShare) + " of the voxels are padding (";
    text += std::isfinite(scan.LowPadding) ? "up to " + Short(scan.LowPadding) : "";
    text += std::isfinite(scan.LowPadding) && std::isfinite(scan.HighPadding) ? ", " : "";
    text += std::isfinite(scan.HighPadding) ? "from " + Short(scan.HighPadding) : "";
    text += "), neither air nor tissue";
  }
  return text + ".";
}

//------------------------------------------------------------------------------
std::string vtkChainMailScanStatistics::GetDoubt(int preset) const
{
  const ScanSummary& scan = this->Internals->Summary;
  const int kind = this->GetKind();
  if (scan.Values < 2.0)
  {
    return {};
  }
  const auto chosen = static_cast<MaterialPresets>(preset);
  if (chosen == MaterialPresets::CT)
  {
    return kind == KIND_CT ? std::string()
                           : std::string("MaterialPreset is CT, but the scalars do not look like Hounsfield units: ") +
                               (kind == KIND_LABELS   ? "they look like labels."
                                 : scan.Low < -1100.0 ? "many are below -1100, but air is at -1000."
                                                      : "they lack air near -1000 or soft tissue near 0.") +
                               " Convert them to Hounsfield units, or choose another MaterialPreset.";
  }
  if (chosen == MaterialPresets::MR)
  {
    return kind == KIND_UNKNOWN
             ? std::string()
             : std::string("MaterialPreset is MR, but the scalars look like ") +
                 (kind == KIND_CT ? "Hounsfield units" : "labels") + ". Choose another MaterialPreset.";
  }
  if (kind == KIND_CT && !scan.HasAir)
  {
    return "The scan was taken for CT, although it has no air. If it is not CT, choose the MaterialPreset MR, or set "
           "TissueThreshold and MaterialFunction.";
  }
  if (kind == KIND_UNKNOWN && scan.IsInverted != 0.0)
  {
    return "The brightest voxels are the most common, but air should be dark. The scan may be inverted and its air "
           "taken for tissue: invert the scan, or set TissueThreshold and MaterialFunction.";
  }
  if (kind == KIND_UNKNOWN && scan.Low < -200.0)
  {
    return "The scalars go down to " + Short(scan.Low) +
           " like those of CT, but are not distributed like Hounsfield units. If the scan is CT, convert it to "
           "Hounsfield units; otherwise check TissueThreshold.";
  }
  return {};
}

//------------------------------------------------------------------------------
void vtkChainMailScanStatistics::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Description: " << this->GetDescription() << "\n";
}
