// SPDX-License-Identifier: BSD-3-Clause
// The engine's model and simulation from update to update: what has to be done anew, and what goes on.

#ifndef Session_h
#define Session_h

#include "ProbeWarnings.h"
#include "Progress.h"
#include "Scene.h"
#include "SurfaceHistory.h"

#include "Model.h"
#include "Simulation.h"

#include <memory>
#include <vector>

namespace vtkChainMail
{

/// What an update found. The results of probes are those of the scene's, in their order.
struct Findings
{
  std::vector<chainmail::ProbeResult> Probes;
  chainmail::PropagateResult Propagation;
  chainmail::RelaxResult Relaxation;
  chainmail::Statistics Statistics;
};

/// Keeps the engine in step with scenes. Throws the engine's exceptions.
class Session
{
public:
  explicit Session(Progress& reports)
    : Reports(reports)
  {
  }

  /// From rest, or on from where the last interactive update was, as the scene says.
  void Update(const Scene& scene);

  /// After an error of the device nothing on it can be trusted.
  void Drop();

  /// After an update that was stopped. Where it was stopped is a matter of chance, where the next one goes on is not.
  void Stop();

  /// Another process computes from now on.
  void Leave();

  /// The next interactive update begins with all tissue at rest and whole.
  void RequestReset() { this->ResetRequested = true; }

  /// There is a state that interactive updates go on from.
  bool IsInteracting() const { return this->Interacting; }

  /// The last update was an interactive one, and left waves under way or tissue that has not settled.
  bool IsUnsettled() const;

  // For the outputs, after an update.
  const TissueSource& GetTissue() const { return this->Tissue; }
  vtkDataArray* GetEngineScalars() const { return this->EngineScalars; }
  const chainmail::Model& GetModel() const { return *this->Model; }
  chainmail::Simulation& GetSimulation() const { return *this->Simulation; }
  const Findings& GetFindings() const { return this->Found; }
  /// Count how often elements came or went, and how often links did: with them rigid clusters may be others.
  int GetTissueChanges() const { return this->TissueChanges; }
  int GetLinkChanges() const { return this->LinkChanges; }

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

  Progress& Reports;

  // How far the engine is on its way from nothing to the state deformed from rest. Lowered before it is told to do
  // something that may fail, raised after it has. An interactive state is none of these: it leaves Built.
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
  vtkSmartPointer<vtkDataArray> EngineScalars; // read by the model as long as it lives
  vtkSmartPointer<vtkDataArray> EngineConstraints;
  std::shared_ptr<const chainmail::Model> Model;
  std::unique_ptr<chainmail::Simulation> Simulation;

  // What the stages Cut and Relaxed were reached with. Of an interactive state: the surfaces that the last update had
  // and that have done their work.
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;
  std::vector<chainmail::Probe> Probes;
  Method MethodUsed;
  bool TimesKept = false;

  // Of an interactive state: where the image was, and probes that are there but were released by a reset.
  std::unique_ptr<Frame> Space;
  std::vector<chainmail::Probe> Released;

  // What was warned about.
  ProbeWarnings AboutProbes;
  SurfaceHistory CutHistory;
  SurfaceHistory CarveHistory;

  Findings Found;
  int TissueChanges = 0;
  int LinkChanges = 0;
};

}

#endif
