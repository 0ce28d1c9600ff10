// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailTissuePicker.h"

#include "vtkChainMailDeformation.h"
#include "vtkChainMailScanStatistics.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cmath>

vtkStandardNewMacro(vtkChainMailTissuePicker);

namespace
{
/// Clips the segment from `from` to `to`, in continuous indices, to the image's voxels. Returns false where nothing is
/// left.
bool ClipToVoxels(const int extent[6], const double from[3], const double to[3], double& first, double& last)
{
  first = 0.0;
  last = 1.0;
  for (int a = 0; a < 3; ++a)
  {
    const double low = extent[2 * a] - 0.5;
    const double high = extent[2 * a + 1] + 0.5;
    const double way = to[a] - from[a];
    if (way == 0.0)
    {
      if (from[a] < low || from[a] > high)
      {
        return false;
      }
      continue;
    }
    const double enters = ((way > 0.0 ? low : high) - from[a]) / way;
    const double leaves = ((way > 0.0 ? high : low) - from[a]) / way;
    first = std::max(first, enters);
    last = std::min(last, leaves);
  }
  return first <= last;
}
}

//------------------------------------------------------------------------------
vtkChainMailTissuePicker::vtkChainMailTissuePicker()
  : TissueThreshold(vtkMath::Nan())
{
}

//------------------------------------------------------------------------------
vtkChainMailTissuePicker::~vtkChainMailTissuePicker() = default;

//------------------------------------------------------------------------------
void vtkChainMailTissuePicker::SetOpacity(vtkPiecewiseFunction* opacity)
{
  if (this->Opacity != opacity)
  {
    this->Opacity = opacity;
    this->Modified();
  }
}

vtkPiecewiseFunction* vtkChainMailTissuePicker::GetOpacity()
{
  return this->Opacity;
}

//------------------------------------------------------------------------------
double vtkChainMailTissuePicker::Pick(vtkImageData* image, const double from[3], const double to[3])
{
  vtkPointData* arrays = image ? image->GetPointData() : nullptr;
  vtkDataArray* scalars =
    !arrays ? nullptr : (this->Scalars.empty() ? arrays->GetScalars() : arrays->GetArray(this->Scalars.c_str()));
  if (scalars == nullptr || scalars->GetNumberOfTuples() != image->GetNumberOfPoints() ||
      image->GetNumberOfPoints() == 0)
  {
    return -1.0;
  }
  const auto statistics = vtkChainMailScanStatistics::Of(image, scalars);
  double threshold = this->TissueThreshold;
  if (std::isnan(threshold))
  {
    statistics->GetMaterial(vtkChainMailDeformation::MATERIAL_FUNCTION, threshold, nullptr);
  }
  const double ceiling = statistics->GetHighPadding();

  double a[3];
  double b[3];
  image->TransformPhysicalPointToContinuousIndex(from, a);
  image->TransformPhysicalPointToContinuousIndex(to, b);
  int extent[6];
  image->GetExtent(extent);
  double first = 0.0;
  double last = 1.0;
  if (!ClipToVoxels(extent, a, b, first, last))
  {
    return -1.0;
  }

  const double voxels = std::sqrt(vtkMath::Distance2BetweenPoints(a, b)) * (last - first);
  const int steps = std::max(1, static_cast<int>(std::min(1e6, std::ceil(2.0 * voxels))));
  const double step = std::sqrt(vtkMath::Distance2BetweenPoints(from, to)) * (last - first) / steps;
  double seen = -1.0;      // the first tissue with an opacity above 0
  double transparency = 1; // of the tissue passed so far
  for (int n = 0; n < steps; ++n)
  {
    const double share = first + (n + 0.5) / steps * (last - first);
    int index[3];
    for (int axis = 0; axis < 3; ++axis)
    {
      const double place = a[axis] + share * (b[axis] - a[axis]);
      index[axis] = std::clamp(static_cast<int>(std::floor(place + 0.5)), extent[2 * axis], extent[2 * axis + 1]);
    }
    const double value = scalars->GetComponent(image->ComputePointId(index), 0);
    if (!(value >= threshold && value < ceiling) || std::isinf(value))
    {
      continue;
    }
    if (!this->Opacity)
    {
      return share;
    }
    const double opacity = std::clamp(this->Opacity->GetValue(value), 0.0, 1.0);
    transparency *= std::pow(1.0 - opacity, step / this->OpacityUnitDistance);
    seen = seen < 0.0 && opacity > 0.0 ? share : seen;
    if (transparency <= 0.5)
    {
      return share;
    }
  }
  return seen;
}

//------------------------------------------------------------------------------
void vtkChainMailTissuePicker::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Scalars: " << (this->Scalars.empty() ? "(active)" : this->Scalars) << "\n";
  os << indent << "TissueThreshold: " << this->TissueThreshold << "\n";
  os << indent << "Opacity: " << (this->Opacity ? "given" : "(none)") << "\n";
  os << indent << "OpacityUnitDistance: " << this->OpacityUnitDistance << "\n";
}
