// SPDX-License-Identifier: BSD-3-Clause
// Makes a text about what an update did.

#ifndef Report_h
#define Report_h

#include "Frame.h"
#include "HowFar.h"
#include "Scene.h"
#include "Session.h"

#include <optional>
#include <string>
#include <vector>

class vtkFieldData;

namespace vtkChainMail
{

class Report
{
public:
  /// Takes the results of an update of this scene. `fields`: the field data of the outputs.
  void Set(const Scene& scene, const Session& session, vtkFieldData* fields);

  /// The same after an update that failed or was stopped.
  void Set(const std::string& problem);

  /// The report, a line for each sentence. The search for what holds a probe is slow, so it is done here, when
  /// requested.
  const std::string& Get(const Session& session);

private:
  struct Probe
  {
    std::size_t Held = 0; ///< its number in the simulation
    HowFar Way;
    bool Anchor = false;
    bool Soft = false;
    bool Empty = false;
    bool Present = false; ///< whether the simulation holds it
  };

  /// The number of rigid bodies and which of them are held.
  std::string AboutBodies(const Session& session) const;

  /// What holds a probe back, as the end of a sentence.
  std::string WhatHolds(const Probe& probe, const Session& session) const;

  /// What the holder is, as the end of a sentence.
  std::string Holder(const chainmail::Limiter& holder) const;

  /// The joints between probe and holder that are at their limits, as the end of a sentence.
  std::string AboutJoints(const chainmail::Limiter& holder, const Session& session) const;

  std::optional<Frame> Space;
  std::vector<Probe> Probes;
  std::vector<std::size_t> Held; ///< for each probe in the simulation, its number in the scene
  bool Arrived = false;          ///< whether all waves have ended
  bool Settles = true;           ///< whether there is any relaxation
  std::string Misses;            ///< the surfaces that removed nothing, a line for each
  std::string Summary;
  std::string Text;
  bool Written = true;
};

}

#endif
