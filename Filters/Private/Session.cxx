// SPDX-License-Identifier: BSD-3-Clause
#include "Session.h"

#include "Convert.h"
#include "PartTissue.h"
#include "SpreadImage.h"

#include "Dispatch.h"
#include "Error.h"
#include "Format.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vtkChainMail
{

namespace
{

bool Same(const chainmail::Probe& a, const chainmail::Probe& b)
{
  const auto all = [](const chainmail::Probe& p)
  {
    return std::tie(
      p.position, p.displacement, p.radius, p.anchor, p.tolerance, p.rotates, p.rotation, p.centre, p.body);
  };
  return all(a) == all(b);
}

template <typename T> bool Same(const std::vector<T>& a, const std::vector<T>& b)
{
  return std::equal(
    a.begin(), a.end(), b.begin(), b.end(), [](const T& one, const T& other) { return Same(one, other); });
}

/// What each process makes from its own part of an image.
PartTissue PartOf(const TissueSource& tissue, const SpreadImage& spread)
{
  PartTissue part;
  part.Whole = ExtentOf(spread.GetWhole());
  part.Spacing = tissue.Spacing;
  part.Scalars = spread.IndexOf(tissue.Scalars.Array);
  part.Constraints = tissue.Constraints.Array ? spread.IndexOf(tissue.Constraints.Array) : -1;
  part.Threshold = tissue.Threshold;
  part.HighPadding = tissue.HighPadding;
  part.Function = tissue.Function;
  part.Regions = tissue.Regions;
  part.IsRigidAnchored = tissue.Anchors.rigid;
  return part;
}

/// The numbers of the elements of `present` that are not in `before`. Afterwards `before` has only the elements that
/// were found. Both are multisets: n equal elements match at most n others, in any order.
template <typename T> std::vector<std::size_t> FindNew(const std::vector<T>& present, std::vector<T>& before)
{
  std::vector<std::size_t> added;
  std::vector<T> kept;
  std::vector<bool> gone(before.size(), false);
  std::size_t next = 0; // start of the search: mostly the order is as before
  for (std::size_t n = 0; n < present.size(); ++n)
  {
    std::size_t tried = 0;
    while (tried < before.size() && (gone[next] || !Same(present[n], before[next])))
    {
      ++tried;
      next = (next + 1) % before.size();
    }
    if (tried == before.size())
    {
      added.push_back(n);
      continue;
    }
    kept.push_back(std::move(before[next]));
    gone[next] = true;
  }
  before = std::move(kept);
  return added;
}

/// The first and last voxel along an axis within `radius` of a place; first > last where there is none.
std::pair<int, int> VoxelsAround(const chainmail::Grid& grid, int axis, double place, double radius)
{
  const double end = grid.size[axis] - 1.0;
  const double first = std::clamp(std::ceil((place - radius) / grid.spacing[axis]), 0.0, end + 1.0);
  const double last = std::clamp(std::floor((place + radius) / grid.spacing[axis]), -1.0, end);
  return { static_cast<int>(first), static_cast<int>(last) };
}

/// Whether any voxel in a ball is tissue.
bool HasTissue(const chainmail::Model& model, const Vector3& centre, double radius)
{
  const chainmail::Grid& grid = model.grid();
  const int axes = model.axes();
  const auto [firstZ, lastZ] = VoxelsAround(grid, 2, centre[2], radius);
  for (int k = firstZ; k <= lastZ; ++k)
  {
    const double z = k * grid.spacing[2] - centre[2];
    const auto [firstY, lastY] = VoxelsAround(grid, 1, centre[1], std::sqrt(std::max(radius * radius - z * z, 0.0)));
    for (int j = firstY; j <= lastY; ++j)
    {
      const double y = j * grid.spacing[1] - centre[1];
      const double room = radius * radius - z * z - y * y;
      const auto [firstX, lastX] = VoxelsAround(grid, 0, centre[0], std::sqrt(std::max(room, 0.0)));
      if (room < 0.0 || firstX > lastX)
      {
        continue;
      }
      std::vector<float> row(static_cast<std::size_t>(lastX - firstX + 1) * axes);
      model.row(firstX, j, k, lastX - firstX + 1, row.data());
      for (std::size_t n = 0; n < row.size(); n += axes)
      {
        if (!std::isinf(row[n]))
        {
          return true;
        }
      }
    }
  }
  return false;
}

/// The warning about a carving surface whose parts face different ways; empty where there is none.
std::string AboutParts(const chainmail::SurfaceParts& parts)
{
  std::string text;
  if (parts.mixed > 0 && parts.hollows > 0)
  {
    text = std::to_string(parts.mixed) + " of its " + std::to_string(parts.count) +
           " parts have triangles that face both ways, so their normals do not show which parts are hollows. Parts "
           "inside others are taken as hollows, and the tissue in them stays. Hollows found: ";
  }
  else if (parts.hollows > 0 || parts.reversed > 0)
  {
    text = std::to_string(parts.hollows + parts.reversed) + " of its " + std::to_string(parts.count) +
           " parts have normals opposite to those of the other parts. Parts inside others are hollows, and the tissue "
           "in them stays. Hollows found: ";
  }
  if (text.empty())
  {
    return text;
  }
  return text + std::to_string(parts.hollows) +
         ". All other parts are carved, also where they overlap. To change this, let the normals of hollows point "
         "inwards, and all others outwards (Generate Surface Normals).";
}

}

void Session::Update(const Scene& scene)
{
  this->CutHistory.Begin(scene.Cuts);
  this->CarveHistory.Begin(scene.Carves);
  if (this->Done == Stage::Nothing || !(this->Tissue == scene.Tissue))
  {
    this->Reports.Run(UPLOAD, 0.0, 0.15, [&] { this->Build(scene); });
  }
  this->Tissue = scene.Tissue; // equal values, perhaps in new arrays
  if (scene.Interactive)
  {
    this->Interact(scene);
  }
  else
  {
    this->Deform(scene);
  }
}

void Session::DeleteSimulation()
{
  this->Done = Stage::Nothing;
  this->Interacting = false;
  this->Simulation.reset();
  this->Model.reset();
  this->Tissue = TissueSource();
}

void Session::DeleteAll()
{
  this->DeleteSimulation();
  this->ResetRequested = false;
}

void Session::ResetAfterStop()
{
  try
  {
    if (this->Interacting)
    {
      this->Simulation->reset();
    }
  }
  catch (const chainmail::DeviceError&)
  {
    this->DeleteSimulation();
  }
}

bool Session::IsUnsettled() const
{
  return this->Interacting && (!this->Found.Propagation.finished ||
                                (this->Last.method.relaxationIterations > 0 && !this->Found.Relaxation.converged));
}

void Session::Build(const Scene& scene)
{
  // The old model and simulation are kept until the new ones exist. So an error in the new tissue does not destroy the
  // state.
  const TissueSource& tissue = scene.Tissue;
  SpreadImage* const spread = scene.Given.Spread.get();
  const vtkSmartPointer<vtkDataArray> scalars = ToEngineArray(tissue.Scalars.Array);
  const vtkSmartPointer<vtkDataArray> constraints =
    tissue.Constraints.Array ? ToEngineArray(tissue.Constraints.Array) : nullptr;
  const vtkSmartPointer<vtkDataArray> bodies = tissue.Bodies.Array ? ToEngineArray(tissue.Bodies.Array) : nullptr;
  const auto view = [spread](vtkDataArray* array) { return spread && array ? spread->View(array) : View(array); };

  chainmail::Material material = ToMaterial(tissue.Threshold, tissue.HighPadding, tissue.Function, tissue.Regions);
  material.constraintArray = view(constraints);
  if (spread)
  {
    const PartTissue part = PartOf(tissue, *spread);
    material.count = [spread, part] { return spread->Count(part); };
    material.reduce = [spread, part](const chainmail::Index3& factor)
    {
      PartTissue reduced = part;
      reduced.Factor = factor;
      return spread->Reduce(reduced);
    };
  }
  material.joints.labels = view(bodies);
  material.joints.size = tissue.JointSize;
  material.joints.constraint = tissue.JointConstraint;
  material.joints.margin = tissue.JointMargin;

  const auto model =
    std::make_shared<const chainmail::Model>(tissue.GetGrid(), view(scalars), material, tissue.Anchors);
  if (model->nonFinite() > 0)
  {
    this->Reports.Warn(
      std::to_string(model->nonFinite()) + " voxels of the scalars are NaN or infinite; they are taken as air.");
  }
  if (!scene.Doubt.empty() && scene.Doubt != this->Doubt)
  {
    this->Reports.Warn(scene.Doubt);
  }
  this->WarnAboutRegions(scene, *model);
  this->Reports.Report(0.5);
  std::unique_ptr<chainmail::Simulation> simulation;
  try
  {
    simulation = std::make_unique<chainmail::Simulation>(model, tissue.Settings);
  }
  catch (const chainmail::MemoryError&)
  {
    throw; // the caller drops the old simulation, which frees memory
  }
  catch (const chainmail::DeviceError& error)
  {
    throw chainmail::InputError(error.what()); // for example an unknown device: the old simulation is not affected
  }
  simulation->setProgress([this](double share) { return this->Reports.Show(share); });
  simulation->setCompiling([this] { return this->Reports.ShowCompiling(); });

  this->DeleteSimulation();
  this->Doubt = scene.Doubt;
  this->EngineImage = scene.Given.Spread;
  this->EngineScalars = scalars;
  this->EngineConstraints = constraints;
  this->EngineBodies = bodies;
  this->Labels = material.joints.labels;
  this->Model = model;
  this->Simulation = std::move(simulation);
  ++this->Builds;
  this->AboutProbes.Clear();
  this->Tissue = tissue;
  this->Done = Stage::Built;
}

vtkSmartPointer<vtkDataArray> Session::GetBodyArray() const
{
  vtkDataArray* const array = this->Tissue.Bodies.Array;
  return this->EngineImage && array ? this->EngineImage->Gather(array) : vtkSmartPointer<vtkDataArray>(array);
}

vtkIdType Session::LabelOf(std::size_t voxel) const
{
  if (!this->Labels)
  {
    return 0;
  }
  return chainmail::dispatch(this->Labels,
    [&](const auto* typed) -> vtkIdType
    {
      using T = std::remove_const_t<std::remove_pointer_t<decltype(typed)>>;
      const T label = *chainmail::ArrayRows<T>(this->Labels)(voxel, 1);
      if constexpr (std::is_floating_point<T>::value)
      {
        return std::fabs(label) <= T(9e18) ? static_cast<vtkIdType>(label) : 0; // false for NaN
      }
      return static_cast<vtkIdType>(label);
    });
}

/// Warns about regions without tissue, each once until it has tissue.
void Session::WarnAboutRegions(const Scene& scene, const chainmail::Model& model)
{
  std::set<std::string> empty;
  const std::vector<double>& regions = scene.Tissue.Regions;
  for (std::size_t n = 0; 5 * n < regions.size(); ++n)
  {
    const double* r = regions.data() + 5 * n;
    if (HasTissue(model, { { r[0], r[1], r[2] } }, r[3]))
    {
      continue;
    }
    const std::string& name = scene.RegionNames[n];
    if (this->EmptyRegions.count(name) == 0)
    {
      this->Reports.Warn(name + ": no tissue is within the region's radius of " + chainmail::toString(r[3]) +
                         " mm, so it changes nothing. Move it into tissue, enlarge it, or disconnect it.");
    }
    empty.insert(name);
  }
  this->EmptyRegions = std::move(empty);
}

void Session::Deform(const Scene& scene)
{
  this->Interacting = false;
  this->ResetRequested = false;
  if (this->Done > Stage::Built && !(Same(this->Cuts, scene.Cuts) && Same(this->Carves, scene.Carves)))
  {
    this->Done = Stage::Built;
  }
  if (this->Done > Stage::Cut && (!Same(this->Last.probes, scene.Probes) || this->Last.method != scene.How ||
                                   (scene.Properties.PropagationTimes && !this->Last.propagationTimes)))
  {
    this->Done = Stage::Cut;
  }

  if (this->Done < Stage::Cut)
  {
    this->Reports.Run(PROPAGATE, 0.15, 0.2,
      [&]
      {
        this->RestoreTopology();
        std::for_each(scene.Cuts.begin(), scene.Cuts.end(), [&](const InputSurface& one) { this->Cut(one); });
        std::for_each(scene.Carves.begin(), scene.Carves.end(), [&](const InputSurface& one) { this->Carve(one); });
      });
    this->Done = Stage::Cut;
  }

  if (this->Done < Stage::Relaxed)
  {
    std::vector<std::size_t> all(scene.Probes.size());
    std::iota(all.begin(), all.end(), 0);
    this->Simulate(scene, all, true);
    this->Done = Stage::Relaxed;
  }
}

/// Continues the interactive state, or begins one at rest. Each surface is applied once. A reset makes the connected
/// surfaces and probes ineffective until they change.
void Session::Interact(const Scene& scene)
{
  this->Done = Stage::Built;
  const bool startsAnew = !this->Interacting || !(*this->Space == scene.Space);
  if (startsAnew || this->ResetRequested)
  {
    this->RestoreTopology();
    this->Released.clear();
    this->AboutProbes.Clear();
    this->Space = std::make_unique<Frame>(scene.Space);
    this->Interacting = true;
  }
  if (this->ResetRequested)
  {
    this->Cuts = scene.Cuts;
    this->Carves = scene.Carves;
    std::for_each(this->Cuts.begin(), this->Cuts.end(), [&](const auto& one) { this->CutHistory.Remember(one); });
    std::for_each(this->Carves.begin(), this->Carves.end(), [&](const auto& one) { this->CarveHistory.Remember(one); });
    this->Released = scene.Probes;
    this->ResetRequested = false;
  }

  this->Reports.Run(PROPAGATE, 0.15, 0.2,
    [&]
    {
      for (const std::size_t n : FindNew(scene.Cuts, this->Cuts))
      {
        this->Cut(scene.Cuts[n]);
      }
      for (const std::size_t n : FindNew(scene.Carves, this->Carves))
      {
        this->Carve(scene.Carves[n]);
      }
    });
  // All probes are held, except those that a reset released and that have not changed since.
  this->Simulate(scene, FindNew(scene.Probes, this->Released), false);
}

void Session::RestoreTopology()
{
  this->Simulation->restoreTopology();
  this->Cuts.clear();
  this->Carves.clear();
  this->CutHistory.Rest();
  this->CarveHistory.Rest();
  ++this->TissueChanges;
  ++this->LinkChanges;
  this->HasCut = false;
}

void Session::Cut(const InputSurface& surface)
{
  const std::size_t links = this->Simulation->cut(surface.Triangles);
  if (links > 0)
  {
    ++this->LinkChanges;
    this->HasCut = true;
  }
  this->Cuts.push_back(surface);
  this->Reports.Warn(this->CutHistory.About(surface, surface.Flaw));
  this->Reports.Warn(this->CutHistory.Worked(surface, links));
}

void Session::Carve(const InputSurface& surface)
{
  std::size_t elements = 0;
  chainmail::SurfaceParts parts;
  try
  {
    elements = this->Simulation->carve(surface.Triangles, &parts);
    if (elements > 0)
    {
      ++this->TissueChanges;
      ++this->LinkChanges;
      this->HasCut = true;
    }
  }
  catch (const chainmail::InputError& error)
  {
    throw chainmail::InputError(surface.Name + ": " + error.what());
  }
  this->Carves.push_back(surface);
  this->Reports.Warn(this->CarveHistory.About(surface, surface.Flaw.empty() ? AboutParts(parts) : surface.Flaw));
  this->Reports.Warn(this->CarveHistory.Worked(surface, elements));
}

/// Holds exactly the probes with these numbers, lets tissue follow them, and relaxes it.
void Session::Simulate(const Scene& scene, const std::vector<std::size_t>& held, bool fromRest)
{
  this->Last = { fromRest, scene.How, scene.Properties.PropagationTimes, {} };
  for (const std::size_t p : held)
  {
    this->Last.probes.push_back(scene.Probes[p]);
  }
  const auto begins = [this](chainmail::UpdatePart part)
  {
    switch (part)
    {
    case chainmail::UpdatePart::Propagate:
      return this->Reports.BeginPart(PROPAGATE, 0.2, 0.45);
    case chainmail::UpdatePart::Relax:
      return this->Reports.BeginPart(RELAX, 0.45, 0.75);
    default:
      return this->Reports.BeginPart(DOWNLOAD, 0.75, 0.75);
    }
  };
  chainmail::UpdateResult found;
  try
  {
    found = this->Simulation->update(this->Last, begins);
  }
  catch (const chainmail::ProbeError& error)
  {
    // The message has to name the probe of the scene, in world axes.
    throw chainmail::InputError(scene.NameOf(held[error.probe]) + ": the probe " + error.problem);
  }
  this->Reports.EndPart();
  this->Found = { std::vector<chainmail::ProbeResult>(scene.Probes.size()), held, found.propagation, found.relaxation,
    found.statistics };
  for (std::size_t n = 0; n < held.size(); ++n)
  {
    this->Found.Probes[held[n]] = found.probes[n];
  }
  this->Warn(scene, held);
}

void Session::Warn(const Scene& scene, const std::vector<std::size_t>& held)
{
  if (!ProbeWarnings::AreOn)
  {
    return;
  }
  this->Reports.Warn(this->AboutProbes.OfEmptyHandles(scene, held, this->Found.Probes));
  this->Reports.Warn(this->AboutProbes.OfSharing(scene.How, held, this->Found.Propagation));
  if (this->Found.Propagation.finished) // before that, probes may still reach their targets
  {
    this->Reports.Warn(this->AboutProbes.OfShortProbes(scene, held, this->Found.Probes, *this->Simulation));
  }
}

}
