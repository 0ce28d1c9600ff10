// SPDX-License-Identifier: BSD-3-Clause
#include "Outputs.h"

#include "Arrays.h"
#include "ImageParts.h"

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

void Outputs::RemoveFigures(vtkFieldData* fields)
{
  for (const char* name : { "ProbeReached", "ProbeForce", "ProbeTurned", "ProbeTorque", "Energy", "MaxLinkExcess",
         "PropagationIterationsUsed", "RelaxationIterationsUsed", "CoarseToFineStep", "DisplacedElements",
         "Milliseconds", "PeakDeviceMemory", "DeviceName", "BodyVoxels", "BodyHeldBy", "BodyLabel", "Error" })
  {
    fields->RemoveArray(name);
  }
}

std::array<vtkSmartPointer<vtkImageData>, 2> Outputs::Write(
  const Team& team, const Scene* scene, const Properties& properties, const Request& request)
{
  Steps steps;
  vtkMultiProcessStream stream;
  OutputPlan& plan = this->Plan;
  if (scene)
  {
    plan = OutputPlan(*scene, this->Source);
    plan.Write(stream);
  }
  team.GetLink().FromRoot(stream);
  if (!scene)
  {
    plan = OutputPlan::Read(stream);
  }
  const auto deformed = this->WriteDeformed(
    team, steps, scene, plan, properties, request ? std::optional<Extent>((*request)[0]) : std::nullopt);
  const auto model = this->Model.Write(team, steps, plan, properties.ModelArrays, properties.PropagationTimes,
    request ? (*request)[1] : ExtentOf(plan.Whole));
  vtkNew<vtkFieldData> fields;
  team.Lead(steps,
    [&]
    {
      const double peak = 1e-6 * static_cast<double>(this->Source.GetSimulation().takePeakDeviceBytes());
      this->WriteFieldData(*scene, peak, fields);
    });
  team.GetLink().FromRoot(fields);
  steps.End();
  deformed->GetFieldData()->ShallowCopy(fields);
  model->GetFieldData()->ShallowCopy(fields);
  return { { deformed, model } };
}

void Outputs::ChooseModelArrays(const Team& team, vtkDataArraySelection* chosen, vtkImageData* model)
{
  Steps steps;
  this->Model.Choose(team, steps, chosen, model);
  steps.End();
}

bool Outputs::Sampled::operator==(const Sampled& other) const
{
  const auto all = [](const Sampled& s)
  { return std::tie(s.Array, s.Far.Array, s.Numbers, s.Time, s.G, s.Nearest, s.Still, s.SmoothCuts, s.Builds); };
  const bool sameBackground =
    this->Background == other.Background || (std::isnan(this->Background) && std::isnan(other.Background));
  return all(*this) == all(other) && sameBackground && this->NotMeasured == other.NotMeasured;
}

/// Reuses samplers of the last update where nothing changed apart from the deformation.
void Outputs::ChooseSamplers(
  const Scene* scene, const OutputPlan& plan, const Properties& properties, const Grids& grids)
{
  // The same test as that of the model, which only one thread at a time may use.
  const auto tissueIn = [&plan](vtkDataArray* of) -> TissueTest
  {
    return
      [scalars = vtkSmartPointer<vtkDataArray>(of), threshold = plan.Threshold, ceiling = plan.Ceiling](vtkIdType voxel)
    {
      const double scalar = scalars->GetComponent(voxel, 0);
      return std::isfinite(scalar) && scalar >= threshold && scalar < ceiling;
    };
  };
  const bool goOn = this->MaterialVersion == this->Material.GetVersion();
  this->MaterialVersion = this->Material.GetVersion();
  const std::vector<Sampled> before = goOn ? std::move(this->Samplers) : std::vector<Sampled>();
  this->Samplers.clear();
  std::unique_ptr<SmoothScalars> smoothedBefore = std::move(this->Smoothed);
  vtkImageData* image = this->Material.GetImage();
  vtkPointData* arrays = image->GetPointData();
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    const std::string name = array->GetName() ? array->GetName() : "";
    const bool areScalars = a == plan.Scalars;
    const bool isLabel = std::find(plan.LabelArrays.begin(), plan.LabelArrays.end(), name) != plan.LabelArrays.end();
    Sampled one(grids);
    one.Array = array;
    if (auto* numbers = vtkDataArray::SafeDownCast(array))
    {
      // ParaView passes an image that was just modified in every update, but with the same arrays.
      const auto same = std::find_if(before.begin(), before.end(), [&](const Sampled& s) { return s.Array == array; });
      one.Numbers.Take(numbers, image->GetMTime(),
        scene && areScalars    ? scene->Tissue.Scalars
        : same != before.end() ? same->Numbers
                               : ArrayContents());
    }
    else
    {
      one.Time = std::max(array->GetMTime(), image->GetMTime());
    }
    one.Nearest = properties.Interpolation == InterpolationTypes::Nearest || isLabel ||
                  (areScalars && plan.AreLabels) || array == arrays->GetGlobalIds() ||
                  array == arrays->GetPedigreeIds();
    one.Still = name == vtkDataSetAttributes::GhostArrayName();
    if (areScalars)
    {
      one.Background = plan.Background;
      one.NotMeasured = plan.NotMeasured;
    }
    if (vtkImageData* far = this->Material.GetFarImage())
    {
      one.Far = { vtkDataArray::SafeDownCast(far->GetPointData()->GetAbstractArray(a)), this->Material.GetFarBox(),
        tissueIn(this->Material.GetFarScalars()) };
    }
    one.SmoothCuts = properties.SmoothCuts;
    one.Builds = plan.Builds;
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
      one.Sampler = MakeSampler(array, grids, one.Nearest, one.Background, this->Material.GetSmallest(a),
        one.NotMeasured, tissueIn(this->Material.GetScalars()), one.Far);
    }
    this->Samplers.push_back(one);
    if (areScalars && properties.ScalarSmoothing > 0.0 && array->GetDataType() != VTK_BIT)
    {
      // With deviation 0 the array still exists where values are labels, so a view of it keeps something to show.
      const double deviation = one.Nearest ? 0.0 : properties.ScalarSmoothing;
      const bool goesOn = smoothedBefore && smoothedBefore->IsFor(one.Sampler, deviation);
      this->Smoothed = goesOn ? std::move(smoothedBefore)
                              : std::make_unique<SmoothScalars>(one.Sampler, grids, deviation, one.NotMeasured);
    }
  }
  const Frame space(plan.Whole);
  if (!properties.PullBack)
  {
    this->PullBack.reset();
  }
  else if (!goOn || !this->PullBack || !this->PullBack->IsFor(grids, space, properties.SmoothCuts, plan.Builds))
  {
    this->PullBack = std::make_unique<PullBackSampler>(grids, space, properties.SmoothCuts, plan.Builds);
  }
}

/// `extent`: of the part that this process makes; none for the whole image.
vtkSmartPointer<vtkImageData> Outputs::WriteDeformed(const Team& team, Steps& steps, const Scene* scene,
  const OutputPlan& plan, const Properties& properties, const std::optional<Extent>& extent)
{
  std::optional<chainmail::OutputDetail> part = plan.GetRange();
  if (extent)
  {
    // Smoothing needs some voxels more.
    const int radius =
      properties.ScalarSmoothing > 0.0 ? SmoothScalars::RadiusOf(properties.ScalarSmoothing, plan.Detail.finer) : 0;
    part = plan.GetPart(*extent, (radius + plan.Detail.finer - 1) / plan.Detail.finer);
    for (int a = 0; a < 3 && part; ++a)
    {
      if (IsEmpty(*extent) || part->first[a] > part->last[a])
      {
        part.reset();
      }
    }
  }
  this->Material.Update(team, steps, scene, plan, properties, part);
  const auto output = vtkSmartPointer<vtkImageData>::New();
  output->SetOrigin(plan.Whole->GetOrigin());
  chainmail::Vector3 spacing;
  plan.Whole->GetSpacing(spacing.data());
  for (double& step : spacing)
  {
    step /= plan.Detail.finer;
  }
  output->SetSpacing(spacing.data());
  output->SetDirectionMatrix(plan.Whole->GetDirectionMatrix());
  output->SetExtent(part ? plan.ExtentOf(*part).data() : const_cast<int*>(extent->data()));
  if (scene)
  {
    this->WarnAboutLostArrays(scene->Image);
  }
  this->Sample(team, steps, scene, plan, properties, part, output);
  return extent && part ? Cut(output, *extent) : output;
}

void Outputs::Sample(const Team& team, Steps& steps, const Scene* scene, const OutputPlan& plan,
  const Properties& properties, const std::optional<chainmail::OutputDetail>& part, vtkImageData* output)
{
  std::vector<ArraySampler*> samplers;
  std::uint64_t since = 0;
  if (part)
  {
    steps.Run(
      [&]
      {
        if (!this->Reports.BeginPart(RESAMPLE, 0.75, 0.9))
        {
          throw chainmail::Aborted();
        }
        samplers = this->BeginSamplers(scene, plan, properties, *part, since);
      });
  }
  const auto sample = [&](const std::vector<chainmail::ResampledBox>& boxes)
  {
    for (ArraySampler* one : samplers)
    {
      one->Sample(boxes);
    }
  };
  const chainmail::Resampled resampled = this->Material.Resample(team, steps, sample, since);
  if (part)
  {
    steps.Run([&] { this->EndSamplers(plan, *part, resampled, output); });
  }
  this->Reports.EndPart();
}

/// The samplers of all arrays, and the resampling from which they go on.
std::vector<ArraySampler*> Outputs::BeginSamplers(const Scene* scene, const OutputPlan& plan,
  const Properties& properties, const chainmail::OutputDetail& part, std::uint64_t& since)
{
  this->ChooseSamplers(scene, plan, properties, Grids(plan.GetSize(), this->Material.GetBox(), plan.Padding, part));
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
  since = std::numeric_limits<std::uint64_t>::max();
  for (ArraySampler* one : samplers)
  {
    since = std::min(since, one->Begin());
  }
  return samplers;
}

void Outputs::EndSamplers(const OutputPlan& plan, const chainmail::OutputDetail& part,
  const chainmail::Resampled& resampled, vtkImageData* output)
{
  const Grids grids(plan.GetSize(), this->Material.GetBox(), plan.Padding, part);
  vtkImageData* input = this->Material.GetImage();
  if (vtkAbstractArray* ghosts = input->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()))
  {
    StillArray still(ghosts, grids.Cells());
    still.Begin();
    output->GetCellData()->AddArray(still.End(resampled.number, resampled.atRest));
  }
  for (std::size_t n = 0; n < this->Samplers.size(); ++n)
  {
    const vtkSmartPointer<vtkAbstractArray> array = this->Samplers[n].Sampler->End(resampled.number, resampled.atRest);
    output->GetPointData()->AddArray(array);
    if (this->Smoothed && static_cast<int>(n) == plan.Scalars)
    {
      this->Smoothed->SetSampled(vtkDataArray::SafeDownCast(array));
    }
  }
  CopyActiveAttributes(input->GetPointData(), output->GetPointData());
  if (this->PullBack) // replaces an input array of that name, which belongs to another deformation
  {
    output->GetPointData()->AddArray(this->PullBack->End(resampled.number, resampled.atRest));
  }
  if (this->Smoothed) // likewise
  {
    output->GetPointData()->AddArray(this->Smoothed->End(resampled.number, resampled.atRest));
  }
}

void Outputs::WriteFieldData(const Scene& scene, double peakMegabytes, vtkFieldData* fields)
{
  const Results& found = this->Source.GetResults();
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
    names->SetValue(n, this->Source.LabelOf(body.voxel));
  }
  fields->AddArray(voxels);
  fields->AddArray(holders);
  if (this->Source.GetTissue().Bodies.Array)
  {
    fields->AddArray(names);
  }
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
