// SPDX-License-Identifier: BSD-3-Clause
// Says in words what an update did.

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
  /// After an update: what the scene asked for and what came of it; `fields` are those of the outputs.
  void Set(const Scene& scene, const Session& session, vtkFieldData* fields);

  /// After an update that failed or was stopped.
  void Set(const std::string& problem);

  /// The report, a line for each sentence. What holds a probe takes a search, which waits until somebody asks.
  const std::string& Get(const Session& session);

private:
  struct Probe
  {
    std::size_t Held = 0; ///< the number by which the simulation knows it
    HowFar Way;
    bool Anchor = false;
    bool Soft = false;
    bool Empty = false;
    bool Present = false; ///< whether the simulation holds it
  };

  /// How many bodies of bone there are and which are held.
  std::string AboutBodies(const Session& session) const;

  /// What keeps a probe from going further, as the end of a sentence.
  std::string WhatHolds(const Probe& probe, const Session& session) const;

  /// By what it is held, as the end of a sentence.
  std::string Holder(const chainmail::HeldBy& holder) const;

  /// The joints between that are at their limits, as the end of a sentence.
  std::string AboutJoints(const chainmail::HeldBy& holder, const Session& session) const;

  std::optional<Frame> Space;
  std::vector<Probe> Probes;
  std::vector<std::size_t> Held; ///< for each that the simulation holds, its number among all
  bool Arrived = false;          ///< whether all waves have come to their ends
  bool Settles = true;           ///< whether tissue settles at all
  std::string Misses;            ///< the surfaces that removed nothing, a line for each
  std::string Summary;
  std::string Text;
  bool Written = true;
};

}

#endif
