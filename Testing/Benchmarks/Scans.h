#pragma once

#include "../Filters/FilterTest.h"
#include "Session.h"

#include "vtkFloatArray.h"
#include "vtkMetaImageReader.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace bench
{

/// A small run takes the smallest of the scans.
inline std::string scanName(const Session& session, const std::string& name)
{
  return session.small() ? "abdomen_ct" : name;
}

/// A scan from the folder CHAINMAIL_VOLUMES; where it is not there the benchmark is skipped.
inline vtkSmartPointer<vtkImageData> readScan(const std::string& name, const std::string& type = ".mhd")
{
  const char* folder = std::getenv("CHAINMAIL_VOLUMES");
  const std::string path = std::string(folder ? folder : ".") + "/" + name + type;
  if (!std::ifstream(path).good())
  {
    throw Skip("the scan " + name + " is not there; name its folder in CHAINMAIL_VOLUMES");
  }
  vtkNew<vtkMetaImageReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  return reader->GetOutput();
}

/// Soft tissue of constraints from 15 to 35 % and no bone, as in the paper's heart: from fat and skin to the hardest
/// there is.
inline vtkSmartPointer<vtkPiecewiseFunction> softMaterial(double threshold, double top)
{
  auto function = vtkSmartPointer<vtkPiecewiseFunction>::New();
  function->AddPoint(threshold, 0.35);
  function->AddPoint(top, 0.15);
  return function;
}

/// A handle in a scan in Interactive mode.
class Drag
{
public:
  Drag(const Session& session, vtkImageData* scan, double threshold, double top)
  {
    this->filter_->SetInputData(scan);
    this->filter_->SetDevice(session.device().c_str());
    this->filter_->SetModeToInteractive();
    this->filter_->SetTissueThreshold(threshold);
    this->filter_->SetMaterialFunction(softMaterial(threshold, top));
    for (int a = 0; a < 3; ++a)
    {
      this->middle_[a] = 0.5 * (scan->GetBounds()[2 * a] + scan->GetBounds()[2 * a + 1]);
    }
  }

  vtkChainMailDeformation* filter() { return this->filter_; }

  /// Where the handle grabs, as a share of the scan's box from its middle on.
  void grabAt(const FilterTest::Vector& share, double radius)
  {
    double bounds[6];
    vtkImageData::SafeDownCast(this->filter_->GetInput())->GetBounds(bounds);
    for (int a = 0; a < 3; ++a)
    {
      this->place_[a] = this->middle_[a] + share[a] * (bounds[2 * a + 1] - bounds[2 * a]);
    }
    this->radius_ = radius;
  }

  /// The handle lets go, and all is as it was.
  void rest()
  {
    this->filter_->SetInputDataObject(1, FilterTest::MakeProbes({}));
    this->filter_->Reset();
    this->filter_->Update();
  }

  /// The handle goes so far [mm], and the filter follows.
  void to(double far)
  {
    this->far_ = far;
    FilterTest::Probe probe;
    probe.Position = this->place_;
    probe.Displacement = { far, 0.5 * far, -0.25 * far };
    probe.Radius = this->radius_;
    this->filter_->SetInputDataObject(1, FilterTest::MakeProbes({ probe }));
    this->filter_->Update();
  }

  double field(const char* name, int component = 0)
  {
    return FilterTest::Field(this->filter_->GetOutput(), name, component);
  }

  /// `underWay`: a wave may be, and while it is links are longer than their limits.
  void requireSound(bool underWay)
  {
    double spacing[3];
    vtkImageData::SafeDownCast(this->filter_->GetInput())->GetSpacing(spacing);
    const double voxels = std::fabs(this->far_) / *std::min_element(spacing, spacing + 3);
    const double excess = this->field("MaxLinkExcess");
    if (!std::isfinite(this->field("Energy")) || !(underWay || excess <= roundingOf(voxels)))
    {
      throw std::runtime_error("the filter's state must not be reported: link excess " + std::to_string(excess));
    }
  }

private:
  vtkNew<vtkChainMailDeformation> filter_;
  FilterTest::Vector middle_{};
  FilterTest::Vector place_{};
  double radius_ = 0.0;
  double far_ = 0.0;
};

/// Port 1's displacements [mm].
inline std::vector<float> displacementsOf(vtkChainMailDeformation* filter)
{
  filter->Update(1);
  auto atRest = vtkImageData::SafeDownCast(filter->GetOutputDataObject(1));
  auto array = atRest ? vtkFloatArray::SafeDownCast(atRest->GetPointData()->GetArray("Displacement")) : nullptr;
  if (!array)
  {
    throw std::runtime_error("the filter has no displacements");
  }
  return std::vector<float>(array->GetPointer(0), array->GetPointer(0) + array->GetNumberOfValues());
}

template <typename T> double length(const T* v)
{
  return std::sqrt(double(v[0]) * v[0] + double(v[1]) * v[1] + double(v[2]) * v[2]);
}

/// The root mean square distance between two states, over what moves in the second by more than a thousandth of its
/// longest way, as a fraction of that way.
inline double distance(const std::vector<float>& state, const std::vector<float>& optimum)
{
  double pull = 0.0;
  for (std::size_t v = 0; v < optimum.size(); v += 3)
  {
    pull = std::max(pull, length(&optimum[v]));
  }
  double sum = 0.0;
  double touched = 0.0;
  for (std::size_t v = 0; v < optimum.size(); v += 3)
  {
    if (length(&optimum[v]) > 1e-3 * pull)
    {
      const float away[3] = { state[v] - optimum[v], state[v + 1] - optimum[v + 1], state[v + 2] - optimum[v + 2] };
      sum += std::pow(length(away), 2);
      touched += 1.0;
    }
  }
  if (touched == 0.0)
  {
    throw std::runtime_error("nothing moves");
  }
  return std::sqrt(sum / touched) / pull;
}

/// An update from rest with these probes.
inline Task updateFromRest(vtkChainMailDeformation* filter, vtkPolyData* probes)
{
  Task task;
  task.prepare = [filter]
  {
    filter->SetInputDataObject(1, FilterTest::MakeProbes({}));
    filter->Update();
  };
  task.run = [filter, probes]
  {
    filter->SetInputDataObject(1, probes);
    filter->Update();
  };
  return task;
}

/// Throws unless the last update of a filter may be reported, of which nothing moved farther than so many voxels.
inline void requireSound(vtkChainMailDeformation* filter, double voxels)
{
  const std::string error = FilterTest::ErrorOf(filter->GetOutput());
  const double excess = FilterTest::Field(filter->GetOutput(), "MaxLinkExcess");
  if (!error.empty() || !(excess <= roundingOf(voxels)))
  {
    throw std::runtime_error("the state must not be reported: " + error + " link excess " + std::to_string(excess));
  }
}

}
