// SPDX-License-Identifier: BSD-3-Clause
#include "OutputGrid.h"

#include "Frame.h"
#include "Grids.h"

#include "Error.h"

#include "vtkAbstractArray.h"
#include "vtkPointData.h"

#include <vtksys/SystemInformation.hxx>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

namespace vtkChainMail
{

namespace
{

/// The padding on both sides of each axis. Throws InputError where the padded image would be too large.
chainmail::Index3 ReadPadding(int padding, vtkImageData* image)
{
  std::array<int, 6> extent;
  image->GetExtent(extent.data());
  chainmail::Index3 sides;
  std::string size;
  bool isFar = false;
  for (int a = 0; a < 3; ++a)
  {
    const std::int64_t first = extent[2 * a];
    const std::int64_t last = extent[2 * a + 1];
    sides[a] = last > first ? padding : 0;
    size += (a == 0 ? "" : " x ") + std::to_string(last - first + 1 + 2 * sides[a]);
    isFar = isFar || !IsIndex(first - sides[a]) || !IsIndex(last + sides[a]);
  }
  const int fitting = FittingPadding(extent, padding);
  if (fitting < padding)
  {
    throw chainmail::InputError(
      "With an OutputPadding of " + std::to_string(padding) + " the deformed image would have " +
      (isFar ? "voxel indices beyond 2147483646, the limit"
             : size + " voxels; at most " + std::to_string(chainmail::Grid::maxVoxels) + " can be handled") +
      ". Lower OutputPadding to " + std::to_string(fitting) + " or less" +
      (isFar ? ", or give the image an extent that begins near 0." : "."));
  }
  return sides;
}

/// Sets the range of voxels that holds a box in world axes, in indices from the image's first voxel. Throws InputError
/// where the box does not meet the padded image.
void ReadBounds(const std::array<double, 6>& bounds, vtkImageData* image, const chainmail::Index3& padding,
  chainmail::OutputDetail& detail)
{
  const Frame frame(image);
  Vector3 low{ HUGE_VAL, HUGE_VAL, HUGE_VAL };
  Vector3 high{ -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
  bool isBox = true;
  for (int a = 0; a < 3; ++a)
  {
    isBox = isBox && bounds[2 * a] <= bounds[2 * a + 1]; // false for NaN
  }
  for (int corner = 0; corner < 8; ++corner)
  {
    const double world[3] = { bounds[corner & 1], bounds[2 + (corner >> 1 & 1)], bounds[4 + (corner >> 2)] };
    const Vector3 place = frame.PointToEngine(world);
    for (int a = 0; a < 3; ++a)
    {
      const double index = place[a] / frame.GetSpacing()[a];
      low[a] = std::min(low[a], index);
      high[a] = std::max(high[a], index);
    }
  }
  constexpr double slack = 1e-6; // [voxels] for rounding, in bounds computed from voxel positions
  int dimensions[3];
  image->GetDimensions(dimensions);
  for (int a = 0; a < 3; ++a)
  {
    const double first = -padding[a];
    const double last = dimensions[a] - 1.0 + padding[a];
    isBox = isBox && low[a] <= last + slack && high[a] >= first - slack;
    if (isBox)
    {
      detail.first[a] = static_cast<int>(std::max(first, std::floor(std::min(low[a], last) + slack)));
      detail.last[a] = static_cast<int>(std::min(last, std::ceil(std::max(high[a], first) - slack)));
    }
  }
  if (!isBox)
  {
    const double* all = image->GetBounds();
    std::ostringstream text;
    text << "OutputBounds do not overlap the image: they are " << bounds[0] << " to " << bounds[1] << ", " << bounds[2]
         << " to " << bounds[3] << ", " << bounds[4] << " to " << bounds[5] << ", the image is " << all[0] << " to "
         << all[1] << ", " << all[2] << " to " << all[3] << ", " << all[4] << " to " << all[5]
         << " mm. Set bounds that overlap it, with the lower value of each pair first, or switch UseOutputBounds off.";
    throw chainmail::InputError(text.str());
  }
}

}

OutputGrid::OutputGrid(const Properties& properties, vtkImageData* image)
  : Padding(ReadPadding(properties.OutputPadding, image))
{
  chainmail::OutputDetail& detail = this->Detail;
  detail.finer = properties.OutputMagnification;
  if (properties.UseOutputBounds)
  {
    ReadBounds(properties.OutputBounds, image, this->Padding, detail);
  }
  int extent[6];
  image->GetExtent(extent);
  chainmail::Grid grid;
  std::string size;
  bool fits = true;
  for (int a = 0; a < 3; ++a)
  {
    const std::int64_t last = std::int64_t(extent[2 * a + 1]) - extent[2 * a] + this->Padding[a];
    const std::int64_t low = std::max<std::int64_t>(-this->Padding[a], detail.first[a]);
    const std::int64_t high = std::min<std::int64_t>(last, detail.last[a]);
    const std::int64_t voxels = detail.finer * (high - low) + 1;
    fits = fits && IsIndex(detail.finer * (extent[2 * a] + low)) && IsIndex(detail.finer * (extent[2 * a] + high)) &&
           IsIndex(voxels) && IsIndex(detail.finer * (last + 1));
    grid.size[a] = fits ? static_cast<int>(voxels) : 0;
    size += (a == 0 ? "" : " x ") + std::to_string(voxels);
  }
  if (detail.finer > 1 && !(fits && grid.fits()))
  {
    throw chainmail::InputError("With an OutputMagnification of " + std::to_string(detail.finer) +
                                " the deformed image would have " + size + " voxels; at most " +
                                std::to_string(chainmail::Grid::maxVoxels) +
                                " can be handled, with indices up to 2147483646. Lower OutputMagnification, or show a "
                                "part of the image (UseOutputBounds).");
  }
}

std::array<int, 6> OutputGrid::ExtentOf(vtkImageData* image) const
{
  std::array<int, 6> extent;
  image->GetExtent(extent.data());
  const int finer = this->Detail.finer;
  for (int a = 0; a < 3; ++a)
  {
    const int origin = extent[2 * a];
    const int last = extent[2 * a + 1] - origin + this->Padding[a];
    extent[2 * a] = finer * (origin + std::max(-this->Padding[a], this->Detail.first[a]));
    extent[2 * a + 1] = finer * (origin + std::min(last, this->Detail.last[a]));
  }
  return extent;
}

std::array<double, 3> OutputGrid::SpacingOf(vtkImageData* image) const
{
  std::array<double, 3> spacing;
  image->GetSpacing(spacing.data());
  for (double& step : spacing)
  {
    step /= this->Detail.finer;
  }
  return spacing;
}

void RequireMemory(const OutputGrid& grid, vtkImageData* image, const std::array<int, 6>& extent, std::size_t more)
{
  double perVoxel = static_cast<double>(more);
  for (int n = 0; n < image->GetPointData()->GetNumberOfArrays(); ++n)
  {
    vtkAbstractArray* array = image->GetPointData()->GetAbstractArray(n);
    perVoxel += static_cast<double>(array->GetDataTypeSize()) * array->GetNumberOfComponents();
  }
  double voxels = 1.0;
  std::string size;
  for (int a = 0; a < 3; ++a)
  {
    const int width = extent[2 * a + 1] - extent[2 * a] + 1;
    voxels *= width;
    size += (a == 0 ? "" : " x ") + std::to_string(width);
  }
  vtksys::SystemInformation system;
  system.RunMemoryCheck();
  constexpr double kibibyte = 1024.0;
  constexpr double gigabyte = 1e9;
  const double free =
    kibibyte * (static_cast<double>(system.GetHostMemoryTotal()) - static_cast<double>(system.GetHostMemoryUsed()));
  if (voxels * perVoxel > free)
  {
    const bool isFiner = grid.Detail.finer > 1;
    const std::string property = isFiner ? "OutputMagnification" : "OutputPadding";
    std::ostringstream text;
    text.precision(2);
    text << std::fixed << "With an " << property << " of "
         << (isFiner ? grid.Detail.finer : *std::max_element(grid.Padding.begin(), grid.Padding.end()))
         << " the deformed image has " << size << " voxels, which take " << voxels * perVoxel / gigabyte << " GB; "
         << free / gigabyte << " GB of main memory are free. Lower " << property
         << ", or show a part of the image (UseOutputBounds).";
    throw chainmail::InputError(text.str());
  }
}

}
