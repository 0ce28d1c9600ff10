// SPDX-License-Identifier: BSD-3-Clause
#include "Report.h"

#include "Arrays.h"
#include "Format.h"

#include "vtkDataArray.h"
#include "vtkFieldData.h"
#include "vtkMath.h"
#include "vtkStringArray.h"

#include <algorithm>
#include <cmath>

namespace vtkChainMail
{

namespace
{

/// 1234567 as "1,234,567".
std::string Grouped(std::size_t number)
{
  std::string digits = std::to_string(number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
  {
    digits.insert(static_cast<std::size_t>(at), ",");
  }
  return digits;
}

std::string Short(double number)
{
  return chainmail::toString(number, number < 10.0 ? 2 : 3);
}

/// The summary of the update.
std::string Summarize(const Scene& scene, const Session& session, vtkFieldData* fields)
{
  const Results& found = session.GetResults();
  const int reduction = scene.Tissue.Settings.modelReduction;
  std::string text = found.Statistics.displaced == 0 ? "Nothing" : Grouped(found.Statistics.displaced);
  if (found.Statistics.displaced > 0)
  {
    text += reduction == 1 ? " voxels" : " elements of " + std::to_string(reduction) + " voxels a side";
  }
  text += " moved; ";
  const int sweeps = scene.How.relaxationIterations;
  if (!found.Propagation.finished)
  {
    text += "propagation not finished";
  }
  else if (sweeps == 0)
  {
    text += "not relaxed";
  }
  else if (found.Relaxation.converged)
  {
    text += "settled";
  }
  else
  {
    text += scene.Interactive ? "settling" : "not quite settled after " + std::to_string(sweeps) + " iterations";
  }

  double seconds = 0.0;
  vtkDataArray* milliseconds = fields->GetArray("Milliseconds");
  for (int t = 0; milliseconds && t < milliseconds->GetNumberOfComponents(); ++t)
  {
    seconds += 1e-3 * milliseconds->GetComponent(0, t);
  }
  vtkDataArray* memory = fields->GetArray("PeakDeviceMemory");
  auto* device = vtkStringArray::SafeDownCast(fields->GetAbstractArray("DeviceName"));
  return text + "; " + Short(seconds) + " s, " + std::to_string(std::lround(memory ? memory->GetTuple1(0) : 0.0)) +
         " MB on " + (device ? device->GetValue(0) : std::string("the device")) + ".\n" + scene.Guess;
}

}

void Report::Set(const Scene& scene, const Session& session, vtkFieldData* fields)
{
  const Results& found = session.GetResults();
  this->Space = scene.Space;
  this->Held = found.Held;
  this->Arrived = found.Propagation.finished;
  this->Settles = scene.How.relaxationIterations > 0;
  this->Probes.assign(scene.Probes.size(), Probe());
  for (std::size_t n = 0; n < this->Held.size(); ++n)
  {
    const std::size_t p = this->Held[n];
    Probe& probe = this->Probes[p];
    probe.Held = n;
    probe.Present = true;
    probe.Anchor = scene.Probes[p].anchor;
    probe.Soft = scene.Probes[p].isSoft();
    probe.Way = HowFar(scene.Probes[p], found.Probes[p]);
    probe.Empty = found.Probes[p].elements == 0;
  }
  this->Misses.clear();
  for (const SurfaceHistory* history : { &session.GetCutHistory(), &session.GetCarveHistory() })
  {
    for (const std::string& name : history->GetMissing())
    {
      this->Misses += name + " met no tissue, or only what was cut before.\n";
    }
  }
  this->Summary = Summarize(scene, session, fields);
  this->Written = false;
}

void Report::Set(const std::string& problem)
{
  this->Text = problem;
  this->Written = true;
}

const std::string& Report::Get(const Session& session)
{
  if (this->Written)
  {
    return this->Text;
  }
  constexpr std::size_t mostNamed = 10;
  this->Text.clear();
  for (std::size_t p = 0; p < this->Probes.size() && p < mostNamed; ++p)
  {
    const Probe& probe = this->Probes[p];
    this->Text += "Probe " + std::to_string(p + 1);
    if (!probe.Present)
    {
      this->Text += " was released by Reset.\n";
    }
    else if (probe.Empty)
    {
      this->Text += " has no tissue of its own.\n";
    }
    else if (probe.Soft && !this->Settles)
    {
      this->Text += " is soft and moves nothing, because RelaxationIterations is 0.\n";
    }
    else if (probe.Anchor)
    {
      this->Text += probe.Soft ? " softly holds its tissue still.\n" : " holds its tissue still.\n";
    }
    else
    {
      this->Text += (probe.Soft ? " softly " : " ") + probe.Way.ToString(Short);
      const bool isShort = this->Arrived && !probe.Soft && probe.Way.GetShare() < 0.9;
      this->Text += (isShort ? this->WhatHolds(probe, session) : std::string()) + ".\n";
    }
  }
  if (this->Probes.size() > mostNamed)
  {
    this->Text += "And " + std::to_string(this->Probes.size() - mostNamed) + " more probes.\n";
  }
  this->Text += this->Misses + this->AboutBodies(session) + this->Summary;
  this->Written = true;
  return this->Text;
}

std::string Report::AboutBodies(const Session& session) const
{
  if (!session.GetModel().isDivided())
  {
    return {};
  }
  constexpr std::size_t mostNamed = 5;
  const std::vector<chainmail::RigidBody> bodies = session.GetSimulation().bodies();
  std::vector<std::size_t> held;
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    if (bodies[n].limiter.what != chainmail::Limiter::What::Nothing)
    {
      held.push_back(n);
    }
  }
  std::stable_sort(held.begin(), held.end(),
    [&](std::size_t one, std::size_t other) { return bodies[one].elements > bodies[other].elements; });
  std::string text = Grouped(bodies.size()) + (bodies.size() == 1 ? " body" : " bodies") + " of bone, " +
                     (held.empty() ? "none" : Grouped(held.size())) + " held";
  for (std::size_t n = 0; n < held.size() && n < mostNamed; ++n)
  {
    const chainmail::RigidBody& body = bodies[held[n]];
    const vtkIdType label = session.LabelOf(body.voxel);
    text += (n == 0 ? ": " : "; ") +
            (label != 0 ? "label " + std::to_string(label) : "body " + std::to_string(held[n])) + " (" +
            Grouped(body.elements) + " voxels)" + this->Holder(body.limiter);
  }
  return text + (held.size() > mostNamed ? "; and " + Grouped(held.size() - mostNamed) + " smaller ones" : "") + ".\n";
}

std::string Report::WhatHolds(const Probe& probe, const Session& session) const
{
  const chainmail::Limiter limiter = session.GetSimulation().limiter(probe.Held);
  const std::string holder = this->Holder(limiter);
  return holder.empty() ? holder : ": held" + holder + this->AboutJoints(limiter, session);
}

std::string Report::AboutJoints(const chainmail::Limiter& holder, const Session& session) const
{
  const auto nameOf = [&](std::size_t voxel)
  {
    const vtkIdType label = session.LabelOf(voxel);
    if (label != 0)
    {
      return "label " + std::to_string(label);
    }
    const chainmail::Vector3 place = this->Space->VoxelToWorld(session.GetModel().grid().indexOf(voxel));
    return "the bone at " + chainmail::toString(place);
  };
  std::string text;
  for (const auto& [one, other] : holder.joints)
  {
    text += (text.empty() ? " of " : ", of ") + nameOf(one) + " and " + nameOf(other);
  }
  return holder.joints.empty()       ? text
         : holder.joints.size() == 1 ? "; the joint" + text + " is at its limit"
                                     : "; the joints" + text + " are at their limits";
}

std::string Report::Holder(const chainmail::Limiter& holder) const
{
  using What = chainmail::Limiter::What;
  const char* const faces[] = { "x-", "x+", "y-", "y+", "z-", "z+" };
  switch (holder.what)
  {
  case What::Probe:
    return " by Probe " + std::to_string(this->Held[holder.probe] + 1);
  case What::Face:
    return std::string(" by the face ") + faces[holder.face] + " of the scan";
  case What::Rigid:
    return " by anchored bone";
  default:
    return {};
  }
}

}
