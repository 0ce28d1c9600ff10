// SPDX-License-Identifier: BSD-3-Clause
#include "Outputs.h"

#include "Arrays.h"
#include "CarryCells.h"
#include "Threads.h"

#include "vtkCellData.h"
#include "vtkDataArraySelection.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStringArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace vtkChainMail
{

namespace
{

/// Calls f(first, end) for portions of the voxels, from several threads.
template <typename F> void ForPortions(vtkIdType voxels, const F& f)
{
  constexpr vtkIdType portion = vtkIdType(1) << 16;
  chainmail::inParallel(static_cast<std::size_t>((voxels + portion - 1) / portion),
    [&](std::size_t n)
    {
      const vtkIdType first = static_cast<vtkIdType>(n) * portion;
      f(first, std::min(first + portion, voxels));
    });
}

}

const std::array<const char*, 4> Outputs::ModelArrays = { "Displacement", "Element", "Constraint", "Cluster" };

void Outputs::RemoveFigures(vtkFieldData* fields)
{
  for (const char* name : { "ProbeReached", "ProbeForce", "ProbeTurned", "ProbeTorque", "Energy", "MaxLinkExcess",
         "PropagationIterationsUsed", "RelaxationIterationsUsed", "CoarseToFineStep", "DisplacedElements",
         "Milliseconds", "PeakDeviceMemory", "DeviceName", "BodyVoxels", "BodyHeldBy", "BodyLabel", "Error" })
  {
    fields->RemoveArray(name);
  }
}

bool Outputs::IsDefault(const std::string& modelArray)
{
  return modelArray == "Displacement" || modelArray == "Element";
}

std::array<vtkSmartPointer<vtkImageData>, 2> Outputs::Write(const Scene& scene)
{
  const auto deformed = vtkSmartPointer<vtkImageData>::New();
  const auto model = vtkSmartPointer<vtkImageData>::New();
  this->Space = scene.Space;
  this->Reports.Run(RESAMPLE, 0.75, 0.9, [&] { this->WriteDeformed(scene, deformed); });
  this->WriteModel(scene, model);
  const double peak = 1e-6 * static_cast<double>(this->Source.GetSimulation().takePeakDeviceBytes());
  this->WriteFieldData(scene, peak, deformed);
  this->WriteFieldData(scene, peak, model);
  return { { deformed, model } };
}

bool Outputs::Sampled::operator==(const Sampled& other) const
{
  const auto all = [](const Sampled& s)
  { return std::tie(s.Array, s.Numbers, s.Time, s.G, s.Nearest, s.Still, s.SmoothCuts, s.Builds); };
  const bool sameBackground =
    this->Background == other.Background || (std::isnan(this->Background) && std::isnan(other.Background));
  return all(*this) == all(other) && sameBackground && this->NotMeasured == other.NotMeasured;
}

/// Reuses samplers of the last update where nothing changed apart from the deformation.
void Outputs::ChooseSamplers(const Scene& scene)
{
  // The same test as that of the model, which only one thread at a time may use.
  const double threshold = scene.Tissue.Threshold;
  const double ceiling = scene.Tissue.HighPadding;
  vtkDataArray* engineScalars = this->Source.GetEngineScalars();
  const auto isTissue = [engineScalars, threshold, ceiling](vtkIdType voxel)
  {
    const double scalar = engineScalars->GetComponent(voxel, 0);
    return std::isfinite(scalar) && scalar >= threshold && scalar < ceiling;
  };
  const Grids grids(scene.Tissue.Size, scene.Output.Padding, scene.Output.Detail);
  const std::vector<Sampled> before = std::move(this->Samplers);
  this->Samplers.clear();
  std::unique_ptr<SmoothScalars> smoothedBefore = std::move(this->Smoothed);
  vtkPointData* arrays = scene.Image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    const std::string name = array->GetName() ? array->GetName() : "";
    const bool isLabel = std::find(scene.LabelArrays.begin(), scene.LabelArrays.end(), name) != scene.LabelArrays.end();
    Sampled one(grids);
    one.Array = array;
    if (auto* numbers = vtkDataArray::SafeDownCast(array))
    {
      // ParaView passes an image that was just modified in every update, but with the same arrays.
      const auto same = std::find_if(before.begin(), before.end(), [&](const Sampled& s) { return s.Array == array; });
      one.Numbers.Take(numbers, scene.Image->GetMTime(),
        array == scene.Scalars ? scene.Tissue.Scalars
        : same != before.end() ? same->Numbers
                               : ArrayContents());
    }
    else
    {
      one.Time = std::max(array->GetMTime(), scene.Image->GetMTime());
    }
    one.Nearest = scene.Properties.Interpolation == InterpolationTypes::Nearest || isLabel ||
                  (array == scene.Scalars && scene.AreLabels) || array == arrays->GetGlobalIds() ||
                  array == arrays->GetPedigreeIds();
    one.Still = name == vtkDataSetAttributes::GhostArrayName();
    if (array == scene.Scalars)
    {
      one.Background = scene.BackgroundValue;
      one.NotMeasured = { scene.LowPadding, scene.Tissue.HighPadding };
    }
    one.SmoothCuts = scene.Properties.SmoothCuts;
    one.Builds = this->Source.GetBuilds();
    const auto same = std::find(before.begin(), before.end(), one);
    if (same != before.end())
    {
      one.Sampler = same->Sampler;
    }
    else if (one.Still)
    {
      one.Sampler = std::make_shared<StillArray>(array, grids);
    }
    else
    {
      one.Sampler = MakeSampler(array, grids, one.Nearest, one.Background, one.NotMeasured, isTissue);
    }
    this->Samplers.push_back(one);
    if (array == scene.Scalars && scene.Properties.ScalarSmoothing > 0.0 && array->GetDataType() != VTK_BIT)
    {
      // With deviation 0 the array still exists where values are labels, so a view of it keeps something to show.
      const double deviation = one.Nearest ? 0.0 : scene.Properties.ScalarSmoothing;
      const bool goesOn = smoothedBefore && smoothedBefore->IsFor(one.Sampler, deviation);
      this->Smoothed = goesOn ? std::move(smoothedBefore)
                              : std::make_unique<SmoothScalars>(one.Sampler, grids, deviation, one.NotMeasured);
    }
  }
  if (!scene.Properties.PullBack)
  {
    this->PullBack.reset();
  }
  else if (!this->PullBack ||
           !this->PullBack->IsFor(grids, scene.Space, scene.Properties.SmoothCuts, this->Source.GetBuilds()))
  {
    this->PullBack =
      std::make_unique<PullBackSampler>(grids, scene.Space, scene.Properties.SmoothCuts, this->Source.GetBuilds());
  }
}

void Outputs::WriteDeformed(const Scene& scene, vtkImageData* output)
{
  const Grids grids(scene.Tissue.Size, scene.Output.Padding, scene.Output.Detail);
  output->SetOrigin(scene.Image->GetOrigin());
  output->SetSpacing(scene.Output.SpacingOf(scene.Image).data());
  output->SetDirectionMatrix(scene.Image->GetDirectionMatrix());
  output->SetExtent(scene.Output.ExtentOf(scene.Image).data());
  this->ChooseSamplers(scene);
  std::vector<ArraySampler*> samplers;
  for (const Sampled& one : this->Samplers)
  {
    samplers.push_back(one.Sampler.get());
  }
  if (this->PullBack)
  {
    samplers.push_back(this->PullBack.get());
  }
  if (this->Smoothed)
  {
    samplers.push_back(this->Smoothed.get());
  }
  std::uint64_t since = std::numeric_limits<std::uint64_t>::max();
  for (ArraySampler* one : samplers)
  {
    since = std::min(since, one->Begin());
  }
  const chainmail::Resampled resampled = this->Source.GetSimulation().resample(
    scene.Output.Padding,
    [&](const std::vector<chainmail::ResampledBox>& boxes)
    {
      for (ArraySampler* one : samplers)
      {
        one->Sample(boxes);
      }
    },
    since, scene.Properties.SmoothCuts ? chainmail::CutSurfaces::Smooth : chainmail::CutSurfaces::Stepped,
    scene.Output.Detail);

  this->WarnAboutLostArrays(scene.Image);
  if (vtkAbstractArray* ghosts = scene.Image->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()))
  {
    StillArray still(ghosts, grids.Cells());
    still.Begin();
    output->GetCellData()->AddArray(still.End(resampled.number, resampled.atRest));
  }
  for (const Sampled& one : this->Samplers)
  {
    const vtkSmartPointer<vtkAbstractArray> array = one.Sampler->End(resampled.number, resampled.atRest);
    output->GetPointData()->AddArray(array);
    if (this->Smoothed && one.Array == scene.Scalars)
    {
      this->Smoothed->SetSampled(vtkDataArray::SafeDownCast(array));
    }
  }
  CopyActiveAttributes(scene.Image->GetPointData(), output->GetPointData());
  if (this->PullBack) // replaces an input array of that name, which belongs to another deformation
  {
    output->GetPointData()->AddArray(this->PullBack->End(resampled.number, resampled.atRest));
  }
  if (this->Smoothed) // likewise
  {
    output->GetPointData()->AddArray(this->Smoothed->End(resampled.number, resampled.atRest));
  }
}

void Outputs::WriteModel(const Scene& scene, vtkImageData* output)
{
  output->CopyStructure(scene.Image);
  this->ChooseModelArrays(scene.Properties.ModelArrays, output);
  if (scene.Properties.PropagationTimes)
  {
    this->Reports.Run(DOWNLOAD, 0.98, 1.0, [&] { this->FetchTimes(scene, output->GetPointData()); });
  }
}

void Outputs::ChooseModelArrays(vtkDataArraySelection* chosen, vtkImageData* model)
{
  vtkPointData* arrays = model->GetPointData();
  const vtkIdType voxels = model->GetNumberOfPoints();
  const auto wants = [&](const char* name) { return chosen->ArrayIsEnabled(name) != 0; };
  const auto share = [&](const char* name, bool isWanted, auto& shared, int version, auto&& fetch)
  {
    if (!isWanted)
    {
      shared.Forget();
      arrays->RemoveArray(name);
    }
    else if (!arrays->HasArray(name))
    {
      if (!shared.IsIntact(version))
      {
        this->Reports.Run(DOWNLOAD, 0.9, 0.95, [&] { shared.Set(fetch(), version); });
      }
      arrays->AddArray(shared.Get());
    }
  };
  if (!wants("Displacement"))
  {
    arrays->RemoveArray("Displacement");
  }
  else if (!arrays->HasArray("Displacement"))
  {
    this->Reports.Run(DOWNLOAD, 0.9, 0.98, [&] { arrays->SetVectors(this->FetchDisplacement(voxels)); });
  }
  const int ofTissue = this->Source.GetTissueChanges();
  const int ofLinks = this->Source.GetLinkChanges();
  share("Element", wants("Element"), this->Element, ofTissue, [&] { return this->FetchElement(voxels); });
  // Links tell to which side of a cut a displacement belongs.
  share("Links", wants("Displacement") && this->Source.IsCut(), this->Links, ofLinks,
    [&] { return this->FetchLinks(voxels); });
  share("Constraint", wants("Constraint"), this->Constraint, ofTissue, [&] { return this->FetchConstraint(voxels); });
  share("Cluster", wants("Cluster"), this->Cluster, ofLinks, [&] { return this->FetchCluster(voxels); });
  // Writers of a single array, such as that of MetaImage, write the active scalars.
  const char* const most = wants("Displacement") ? "Displacement" : "Element";
  if (wants(most))
  {
    arrays->SetActiveScalars(most);
  }
}

void Outputs::WriteFieldData(const Scene& scene, double peakMegabytes, vtkImageData* output)
{
  const Results& found = this->Source.GetResults();
  vtkFieldData* fields = output->GetFieldData();
  fields->ShallowCopy(scene.Image->GetFieldData());
  RemoveFigures(fields);

  const vtkIdType numberOfProbes = static_cast<vtkIdType>(found.Probes.size());
  using Convert = void (Frame::*)(const double*, double*) const;
  const auto addVectors =
    [&](const char* name, Vector3 chainmail::ProbeResult::*member, Convert convert, double unit = 1.0)
  {
    vtkNew<vtkDoubleArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(numberOfProbes);
    for (vtkIdType p = 0; p < numberOfProbes; ++p)
    {
      double world[3];
      (scene.Space.*convert)((found.Probes[p].*member).data(), world);
      array->SetTuple3(p, unit * world[0], unit * world[1], unit * world[2]);
    }
    fields->AddArray(array);
  };
  const auto addRow = [&](vtkDataArray* array, const char* name, const std::vector<double>& row)
  {
    array->SetName(name);
    array->SetNumberOfComponents(static_cast<int>(row.size()));
    array->InsertNextTuple(row.data());
    fields->AddArray(array);
  };
  addRow(vtkNew<vtkDoubleArray>(), "Energy", { found.Statistics.energy });
  addRow(vtkNew<vtkDoubleArray>(), "MaxLinkExcess", { found.Statistics.maxLinkExcess });
  addRow(vtkNew<vtkIntArray>(), "PropagationIterationsUsed", { static_cast<double>(found.Propagation.iterations) });
  addRow(vtkNew<vtkIntArray>(), "RelaxationIterationsUsed", { static_cast<double>(found.Relaxation.iterations) });
  addRow(vtkNew<vtkDoubleArray>(), "CoarseToFineStep", { found.Relaxation.coarseStep.value_or(-1.0) });
  addRow(vtkNew<vtkIdTypeArray>(), "DisplacedElements", { static_cast<double>(found.Statistics.displaced) });
  vtkNew<vtkDoubleArray> milliseconds;
  addRow(
    milliseconds, "Milliseconds", { this->Reports.GetMilliseconds().begin(), this->Reports.GetMilliseconds().end() });
  const char* const times[NUMBER_OF_TIMES] = { "upload", "propagate", "relax", "resample", "download" };
  for (int t = 0; t < NUMBER_OF_TIMES; ++t)
  {
    milliseconds->SetComponentName(t, times[t]);
  }

  addRow(vtkNew<vtkDoubleArray>(), "PeakDeviceMemory", { peakMegabytes });
  if (this->Source.GetModel().isDivided())
  {
    this->AddBodies(fields);
  }

  vtkNew<vtkStringArray> device;
  device->SetName("DeviceName");
  device->InsertNextValue(this->Source.GetSimulation().deviceName());
  fields->AddArray(device);

  // These come last: field data has as many rows as its first array. With 0 rows (no probes) ParaView would show and
  // send nothing.
  constexpr double degrees = 180.0 / 3.14159265358979323846;
  addVectors("ProbeReached", &chainmail::ProbeResult::reached, &Frame::VectorToWorld<double>);
  addVectors("ProbeForce", &chainmail::ProbeResult::force, &Frame::VectorToWorld<double>);
  addVectors("ProbeTurned", &chainmail::ProbeResult::rotated, &Frame::AxialToWorld, degrees);
  addVectors("ProbeTorque", &chainmail::ProbeResult::torque, &Frame::AxialToWorld);
}

/// Adds one row for each rigid body, in the order of the numbers in the array Cluster.
void Outputs::AddBodies(vtkFieldData* fields)
{
  const std::vector<chainmail::RigidBody> bodies = this->Source.GetSimulation().bodies();
  vtkDataArray* labels = this->Source.GetTissue().Bodies.Array;
  const auto count = static_cast<vtkIdType>(bodies.size());
  const auto voxels = MakeArray<vtkIdTypeArray>("BodyVoxels", 1, count);
  const auto holders = MakeArray<vtkIntArray>("BodyHeldBy", 1, count);
  const auto names = MakeArray<vtkIdTypeArray>("BodyLabel", 1, count);
  for (vtkIdType n = 0; n < count; ++n)
  {
    const chainmail::RigidBody& body = bodies[static_cast<std::size_t>(n)];
    int holder = 0;
    switch (body.limiter.what)
    {
    case chainmail::Limiter::What::Face:
      holder = 1;
      break;
    case chainmail::Limiter::What::Rigid:
      holder = 2;
      break;
    case chainmail::Limiter::What::Probe:
      holder = 3;
      break;
    default:
      break;
    }
    voxels->SetValue(n, static_cast<vtkIdType>(body.elements));
    holders->SetValue(n, holder);
    names->SetValue(n, labels ? LabelAt(labels, static_cast<vtkIdType>(body.voxel)) : 0);
  }
  fields->AddArray(voxels);
  fields->AddArray(holders);
  if (labels)
  {
    fields->AddArray(names);
  }
}

vtkSmartPointer<vtkUnsignedCharArray> Outputs::FetchElement(vtkIdType voxels)
{
  const auto element = MakeArray<vtkUnsignedCharArray>("Element", 1, voxels);
  this->Source.GetSimulation().elements(element->GetPointer(0));
  return element;
}

vtkSmartPointer<vtkUnsignedCharArray> Outputs::FetchLinks(vtkIdType voxels)
{
  constexpr unsigned char carved = chainmail::RestModel::carved;
  const auto links = MakeArray<vtkUnsignedCharArray>("Links", 1, voxels);
  const vtkSmartPointer<vtkUnsignedCharArray> element = this->FetchElement(voxels);
  const chainmail::Model& model = this->Source.GetModel();
  const int axes = model.axes();
  const chainmail::Index3& size = model.grid().size;
  this->Source.GetSimulation().links(links->GetPointer(0), true);
  std::vector<float> row(static_cast<std::size_t>(size[0]) * axes);
  vtkIdType v = 0;
  for (int k = 0; k < size[2]; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      model.row(0, j, k, size[0], row.data()); // the model at rest, before any carve
      for (int i = 0; i < size[0]; ++i, ++v)
      {
        if (element->GetValue(v) == 0 && !std::isinf(row[static_cast<std::size_t>(i) * axes]))
        {
          links->SetValue(v, carved);
        }
      }
    }
  }
  return links;
}

void Outputs::WriteBodies(vtkPointData* output)
{
  const chainmail::Index3& size = this->Source.GetModel().grid().size;
  if (vtkDataArray* labels = this->Source.GetTissue().Bodies.Array)
  {
    output->AddArray(labels);
  }
  output->AddArray(this->FetchCluster(static_cast<vtkIdType>(size[0]) * size[1] * size[2]));
}

vtkSmartPointer<vtkIntArray> Outputs::FetchCluster(vtkIdType voxels)
{
  const auto cluster = MakeArray<vtkIntArray>("Cluster", this->Source.GetModel().axes(), voxels);
  this->Source.GetSimulation().clusters(cluster->GetPointer(0));
  return cluster;
}

vtkSmartPointer<vtkFloatArray> Outputs::FetchConstraint(vtkIdType voxels)
{
  const chainmail::Model& model = this->Source.GetModel();
  const int axes = model.axes();
  const vtkSmartPointer<vtkUnsignedCharArray> element = this->FetchElement(voxels);
  const auto constraint = MakeArray<vtkFloatArray>("Constraint", axes, voxels);
  const chainmail::Index3& size = model.grid().size;
  const unsigned char* e = element->GetPointer(0);
  float* c = constraint->GetPointer(0);
  for (int k = 0; k < size[2]; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      model.row(0, j, k, size[0], c);
      for (int i = 0; i < size[0]; ++i, c += axes, ++e)
      {
        // The engine marks air by an infinite constraint, and anchors by a negative one.
        for (int a = 0; a < axes; ++a)
        {
          c[a] = *e ? std::fabs(c[a]) : 0.0f;
        }
      }
    }
  }
  return constraint;
}

vtkSmartPointer<vtkFloatArray> Outputs::FetchDisplacement(vtkIdType voxels)
{
  const auto displacement = MakeArray<vtkFloatArray>("Displacement", 3, voxels, true);
  float* u = displacement->GetPointer(0);
  this->Source.GetSimulation().displacements(u, true);
  if (this->Space->IsRotated())
  {
    ForPortions(voxels,
      [&](vtkIdType first, vtkIdType last)
      {
        for (vtkIdType v = first; v < last; ++v)
        {
          if (u[3 * v] != 0.0f || u[3 * v + 1] != 0.0f || u[3 * v + 2] != 0.0f)
          {
            this->Space->VectorToWorld(u + 3 * v, u + 3 * v);
          }
        }
      });
  }
  return displacement;
}

void Outputs::FetchTimes(const Scene& scene, vtkPointData* output)
{
  const vtkIdType voxels = scene.Image->GetNumberOfPoints();
  const int axes = this->Source.GetModel().axes();
  const auto time = MakeArray<vtkFloatArray>("PropagationTime", axes, voxels);
  float* t = time->GetPointer(0);
  this->Source.GetSimulation().propagationTimes(t);
  const Vector3& spacing = scene.Space.GetSpacing();
  ForPortions(voxels,
    [&](vtkIdType first, vtkIdType last)
    {
      for (int a = 0; a < axes; ++a)
      {
        for (vtkIdType n = first * axes + a; n < last * axes; n += axes)
        {
          // A negative time means that no wave came, and is kept.
          t[n] = t[n] > 0.0f ? static_cast<float>(t[n] * spacing[a]) : t[n];
        }
      }
    });
  const auto wavefront = MakeArray<vtkIntArray>("Wavefront", axes, voxels, true);
  this->Source.GetSimulation().wavefronts(wavefront->GetPointer(0), true);
  output->AddArray(time);
  output->AddArray(wavefront);
}

void Outputs::WarnAboutLostArrays(vtkImageData* image)
{
  std::set<std::string> names;
  vtkCellData* arrays = image->GetCellData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    const char* name = arrays->GetArrayName(a);
    names.insert(name ? name : "");
  }
  names.erase(vtkDataSetAttributes::GhostArrayName());
  if (!names.empty() && names != this->LostArrays)
  {
    std::string list;
    for (const std::string& name : names)
    {
      list += (list.empty() ? "" : ", ") + name;
    }
    this->Reports.Warn("The output has no cell arrays, because only point arrays are deformed. Left out: " + list +
                       ". To deform them, put Cell Data to Point Data before this filter.");
  }
  this->LostArrays = std::move(names);
}

}
