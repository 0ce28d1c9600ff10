// SPDX-License-Identifier: BSD-3-Clause
#include "Probes.h"

#include "vtkMath.h"
#include "vtkPVDataInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"

#include <algorithm>
#include <cmath>

namespace vtkChainMail
{

namespace
{

// Spots to try, how far they are from each other, as a share of the diagonal, and how much of a pull tissue has to
// follow for a spot to be taken. Where none will do, a smaller grip may, with less bone in it.
constexpr std::size_t MostSpots = 6;
constexpr double BetweenSpots = 0.08;
constexpr double Enough = 0.2;
constexpr double Grips[] = { 1.0, 0.3 };

// How much of what a pull reached becomes the pull, so that what it asks for is surely in reach.
constexpr double Kept = 0.95;

/// Sets a property for as long as this lives.
class Borrowed
{
public:
  Borrowed(vtkSMProxy* proxy, const char* name, int value)
    : Proxy(proxy)
    , Name(name)
    , Before(vtkSMPropertyHelper(proxy, name).GetAsInt())
  {
    this->Set(value);
  }
  ~Borrowed() { this->Set(this->Before); }

private:
  Borrowed(const Borrowed&) = delete;
  void operator=(const Borrowed&) = delete;

  void Set(int value)
  {
    vtkSMPropertyHelper(this->Proxy, this->Name).Set(value);
    this->Proxy->UpdateVTKObjects();
  }

  vtkSMProxy* Proxy;
  const char* Name;
  int Before;
};

void Put(vtkSMProxy* probe, const Place& position, const Place& pull)
{
  Place target;
  vtkMath::Add(position.data(), pull.data(), target.data());
  vtkSMPropertyHelper(probe, "Position").Set(position.data(), 3);
  vtkSMPropertyHelper(probe, "Target").Set(target.data(), 3);
  probe->UpdateVTKObjects();
}

/// The first spot of the view and others that are not next to each other.
std::vector<Place> SpotsToTry(const ViewRay& sight)
{
  std::vector<Place> spots;
  for (const Place& spot : sight.GetSpots())
  {
    const auto isNear = [&](const Place& other) {
      return std::sqrt(vtkMath::Distance2BetweenPoints(spot.data(), other.data())) < BetweenSpots * sight.GetDiagonal();
    };
    if (std::none_of(spots.begin(), spots.end(), isNear) && spots.size() < MostSpots)
    {
      spots.push_back(spot);
    }
  }
  return spots;
}

bool IsEnough(const Place& reached, const Place& pull, double share)
{
  return vtkMath::Norm(reached.data()) >= share * vtkMath::Norm(pull.data());
}

}

long long PointsOf(vtkSMPropertyHelper& input, unsigned int n)
{
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy(n));
  vtkPVDataInformation* data =
    source && source->GetOutputPortsCreated() ? source->GetDataInformation(input.GetOutputPort(n)) : nullptr;
  return data ? data->GetNumberOfPoints() : -1;
}

long long FirstProbeOf(vtkSMProxy* deformation, vtkSMProxy* source)
{
  vtkSMPropertyHelper probes(deformation, "Probes");
  long long first = 0;
  for (unsigned int n = 0; n < probes.GetNumberOfElements(); ++n)
  {
    if (probes.GetAsProxy(n) == source)
    {
      return first;
    }
    const long long points = PointsOf(probes, n);
    if (points < 0)
    {
      return -1;
    }
    first += points;
  }
  return -1;
}

bool ReachedBy(vtkSMProxy* deformation, vtkSMProxy* source, Place& reached)
{
  const long long first = FirstProbeOf(deformation, source);
  vtkSMProperty* property = deformation->GetProperty("ProbeReached");
  if (first < 0 || property == nullptr)
  {
    return false;
  }
  deformation->UpdatePropertyInformation(property);
  vtkSMPropertyHelper all(property);
  if (3 * (first + 1) > static_cast<long long>(all.GetNumberOfElements()))
  {
    return false;
  }
  for (unsigned int a = 0; a < 3; ++a)
  {
    reached[a] = all.GetAsDouble(static_cast<unsigned int>(3 * first) + a);
  }
  return true;
}

void FitPull(vtkSMSourceProxy* probe, vtkSMSourceProxy* deformation, const ViewRay& sight)
{
  const std::vector<Place> spots = SpotsToTry(sight);
  if (spots.empty() || vtkSMPropertyHelper(deformation, "Mode").GetAsInt() != 0)
  {
    return; // step by step, each try would leave its traces
  }
  Place position;
  Place pull;
  vtkSMPropertyHelper(probe, "Position").Get(position.data(), 3);
  vtkSMPropertyHelper(probe, "Target").Get(pull.data(), 3);
  vtkMath::Subtract(pull.data(), position.data(), pull.data());

  const Borrowed preset(deformation, "RelaxationPreset", 0);
  const Borrowed iterations(deformation, "RelaxationIterations", 0);
  const double radius = vtkSMPropertyHelper(probe, "Radius").GetAsDouble();
  const auto put = [&](const Place& at, double grip, const Place& way)
  {
    vtkSMPropertyHelper(probe, "Radius").Set(grip * radius);
    Put(probe, at, way);
  };
  Place best = spots.front();
  double bestGrip = 1.0;
  Place followed{};
  for (const double grip : Grips)
  {
    for (const Place& spot : spots)
    {
      put(spot, grip, pull);
      deformation->UpdatePipeline();
      Place reached;
      if (!ReachedBy(deformation, probe, reached))
      {
        return; // the update failed, and has said why
      }
      if (vtkMath::Norm(reached.data()) > vtkMath::Norm(followed.data()))
      {
        followed = reached;
        best = spot;
        bestGrip = grip;
      }
      if (IsEnough(followed, pull, Enough))
      {
        break;
      }
    }
    if (IsEnough(followed, pull, Enough))
    {
      break;
    }
  }
  // Tissue that follows a pull follows a shorter one of the same direction. Along each axis it has limits of its own,
  // so where it stayed behind it went another way.
  if (!IsEnough(followed, pull, Kept) && vtkMath::Norm(followed.data()) > 0.0)
  {
    pull = followed;
    vtkMath::MultiplyScalar(pull.data(), Kept);
  }
  put(best, bestGrip, pull);
}

}
