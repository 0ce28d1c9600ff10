// SPDX-License-Identifier: BSD-3-Clause
// Keeps the engine's model and simulation from update to update, and decides what is computed anew.

#ifndef Session_h
#define Session_h

#include "ProbeWarnings.h"
#include "Progress.h"
#include "Scene.h"
#include "SurfaceHistory.h"

#include "Model.h"
#include "Simulation.h"

#include <memory>
#include <set>
#include <string>
#include <vector>

namespace vtkChainMail
{

/// The results of an update. Those of probes are in the order of the scene's probes.
struct Findings
{
  std::vector<chainmail::ProbeResult> Probes;
  std::vector<std::size_t> Held; ///< the numbers of the probes that the simulation holds, in its order
  chainmail::PropagateResult Propagation;
  chainmail::RelaxResult Relaxation;
  chainmail::Statistics Statistics;
};

/// Keeps the engine in step with scenes. Its functions throw the engine's exceptions. Not for several threads.
class Session
{
public:
  explicit Session(Progress& reports)
    : Reports(reports)
  {
  }

  /// Brings the engine to a scene: from rest, or on from the last interactive update, as the scene says.
  void Update(const Scene& scene);

  /// Forgets the model and the simulation: after an error of the device nothing on it can be trusted.
  void Drop();

  /// To be called after an update that was stopped. Where it stopped is chance, so tissue goes back to rest.
  void Stop();

  /// Forgets everything, since another process computes from now on.
  void Leave();

  /// Makes the next interactive update begin with all tissue at rest and whole.
  void RequestReset() { this->ResetRequested = true; }

  /// Whether there is a state that interactive updates go on from.
  bool IsInteracting() const { return this->Interacting; }

  /// Whether the last update was interactive and left waves under way or tissue that has not settled.
  bool IsUnsettled() const;

  // For the outputs, after an update.
  const TissueSource& GetTissue() const { return this->Tissue; }
  vtkDataArray* GetEngineScalars() const { return this->EngineScalars; }
  const chainmail::Model& GetModel() const { return *this->Model; }
  chainmail::Simulation& GetSimulation() const { return *this->Simulation; }
  const Findings& GetFindings() const { return this->Found; }
  const SurfaceHistory& GetCutHistory() const { return this->CutHistory; }
  const SurfaceHistory& GetCarveHistory() const { return this->CarveHistory; }
  /// How often the model and the simulation were made.
  int GetBuilds() const { return this->Builds; }
  /// How often elements came or went, and how often links did. With either, rigid clusters may change.
  int GetTissueChanges() const { return this->TissueChanges; }
  int GetLinkChanges() const { return this->LinkChanges; }
  /// Whether links or elements were taken away.
  bool IsCut() const { return this->HasCut; }

private:
  void Build(const Scene& scene);
  void Deform(const Scene& scene);
  void Interact(const Scene& scene);
  void Mend();
  void Cut(const InputSurface& surface);
  void Carve(const InputSurface& surface);
  void Pull(const Scene& scene, const std::vector<std::size_t>& held);
  void Relax(const Scene& scene, const std::vector<std::size_t>& held);
  void Warn(const Scene& scene, const std::vector<std::size_t>& held);
  void WarnAboutRegions(const Scene& scene, const chainmail::Model& model);

  Progress& Reports;

  // How far the engine has come from nothing to the state deformed from rest. It is lowered before the engine does
  // something that may fail, and raised afterwards. During an interactive state it is Built.
  enum class Stage
  {
    Nothing,
    Built,
    Cut,
    Relaxed
  };
  Stage Done = Stage::Nothing;
  bool Interacting = false;
  bool ResetRequested = false;

  TissueSource Tissue;
  vtkSmartPointer<vtkDataArray> EngineScalars; // read by the model as long as that lives
  vtkSmartPointer<vtkDataArray> EngineConstraints;
  std::shared_ptr<const chainmail::Model> Model;
  std::unique_ptr<chainmail::Simulation> Simulation;

  // The surfaces with which the stages Cut and Relaxed were reached. In an interactive state: those of the last
  // update's surfaces that have done their work.
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;
  std::vector<chainmail::Probe> Probes;
  Method MethodUsed;
  bool TimesKept = false;

  // In an interactive state: where the image was, and probes that are still connected but were released by a reset.
  std::unique_ptr<Frame> Space;
  std::vector<chainmail::Probe> Released;

  // Warnings that were given.
  std::string Doubt;
  ProbeWarnings AboutProbes;
  SurfaceHistory CutHistory;
  SurfaceHistory CarveHistory;
  std::set<std::string> EmptyRegions; // names of those that are there

  Findings Found;
  int Builds = 0;
  int TissueChanges = 0;
  int LinkChanges = 0;
  bool HasCut = false;
};

}

#endif
