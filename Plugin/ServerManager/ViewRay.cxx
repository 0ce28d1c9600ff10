// SPDX-License-Identifier: BSD-3-Clause
#include "ViewRay.h"

#include "vtkBoundingBox.h"
#include "vtkChainMailScanStatistics.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPVChainMailScanInformation.h"
#include "vtkPVChainMailTissueInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkSMEnumerationDomain.h"
#include "vtkSMOutputPort.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxyIterator.h"
#include "vtkSMProxySelectionModel.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

namespace vtkChainMail
{

namespace
{

// How far new tools stay from those that are there, as a share of the diagonal.
constexpr double Apart = 0.15;

Place Along(const Place& from, const Place& direction, double length)
{
  return { { from[0] + length * direction[0], from[1] + length * direction[1], from[2] + length * direction[2] } };
}

Place Cross(const Place& a, const Place& b)
{
  Place result;
  vtkMath::Cross(a.data(), b.data(), result.data());
  return result;
}

double Dot(const Place& a, const Place& b)
{
  return vtkMath::Dot(a.data(), b.data());
}

void Add(std::vector<double>& rays, const Place& from, const Place& to)
{
  rays.insert(rays.end(), from.begin(), from.end());
  rays.insert(rays.end(), to.begin(), to.end());
}

bool IsDeformation(vtkSMProxy* proxy)
{
  return proxy && proxy->GetXMLName() && std::strcmp(proxy->GetXMLName(), "ChainMailDeformation") == 0 &&
         !proxy->IsPrototype();
}

/// The data of an output port as far as it is there: nothing is computed for this.
vtkPVDataInformation* ImageOf(vtkSMSourceProxy* source, int port)
{
  if (!source || !source->GetOutputPortsCreated() || port >= static_cast<int>(source->GetNumberOfOutputPorts()))
  {
    return nullptr;
  }
  vtkPVDataInformation* data = source->GetDataInformation(port);
  return data && data->DataSetTypeIsA("vtkImageData") && data->GetNumberOfPoints() > 0 ? data : nullptr;
}

/// The axis across the slices that a representation shows: the one that the mode's name ("YZ Plane") leaves out. VTK
/// has named the values of the mode differently over time.
int AxisOfSlices(vtkSMProperty* mode)
{
  auto* modes = mode ? mode->FindDomain<vtkSMEnumerationDomain>() : nullptr;
  const char* name = modes ? modes->GetEntryTextForValue(vtkSMPropertyHelper(mode).GetAsInt()) : nullptr;
  for (int axis = 0; axis < 2; ++axis)
  {
    if (name && !std::strchr(name, "XY"[axis]))
    {
      return axis;
    }
  }
  return 2;
}

}

vtkSMProxy* DeformationOf(vtkSMProxy* proxy)
{
  if (IsDeformation(proxy))
  {
    return proxy;
  }
  for (unsigned int n = 0; proxy && n < proxy->GetNumberOfConsumers(); ++n)
  {
    if (IsDeformation(proxy->GetConsumerProxy(n)))
    {
      return proxy->GetConsumerProxy(n);
    }
  }
  return nullptr;
}

std::string Smoothed(const std::string& scalars)
{
  return scalars + " smooth";
}

std::string Unsmoothed(const std::string& name)
{
  const std::size_t ending = Smoothed("").size();
  const std::string scalars = name.substr(0, name.size() - std::min(ending, name.size()));
  return !scalars.empty() && Smoothed(scalars) == name ? scalars : name;
}

std::array<double, 9> DirectionOf(vtkSMSourceProxy* source, int port)
{
  vtkNew<vtkPVChainMailTissueInformation> asked;
  asked->Port = port;
  source->GatherInformation(asked);
  return asked->Direction;
}

ViewRay::ViewRay(vtkSMSessionProxyManager* manager, vtkSMProxy* selected)
  : Threshold(vtkMath::Nan())
{
  if (manager == nullptr)
  {
    return;
  }
  vtkSMProxySelectionModel* views = manager->GetSelectionModel("ActiveView");
  vtkSMProxy* view = views ? views->GetCurrentProxy() : nullptr;
  this->View = view && view->GetProperty("CameraPositionInfo") ? view : nullptr;
  this->FindImage(manager, selected);
  if (!this->IsValid())
  {
    return;
  }
  this->FindLook();
  this->FindOpacity(this->Source, this->Port);
  if (this->Opacity.empty() && this->Deformation)
  {
    this->FindOpacity(this->Deformation, 0);
  }
}

void ViewRay::FindImage(vtkSMSessionProxyManager* manager, vtkSMProxy* selected)
{
  vtkSMProxySelectionModel* sources = manager->GetSelectionModel("ActiveSources");
  vtkSMProxy* active = selected ? selected : sources ? sources->GetCurrentProxy() : nullptr;
  int port = 0;
  if (auto* output = vtkSMOutputPort::SafeDownCast(active))
  {
    active = output->GetSourceProxy();
    port = static_cast<int>(output->GetPortIndex());
  }
  const auto take = [this](vtkSMProxy* proxy, int output)
  {
    auto* source = vtkSMSourceProxy::SafeDownCast(proxy);
    vtkPVDataInformation* image = ImageOf(source, output);
    if (image)
    {
      this->Source = source;
      this->Port = output;
      image->GetBounds(this->Bounds.data());
      image->GetExtent(this->Extent.data());
    }
    return image != nullptr;
  };

  this->Deformation = DeformationOf(active);
  if (this->Deformation)
  {
    vtkSMPropertyHelper scalars(this->Deformation, "Scalars");
    this->Scalars = scalars.GetNumberOfElements() == 5 && scalars.GetAsString(4) ? scalars.GetAsString(4) : "";
    const int preset = vtkSMPropertyHelper(this->Deformation, "MaterialPreset").GetAsInt();
    if (preset == 0)
    {
      this->Threshold = vtkSMPropertyHelper(this->Deformation, "TissueThreshold").GetAsDouble();
    }
    const bool asItIsNow = vtkSMPropertyHelper(this->Deformation, "Mode").GetAsInt() == 1;
    vtkSMPropertyHelper input(this->Deformation, "Input");
    auto* scan = vtkSMSourceProxy::SafeDownCast(input.GetNumberOfElements() > 0 ? input.GetAsProxy() : nullptr);
    if (preset != 0 && ImageOf(scan, static_cast<int>(input.GetOutputPort())))
    {
      // As the deformation takes it, which may not be what fits best.
      vtkNew<vtkPVChainMailScanInformation> asked;
      asked->Gather(scan, static_cast<int>(input.GetOutputPort()), this->Scalars);
      asked->GetStatistics()->GetMaterial(preset, this->Threshold, nullptr);
    }
    if ((asItIsNow && take(this->Deformation, 0)) ||
        (input.GetNumberOfElements() > 0 && take(input.GetAsProxy(), static_cast<int>(input.GetOutputPort()))))
    {
      return;
    }
  }
  if (take(active, port))
  {
    return;
  }
  vtkNew<vtkSMProxyIterator> all;
  all->SetSessionProxyManager(manager);
  for (all->Begin("sources"); !all->IsAtEnd(); all->Next())
  {
    take(all->GetProxy(), 0);
  }
}

void ViewRay::FindLook()
{
  const auto& b = this->Bounds;
  this->Middle = { { 0.5 * (b[0] + b[1]), 0.5 * (b[2] + b[3]), 0.5 * (b[4] + b[5]) } };
  this->Diagonal =
    std::sqrt((b[1] - b[0]) * (b[1] - b[0]) + (b[3] - b[2]) * (b[3] - b[2]) + (b[5] - b[4]) * (b[5] - b[4]));
  this->HalfHeight = 0.5 * this->Diagonal;
  if (this->View == nullptr)
  {
    return;
  }
  this->View->UpdatePropertyInformation();
  Place eye;
  Place focus;
  Place up;
  vtkSMPropertyHelper(this->View, "CameraPositionInfo").Get(eye.data(), 3);
  vtkSMPropertyHelper(this->View, "CameraFocalPointInfo").Get(focus.data(), 3);
  vtkSMPropertyHelper(this->View, "CameraViewUpInfo").Get(up.data(), 3);
  Place toward = Along(eye, focus, -1.0);
  const double distance = vtkMath::Normalize(toward.data());
  Place right = Cross(up, toward);
  if (distance == 0.0 || vtkMath::Normalize(right.data()) == 0.0)
  {
    return;
  }
  this->Toward = toward;
  this->Right = right;
  this->Up = Cross(toward, right);
  // As deep in the picture as the middle of the data.
  this->Middle = Along(focus, toward, Dot(Along(this->Middle, focus, -1.0), toward));
  const double angle = vtkSMPropertyHelper(this->View, "CameraViewAngle", true).GetAsDouble();
  this->HalfHeight = distance * std::tan(0.5 * vtkMath::RadiansFromDegrees(angle > 0.0 ? angle : 30.0));
}

/// What the view shows of this output, where it shows it as a volume or a slice.
void ViewRay::FindOpacity(vtkSMProxy* source, int port)
{
  if (this->View == nullptr)
  {
    return;
  }
  vtkSMPropertyHelper shown(this->View, "Representations", true);
  for (unsigned int n = 0; n < shown.GetNumberOfElements(); ++n)
  {
    vtkSMProxy* one = shown.GetAsProxy(n);
    if (one == nullptr || one->GetProperty("Input") == nullptr || one->GetProperty("ScalarOpacityFunction") == nullptr)
    {
      continue;
    }
    vtkSMPropertyHelper input(one, "Input");
    const char* kind = vtkSMPropertyHelper(one, "Representation", true).GetAsString();
    if (input.GetNumberOfElements() == 0 || input.GetAsProxy() != source ||
        static_cast<int>(input.GetOutputPort()) != port || vtkSMPropertyHelper(one, "Visibility").GetAsInt() == 0 ||
        kind == nullptr)
    {
      continue;
    }
    if (std::strcmp(kind, "Slice") == 0)
    {
      this->SliceAxis = AxisOfSlices(one->GetProperty("SliceMode"));
      const double low = this->Bounds[2 * this->SliceAxis];
      const double planes = this->Extent[2 * this->SliceAxis + 1] - this->Extent[2 * this->SliceAxis];
      this->Spacing = planes > 0 ? (this->Bounds[2 * this->SliceAxis + 1] - low) / planes : 1.0;
      this->SlicePlace = low + this->Spacing * vtkSMPropertyHelper(one, "Slice", true).GetAsInt();
    }
    if (std::strcmp(kind, "Volume") != 0)
    {
      continue;
    }
    vtkSMPropertyHelper coloured(one, "ColorArrayName", true);
    const char* name = coloured.GetNumberOfElements() == 5 ? coloured.GetAsString(4) : nullptr;
    vtkSMPropertyHelper function(one, "ScalarOpacityFunction", true);
    vtkSMProxy* opacity = function.GetNumberOfElements() > 0 ? function.GetAsProxy() : nullptr;
    if (name == nullptr || *name == '\0' || opacity == nullptr ||
        (!this->Scalars.empty() && this->Scalars != name && this->Scalars != Unsmoothed(name)))
    {
      continue;
    }
    this->Scalars = this->Scalars.empty() ? (this->Deformation ? Unsmoothed(name) : name) : this->Scalars;
    this->Opacity = vtkSMPropertyHelper(opacity, "Points").GetDoubleArray();
    const double unit = vtkSMPropertyHelper(one, "ScalarOpacityUnitDistance", true).GetAsDouble();
    this->OpacityUnitDistance = unit > 0.0 ? unit : 1.0;
  }
}

/// What the server finds on rays, as vtkChainMailTissuePicker::Pick(): with `asSeen` tissue that is seen, else any.
std::vector<double> ViewRay::Cast(const std::vector<double>& rays, bool asSeen) const
{
  vtkNew<vtkPVChainMailTissueInformation> asked;
  asked->Port = this->Port;
  asked->Scalars = this->Scalars;
  asked->TissueThreshold = this->Threshold;
  asked->Opacity = asSeen ? this->Opacity : std::vector<double>();
  asked->OpacityUnitDistance = this->OpacityUnitDistance;
  asked->Rays = rays;
  this->Source->GatherInformation(asked);
  std::vector<double> shares = asked->Shares;
  shares.resize(rays.size() / 6, -1.0);
  return shares;
}

bool ViewRay::Pick(const Place& from, const Place& to, Place& hit) const
{
  std::vector<double> ray;
  if (this->SliceAxis >= 0 && this->Opacity.empty())
  {
    // On the slice, and nowhere else.
    const double way = to[this->SliceAxis] - from[this->SliceAxis];
    const double share = (this->SlicePlace - from[this->SliceAxis]) / way;
    if (way == 0.0 || share < 0.0 || share > 1.0)
    {
      return false;
    }
    hit = Along(from, Along(to, from, -1.0), share);
    Place before = hit;
    Place behind = hit;
    before[this->SliceAxis] -= 0.25 * this->Spacing;
    behind[this->SliceAxis] += 0.25 * this->Spacing;
    Add(ray, before, behind);
    return this->Cast(ray, false)[0] >= 0.0;
  }
  Add(ray, from, to);
  const double share = this->Cast(ray, true)[0];
  if (share >= 0.0)
  {
    hit = Along(from, Along(to, from, -1.0), share);
  }
  return share >= 0.0;
}

bool ViewRay::FindSpot()
{
  this->Turned = false;
  if (!this->IsValid())
  {
    return false;
  }
  // Tissue is held where the image ends, and what is close to there hardly moves.
  const std::array<double, 6> cutOff = this->GetSharesCutOff();
  std::transform(cutOff.begin(), cutOff.end(), this->HeldFaces.begin(), [](double share) { return share > 0.0; });
  const double step = this->GetStep();
  if (this->FindSpot(this->Middle, step, false))
  {
    return true;
  }
  const Place look[3] = { this->Right, this->Up, this->Toward };
  const auto& b = this->Bounds;
  const Place middle = { { 0.5 * (b[0] + b[1]), 0.5 * (b[2] + b[3]), 0.5 * (b[4] + b[5]) } };
  // A patient is looked at from the front first. Of the axes that are left, up is the body's.
  const Place ways[] = { { { 0, -1, 0 } }, { { 0, 1, 0 } }, { { -1, 0, 0 } }, { { 1, 0, 0 } }, { { 0, 0, 1 } },
    { { 0, 0, -1 } } };
  for (const Place& way : ways)
  {
    this->Toward = way;
    this->Up = way[2] == 0.0 ? Place{ { 0, 0, 1 } } : Place{ { 0, 1, 0 } };
    this->Right = Cross(this->Up, this->Toward);
    if (this->FindSpot(middle, this->Diagonal / 20.0, false))
    {
      this->Turned = true;
      return true;
    }
  }
  this->Right = look[0];
  this->Up = look[1];
  this->Toward = look[2];
  return this->FindSpot(this->Middle, step, true);
}

/// How far such rays are from each other.
double ViewRay::GetStep() const
{
  return std::min(this->HalfHeight / 8.0, this->Diagonal / 20.0);
}

std::vector<double> ViewRay::GetRays() const
{
  return this->RaysAround(this->Middle, this->GetStep());
}

std::vector<double> ViewRay::RaysAround(const Place& middle, double step) const
{
  constexpr int reach = 4;
  std::vector<std::pair<int, int>> offsets;
  for (int i = -reach; i <= reach; ++i)
  {
    for (int j = -reach; j <= reach; ++j)
    {
      offsets.emplace_back(i, j);
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
    [](const auto& a, const auto& b)
    { return a.first * a.first + a.second * a.second < b.first * b.first + b.second * b.second; });

  const double length = 2.0 * this->Diagonal;
  std::vector<double> rays;
  for (const auto& offset : offsets)
  {
    const Place through = Along(Along(middle, this->Right, step * offset.first), this->Up, step * offset.second);
    Add(rays, Along(through, this->Toward, length), Along(through, this->Toward, -length));
  }
  return rays;
}

/// Tries such rays. With `anywhere` it goes on into tissue that the image cuts off, and takes what is farthest from
/// there.
bool ViewRay::FindSpot(const Place& middle, double step, bool anywhere)
{
  const double length = 2.0 * this->Diagonal;
  const std::vector<double> rays = this->RaysAround(middle, step);
  const std::vector<double> shares = this->Cast(rays, true);
  const double deeper = anywhere ? 0.1 * this->Diagonal : 0.0;
  const double margin = 0.12 * this->Diagonal;
  std::vector<Place> hits;
  for (std::size_t n = 0; n < shares.size(); ++n)
  {
    const Place from{ { rays[6 * n], rays[6 * n + 1], rays[6 * n + 2] } };
    const Place hit = Along(from, this->Toward, -(2.0 * length * shares[n] + deeper));
    if (shares[n] >= 0.0 && this->DepthOf(hit) >= 0.0)
    {
      hits.push_back(hit);
    }
  }
  this->Spots.clear();
  std::copy_if(hits.begin(), hits.end(), std::back_inserter(this->Spots),
    [&](const Place& hit) { return this->DepthOf(hit) >= margin; });
  if (this->Spots.empty() && anywhere && !hits.empty())
  {
    this->Spots = { *std::max_element(hits.begin(), hits.end(),
      [this](const Place& a, const Place& b) { return this->DepthOf(a) < this->DepthOf(b); }) };
  }
  this->KeepFree();
  return !this->Spots.empty();
}

/// Of the spots, keeps those that are well apart from what is there already; where none is, the one that is farthest.
void ViewRay::KeepFree()
{
  const auto apart = [this](const Place& spot)
  {
    double nearest = this->Diagonal;
    for (const Place& taken : this->Taken)
    {
      nearest = std::min(nearest, std::sqrt(vtkMath::Distance2BetweenPoints(spot.data(), taken.data())));
    }
    return nearest;
  };
  if (this->Taken.empty() || this->Spots.empty())
  {
    return;
  }
  const Place farthest = *std::max_element(
    this->Spots.begin(), this->Spots.end(), [&](const Place& a, const Place& b) { return apart(a) < apart(b); });
  this->Spots.erase(std::remove_if(this->Spots.begin(), this->Spots.end(),
                      [&](const Place& spot) { return apart(spot) < Apart * this->Diagonal; }),
    this->Spots.end());
  if (this->Spots.empty())
  {
    this->Spots = { farthest };
  }
}

void ViewRay::Avoid(const std::string& input)
{
  vtkSMProperty* property = this->Deformation ? this->Deformation->GetProperty(input.c_str()) : nullptr;
  if (property == nullptr)
  {
    return;
  }
  vtkSMPropertyHelper sources(property);
  for (unsigned int n = 0; n < sources.GetNumberOfElements(); ++n)
  {
    auto* source = vtkSMSourceProxy::SafeDownCast(sources.GetAsProxy(n));
    vtkPVDataInformation* data =
      source && source->GetOutputPortsCreated() ? source->GetDataInformation(sources.GetOutputPort(n)) : nullptr;
    vtkBoundingBox box;
    if (data)
    {
      box.SetBounds(data->GetBounds());
    }
    if (box.IsValid())
    {
      Place middle;
      box.GetCenter(middle.data());
      this->Taken.push_back(middle);
    }
  }
}

std::array<double, 6> ViewRay::GetSharesCutOff() const
{
  constexpr int across = 12;
  const auto& b = this->Bounds;
  std::vector<double> rays;
  for (int face = 0; face < 6; ++face)
  {
    const int axis = face / 2;
    for (int n = 0; n < across * across; ++n)
    {
      Place at;
      at[axis] = b[face];
      const double shares[2] = { (n % across + 0.5) / across, (n / across + 0.5) / across };
      for (int other = 1; other < 3; ++other)
      {
        const int a = (axis + other) % 3;
        at[a] = b[2 * a] + shares[other - 1] * (b[2 * a + 1] - b[2 * a]);
      }
      Place inside = at;
      inside[axis] += 0.02 * (b[face - face % 2 + 1 - face % 2] - b[face]);
      Add(rays, at, inside);
    }
  }
  const std::vector<double> shares = this->Cast(rays, false);
  std::array<double, 6> cutOff{};
  for (std::size_t n = 0; n < shares.size(); ++n)
  {
    const std::size_t face = n / (across * across);
    const bool isOfASlice = b[2 * (face / 2)] >= b[2 * (face / 2) + 1];
    cutOff[face] += shares[n] >= 0.0 && !isOfASlice ? 1.0 / (across * across) : 0.0;
  }
  return cutOff;
}

/// How far a place is from the faces that hold tissue. Negative where it is outside.
double ViewRay::DepthOf(const Place& place) const
{
  double depth = this->Diagonal;
  for (std::size_t face = 0; face < 6; ++face)
  {
    const double away = (face % 2 == 0 ? 1.0 : -1.0) * (place[face / 2] - this->Bounds[face]);
    depth = away < 0.0 || this->HeldFaces[face] ? std::min(depth, away) : depth;
  }
  return depth;
}

Place ViewRay::ToWorld(const Place& shares) const
{
  Place world{};
  for (int a = 0; a < 3; ++a)
  {
    world[a] = shares[0] * this->Right[a] + shares[1] * this->Up[a] + shares[2] * this->Toward[a];
  }
  return world;
}

Place ViewRay::GetPlace(const Place& shares, bool onTissue) const
{
  const Place way = this->ToWorld(shares);
  for (double part = 1.0; onTissue && part > 0.2; part -= 0.25) // nearer where the tissue ends before
  {
    const Place place = Along(this->Spots.front(), way, part * this->Diagonal);
    Place hit;
    if (this->Pick(Along(place, this->Toward, this->Diagonal), Along(place, this->Toward, -this->Diagonal), hit))
    {
      return hit;
    }
  }
  return Along(this->Spots.front(), way, this->Diagonal);
}

}
