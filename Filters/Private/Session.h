// SPDX-License-Identifier: BSD-3-Clause
// Keeps the engine's model and simulation from update to update, and decides what has to be computed again.

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
struct Results
{
  std::vector<chainmail::ProbeResult> Probes;
  std::vector<std::size_t> Held; ///< the numbers of the probes that the simulation holds, in its order
  chainmail::PropagateResult Propagation;
  chainmail::RelaxResult Relaxation;
  chainmail::Statistics Statistics;
};

/// Updates the engine to a scene. Its functions throw the engine's exceptions. Not thread-safe.
class Session
{
public:
  explicit Session(Progress& reports)
    : Reports(reports)
  {
  }

  /// Deforms as the scene says: from rest, or continuing from the last interactive update.
  void Update(const Scene& scene);

  /// Deletes the model and the simulation: after a device error the state on the device cannot be trusted.
  void DeleteSimulation();

  /// To be called after an update that was stopped, at an arbitrary point. An interactive state is reset to rest. Other
  /// updates begin again with the stage that was not completed.
  void ResetAfterStop();

  /// Deletes the model and the simulation and forgets a requested reset, because another process computes from now on.
  void DeleteAll();

  /// Makes the next interactive update begin at rest, without cuts and carves.
  void RequestReset() { this->ResetRequested = true; }

  /// Whether there is a state from which interactive updates continue.
  bool IsInteracting() const { return this->Interacting; }

  /// Whether the last update was interactive and left waves under way, or a relaxation that has not converged.
  bool IsUnsettled() const;

  // For the outputs, after an update.
  const TissueSource& GetTissue() const { return this->Tissue; }
  vtkDataArray* GetEngineScalars() const { return this->EngineScalars; }
  /// The BodyArray for all voxels; null where there are no joints, or none by labels.
  vtkSmartPointer<vtkDataArray> GetBodyArray() const;
  /// A label of it, as an exact integer. 0 where the value is none, or without such an array.
  vtkIdType LabelOf(std::size_t voxel) const;
  bool HasModel() const { return this->Model != nullptr; }
  const chainmail::Model& GetModel() const { return *this->Model; }
  chainmail::Simulation& GetSimulation() const { return *this->Simulation; }
  const Results& GetResults() const { return this->Found; }
  const SurfaceHistory& GetCutHistory() const { return this->CutHistory; }
  const SurfaceHistory& GetCarveHistory() const { return this->CarveHistory; }
  /// How often the model and the simulation were made.
  int GetBuilds() const { return this->Builds; }
  /// How often the set of elements changed, and how often the set of links. Either may change rigid clusters.
  int GetTissueChanges() const { return this->TissueChanges; }
  int GetLinkChanges() const { return this->LinkChanges; }
  /// Whether links or elements were removed.
  bool IsCut() const { return this->HasCut; }

private:
  void Build(const Scene& scene);
  void Deform(const Scene& scene);
  void Interact(const Scene& scene);
  void RestoreTopology();
  void Cut(const InputSurface& surface);
  void Carve(const InputSurface& surface);
  void Simulate(const Scene& scene, const std::vector<std::size_t>& held, bool fromRest);
  void Warn(const Scene& scene, const std::vector<std::size_t>& held);
  void WarnAboutRegions(const Scene& scene, const chainmail::Model& model);

  Progress& Reports;

  // The last stage that is complete in computing from rest. It is lowered before an engine call that may fail, and
  // raised afterwards. In an interactive state it is Built.
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
  std::shared_ptr<SpreadImage> EngineImage;    // the model reads from it during its lifetime
  vtkSmartPointer<vtkDataArray> EngineScalars; // or the memory of these three
  vtkSmartPointer<vtkDataArray> EngineConstraints;
  vtkSmartPointer<vtkDataArray> EngineBodies;
  chainmail::ArrayView Labels; // EngineBodies
  std::shared_ptr<const chainmail::Model> Model;
  std::unique_ptr<chainmail::Simulation> Simulation;

  // The surfaces of the stages Cut and Relaxed. In an interactive state: the connected surfaces that are not to be
  // applied (again), because they have been applied or were connected at a reset.
  std::vector<InputSurface> Cuts;
  std::vector<InputSurface> Carves;
  chainmail::Update Last; // what the engine was given last

  // In an interactive state: the geometry of the image, and the probes that are still connected but were released by a
  // reset.
  std::unique_ptr<Frame> Space;
  std::vector<chainmail::Probe> Released;

  // What was already warned about.
  std::string Doubt;
  ProbeWarnings AboutProbes;
  SurfaceHistory CutHistory;
  SurfaceHistory CarveHistory;
  std::set<std::string> EmptyRegions; // names of the present regions without tissue

  Results Found;
  int Builds = 0;
  int TissueChanges = 0;
  int LinkChanges = 0;
  bool HasCut = false;
};

}

#endif
