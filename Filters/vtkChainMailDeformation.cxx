// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailDeformation.h"

#include "Private/Exchange.h"
#include "Private/ImageParts.h"
#include "Private/Inputs.h"
#include "Private/OutputGrid.h"
#include "Private/Outputs.h"
#include "Private/Pipeline.h"
#include "Private/Presets.h"
#include "Private/Progress.h"
#include "Private/Properties.h"
#include "Private/Report.h"
#include "Private/Scene.h"
#include "Private/Session.h"
#include "Private/Shown.h"
#include "Private/SpreadImage.h"
#include "Private/Team.h"

#include "Device.h"
#include "Error.h"
#include "Notices.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArraySelection.h"
#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <utility>
#include <vector>

using chainmail::InputError;
using vtkChainMail::CARVES;
using vtkChainMail::CUTS;
using vtkChainMail::Exchange;
using vtkChainMail::IMAGE;
using vtkChainMail::Inputs;
using vtkChainMail::Outcome;
using vtkChainMail::PROBES;
using vtkChainMail::Steps;
using vtkChainMail::Team;

namespace
{

/// Assigns the number of an enumerated property, which may have no meaning.
template <typename E> void Assign(E& enumeration, int number)
{
  enumeration = static_cast<E>(number);
}

}

//------------------------------------------------------------------------------
/// Keeps the state between updates, and is the only place that converts the engine's exceptions to VTK errors.
class vtkChainMailDeformation::vtkInternals
{
public:
  explicit vtkInternals(vtkChainMailDeformation* self)
    : Self(self)
    , Reports(self)
    , Engine(this->Reports)
    , Writer(this->Engine, this->Reports)
  {
  }

  /// The values of all properties that an update reads.
  vtkChainMail::Properties GetProperties() const
  {
    const vtkChainMailDeformation& filter = *this->Self;
    vtkChainMail::Properties values;
    Assign(values.MaterialPreset, filter.MaterialPreset);
    values.MaterialFunction = filter.MaterialFunction;
    values.TissueThreshold = filter.TissueThreshold;
    values.ConstraintArray = filter.ConstraintArray;
    values.BodyArray = filter.BodyArray;
    values.JointSize = filter.JointSize;
    values.JointConstraint = filter.JointConstraint;
    values.JointMargin = filter.JointMargin;
    values.AnchorRigid = filter.AnchorRigid;
    std::copy_n(filter.AnchoredFaces, 6, values.AnchoredFaces.begin());

    Assign(values.Mode, filter.Mode);
    Assign(values.PropagationMethod, filter.PropagationMethod);
    values.PropagationIterations = filter.PropagationIterations;
    Assign(values.ConflictPolicy, filter.ConflictPolicy);
    values.PropagationTimes = filter.PropagationTimes;
    Assign(values.RelaxationMethod, filter.RelaxationMethod);
    Assign(values.RelaxationPreset, filter.RelaxationPreset);
    values.CoarseToFine = filter.CoarseToFine;
    values.ElasticRecovery = filter.ElasticRecovery;
    values.Rotations = filter.Rotations;
    values.PoissonRatio = filter.PoissonRatio;
    values.RelaxationIterations = filter.RelaxationIterations;
    values.RelaxationTolerance = filter.RelaxationTolerance;
    values.RelaxationError = filter.RelaxationError;
    values.ModelReduction = filter.ModelReduction;

    values.ModelArrays = filter.ModelArraySelection;
    Assign(values.Interpolation, filter.Interpolation);
    values.LabelArrays = filter.LabelArrays;
    values.BackgroundValue = filter.BackgroundValue;
    values.OutputPadding = filter.OutputPadding;
    values.OutputMagnification = filter.OutputMagnification;
    values.UseOutputBounds = filter.UseOutputBounds;
    std::copy_n(filter.OutputBounds, 6, values.OutputBounds.begin());
    values.SmoothCuts = filter.SmoothCuts;
    values.PullBack = filter.PullBack;
    values.ScalarSmoothing = filter.ScalarSmoothing;

    values.Device = filter.Device;
    std::copy_n(filter.BrickSize, 3, values.BrickSize.begin());
    return values;
  }

  /// Computes this process's parts of both outputs or, after an error, what they show instead. All processes call this
  /// together. `inputs`: those of all processes, on the root.
  Outcome Compute(const Team& team, Inputs inputs, const vtkChainMail::Outputs::Request& request)
  {
    this->Work = std::make_unique<Job>();
    this->Work->Given = std::move(inputs);
    this->Work->Values = this->GetProperties();
    return this->Complete(team, request, [&] { this->Update(request); });
  }

  /// Makes other parts of the outputs of the last update. All processes call this together.
  Outcome Redistribute(const Team& team, const vtkChainMail::Outputs::Request& request)
  {
    return this->Complete(team, request, [] {});
  }

  /// Whether several processes are to make one piece each of the outputs, all at once: the processes of a parallel
  /// server. Any other request, for example of a streaming writer, is answered by this process alone.
  bool IsParallel(vtkInformation* asked) const
  {
    using Pipeline = vtkStreamingDemandDrivenPipeline;
    vtkMultiProcessController* const controller = this->Self->GetController();
    const int pieces = asked->Get(Pipeline::UPDATE_NUMBER_OF_PIECES());
    return controller && pieces > 1 && controller->GetNumberOfProcesses() == pieces &&
           controller->GetLocalProcessId() == asked->Get(Pipeline::UPDATE_PIECE_NUMBER());
  }

  /// When a property last changed that the state depends on. ModelArrays is none: it changes only what is shown.
  vtkMTimeType GetTimeOfState() const
  {
    const vtkMTimeType own = this->Self->Superclass::GetMTime();
    return this->Self->MaterialFunction ? std::max(own, this->Self->MaterialFunction->GetMTime()) : own;
  }

  /// Gives output 1 the arrays that are chosen now. The state is that of the last update. All processes call this
  /// together.
  void ChangeModelArrays(const Team& team)
  {
    const Exchange& exchange = team.GetLink();
    Outcome outcome = this->Last;
    this->Try(
      outcome, [&] { this->Writer.ChooseModelArrays(team, this->Self->GetModelArraySelection(), this->Shows.Get(1)); });
    exchange.Agree(outcome);
    if (!outcome.Error.empty() && exchange.IsRoot())
    {
      vtkErrorWithObjectMacro(this->Self, << outcome.Error);
    }
    this->Last.Stopped = outcome.Stopped; // so the next update adds the missing arrays
    this->Reports.End();
  }

  bool IsSpread() const { return this->ComputedInParallel && this->Held.IsSpread(); }

  bool GetBodies(vtkImageData* image)
  {
    if (this->IsSpread())
    {
      image->ShallowCopy(this->Bodies);
      return this->Bodies->GetNumberOfPoints() > 0;
    }
    Steps steps; // the next update reports an error
    steps.Run([&] { this->WriteBodies(image); });
    return image->GetNumberOfPoints() > 0;
  }

  void CollectBodies()
  {
    if (this->IsSpread())
    {
      Steps steps; // as in GetBodies()
      this->MakeTeam(Exchange(this->Self->GetController())).Lead(steps, [&] { this->WriteBodies(this->Bodies); });
    }
  }

  /// Keeps what processes of a parallel run ask each other for, after the inputs `all` were gathered: this process's
  /// part of the image, `own`, and on the root the image. `isKnown`: the image has not changed.
  void Keep(vtkImageData* own, bool isKnown, const Exchange& exchange, Inputs& all)
  {
    if (!isKnown)
    {
      this->Own = nullptr;
      this->Spread.reset();
    }
    if (!isKnown && own && exchange.GetSize() > 1)
    {
      // Another consumer may ask the source for other voxels, which then has new arrays in the same image.
      this->Own = vtkSmartPointer<vtkImageData>::New();
      this->Own->ShallowCopy(own);
    }
    if (this->Held.IsSpread() && exchange.IsRoot())
    {
      if (!this->Spread)
      {
        this->Spread = std::make_shared<vtkChainMail::SpreadImage>(exchange, this->Own, this->Held);
      }
      all.Image = this->Own;
      all.Spread = this->Spread;
    }
    this->Known = exchange.GetSize() > 1 && all.Problem.empty() ? all.Image : nullptr;
    this->IsKept = all.Problem.empty();
  }

  /// The processes of an update, after the inputs were gathered.
  Team MakeTeam(const Exchange& exchange) const { return Team(exchange, this->Own, this->Held, this->Spread); }

  vtkChainMailDeformation* Self;
  vtkChainMail::Progress Reports;
  vtkChainMail::Session Engine;
  vtkChainMail::Outputs Writer;
  vtkChainMail::Shown Shows;
  vtkChainMail::InputWatch Watch;
  vtkChainMail::Report Words;
  vtkChainMail::LabelVoxels Labels;

  /// Extent and spacing of the input and of the deformed image. `Announced` is what RequestInformation() gave to
  /// downstream filters, `Good` that of the last successful update. Both are the same in all processes.
  struct Place
  {
    std::array<int, 6> Image{ { 0, -1, 0, -1, 0, -1 } };
    std::array<int, 6> Deformed{ { 0, -1, 0, -1, 0, -1 } };
    std::array<double, 3> Spacing{ { 1.0, 1.0, 1.0 } };
    int Magnification = 1;
  };
  Place Announced;
  Place Good;

  /// The outcome of the last update, and whether it was computed together with other processes: which parts this
  /// process then made.
  Outcome Last;
  bool ComputedInParallel = false;
  vtkChainMail::Outputs::Request Made;
  vtkSmartPointer<vtkImageData> Own; // the part of the image that this process has
  vtkChainMail::Holding Held;        // how the image is spread over the processes
  bool IsKept = false;               // whether both are those of the last update
  // On the root of several processes: the image of the last update, of all processes or the root's part of it.
  vtkSmartPointer<vtkImageData> Known;
  std::shared_ptr<vtkChainMail::SpreadImage> Spread;
  vtkNew<vtkImageData> Bodies; // see CollectBodies()

private:
  /// Leaves the image empty where there is no result.
  void WriteBodies(vtkImageData* image)
  {
    image->Initialize();
    if (this->Engine.HasModel() && this->Shows.Get(1) && this->Last.Error.empty() && !this->Last.Stopped)
    {
      this->Writer.WriteBodies(image);
    }
  }

  /// An update, for as long as its state can be shown.
  struct Job
  {
    Inputs Given;
    vtkChainMail::Properties Values;
    std::unique_ptr<vtkChainMail::Scene> Scene; // refers to the others
  };

  /// Runs a part of an update, and turns the engine's exceptions into an outcome.
  template <typename F> void Try(Outcome& outcome, F&& part)
  {
    try
    {
      part();
      return;
    }
    catch (const chainmail::Aborted&)
    {
      outcome.Stopped = true; // on request, so no error
    }
    catch (const chainmail::DeviceError& error)
    {
      this->Engine.DeleteSimulation();
      this->Writer.Forget();
      outcome.Error = error.what();
    }
    catch (const std::bad_alloc&)
    {
      this->Engine.DeleteSimulation();
      this->Writer.Forget();
      outcome.Error = "There is not enough main memory for this image. Crop it or resample it to fewer voxels.";
    }
    catch (const std::exception& error)
    {
      outcome.Error = error.what();
    }
  }

  /// Calls update() on the root, and makes the outputs.
  template <typename F> Outcome Complete(const Team& team, const vtkChainMail::Outputs::Request& request, F&& update)
  {
    const Exchange& exchange = team.GetLink();
    this->Bodies->Initialize();
    Outcome outcome;
    Steps steps;
    if (!exchange.IsRoot())
    {
      steps.Run([&] { RequireNoProblem(this->Work->Given); });
    }
    team.Lead(steps, update);
    this->Try(outcome, [&] { steps.End(); });
    const auto agree = [&]
    {
      const bool isFine = !outcome.Stopped && outcome.Error.empty();
      outcome.NeedsUpdate = isFine && this->Engine.IsUnsettled();
      exchange.Agree(outcome);
      return !outcome.Stopped && outcome.Error.empty();
    };
    bool isFine = agree();
    if (isFine)
    {
      this->Try(outcome, [&] { this->Write(team, request); });
      isFine = agree();
    }
    if (outcome.Stopped)
    {
      this->Engine.ResetAfterStop();
    }
    if (!isFine)
    {
      outcome.NeedsUpdate = false;
      const std::string problem = outcome.Stopped ? "The update was stopped." : outcome.Error;
      this->Shows.Again(team, this->Work->Given, problem, this->Announced.Magnification, request);
      this->Words.Set(problem);
      this->Work.reset();
    }
    else if (exchange.GetSize() == 1)
    {
      this->Work.reset(); // only a parallel run makes parts of the outputs later
    }
    for (const std::string& notice : chainmail::takeNotices())
    {
      this->Reports.Warn(notice);
    }
    this->Reports.End();
    outcome.Interacting = this->Engine.IsInteracting();
    exchange.Agree(outcome);
    return outcome;
  }

  static void RequireNoProblem(const Inputs& inputs)
  {
    if (!inputs.Problem.empty())
    {
      throw InputError(inputs.Problem);
    }
  }

  void Update(const vtkChainMail::Outputs::Request& request)
  {
    const Inputs& inputs = this->Work->Given;
    RequireNoProblem(inputs);
    if (!inputs.Image || inputs.Image->GetNumberOfPoints() == 0)
    {
      throw InputError("The input image is empty: give one with at least one voxel on every axis.");
    }
    this->Reports.Begin();
    vtkChainMail::ChosenArray scalars{ nullptr, vtkDataObject::FIELD_ASSOCIATION_POINTS, nullptr };
    vtkInformation* choice = this->Self->GetInputArrayInformation(0);
    scalars.Name = choice->Has(vtkDataObject::FIELD_NAME()) ? choice->Get(vtkDataObject::FIELD_NAME()) : nullptr;
    scalars.Array = this->Self->GetInputAbstractArrayToProcess(0, inputs.Image, scalars.Association);

    const vtkChainMail::Properties& properties = this->Work->Values;
    this->Work->Scene =
      std::make_unique<vtkChainMail::Scene>(properties, inputs, scalars, this->Engine.GetTissue(), this->Labels);
    const vtkChainMail::Scene& scene = *this->Work->Scene;
    // Memory is checked for a new output only: an output of the same extent is written to again.
    const bool isNew =
      this->Announced.Deformed != this->Good.Deformed || this->Announced.Magnification != this->Good.Magnification;
    if (isNew && (this->Announced.Magnification > 1 || properties.OutputPadding > 0))
    {
      RequireMemory(scene.Output, inputs.Image, request ? (*request)[0] : scene.Output.ExtentOf(scene.Whole),
        (properties.PullBack ? 3 * sizeof(float) : 0) + (properties.ScalarSmoothing > 0.0 ? sizeof(float) : 0));
    }
    this->Engine.Update(scene);
  }

  void Write(const Team& team, const vtkChainMail::Outputs::Request& request)
  {
    const vtkChainMail::Scene* scene = this->Work->Scene.get();
    Steps steps;
    steps.Run(
      [&]
      {
        const auto outputs = this->Writer.Write(team, scene, this->Work->Values, request);
        this->Shows.Set(outputs, this->Writer.GetWhole());
      });
    team.Lead(steps,
      [&]
      {
        this->Words.Set(*scene, this->Engine, this->Shows.Get(0)->GetFieldData());
        if (team.IsSpread())
        {
          this->Words.Get(this->Engine); // reads tissue, so it cannot wait for a request
        }
      });
    steps.End();
  }

  std::unique_ptr<Job> Work; // the last update; null after an error
};

//------------------------------------------------------------------------------
vtkStandardNewMacro(vtkChainMailDeformation);

//------------------------------------------------------------------------------
vtkChainMailDeformation::vtkChainMailDeformation()
  : TissueThreshold(vtkMath::Nan())
  , BackgroundValue(vtkMath::Nan())
  , Controller(vtkMultiProcessController::GetGlobalController())
  , Internals(new vtkInternals(this))
{
  for (const char* name : vtkChainMail::ModelAtRest::Choices)
  {
    this->ModelArraySelection->SetArraySetting(name, vtkChainMail::ModelAtRest::IsDefault(name));
  }
  this->NoProbes->SetNumberOfComponents(3);
  this->SetNumberOfInputPorts(vtkChainMail::NUMBER_OF_PORTS);
  this->SetNumberOfOutputPorts(2);
  this->SetInputArrayToProcess(0, IMAGE, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

//------------------------------------------------------------------------------
vtkChainMailDeformation::~vtkChainMailDeformation() = default;

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetProbesConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(PROBES, producer);
}

void vtkChainMailDeformation::AddProbesConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(PROBES, producer);
}

void vtkChainMailDeformation::SetCutsConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(CUTS, producer);
}

void vtkChainMailDeformation::AddCutsConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(CUTS, producer);
}

void vtkChainMailDeformation::SetCarvesConnection(vtkAlgorithmOutput* producer)
{
  this->SetInputConnection(CARVES, producer);
}

void vtkChainMailDeformation::AddCarvesConnection(vtkAlgorithmOutput* producer)
{
  this->AddInputConnection(CARVES, producer);
}

//------------------------------------------------------------------------------
vtkImageData* vtkChainMailDeformation::GetModelOutput()
{
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}

//------------------------------------------------------------------------------
bool vtkChainMailDeformation::GetBodies(vtkImageData* image)
{
  return this->Internals->GetBodies(image);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::CollectBodies()
{
  this->Internals->CollectBodies();
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetController(vtkMultiProcessController* controller)
{
  if (this->Controller != controller)
  {
    this->Controller = controller;
    this->Modified();
  }
}

vtkMultiProcessController* vtkChainMailDeformation::GetController()
{
  return this->Controller;
}

//------------------------------------------------------------------------------
vtkDataArraySelection* vtkChainMailDeformation::GetModelArraySelection()
{
  return this->ModelArraySelection;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetMaterialFunction(vtkPiecewiseFunction* function)
{
  if (this->MaterialFunction != function)
  {
    this->MaterialFunction = function;
    this->Modified();
  }
}

vtkPiecewiseFunction* vtkChainMailDeformation::GetMaterialFunction()
{
  return this->MaterialFunction;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::Reset()
{
  if (this->Mode == MODE_INTERACTIVE)
  {
    this->Internals->Engine.RequestReset();
    this->Internals->Last.NeedsUpdate = this->Internals->Last.Interacting;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
bool vtkChainMailDeformation::GetNeedsUpdate()
{
  const bool needed = this->Mode == MODE_INTERACTIVE && this->Internals->Last.NeedsUpdate;
  // In a parallel run perhaps only one process calls this. If it updated alone, it would wait for the others for ever.
  if (needed && !this->Internals->ComputedInParallel)
  {
    this->Modified();
  }
  return needed;
}

//------------------------------------------------------------------------------
const char* vtkChainMailDeformation::GetReport()
{
  try
  {
    return this->Internals->Words.Get(this->Internals->Engine).c_str();
  }
  catch (const std::exception& error) // the device failed during the search for what holds a probe
  {
    vtkErrorMacro(<< error.what());
    return "";
  }
}

//------------------------------------------------------------------------------
vtkDataArray* vtkChainMailDeformation::GetProbeReached()
{
  vtkImageData* output = this->GetOutput();
  vtkDataArray* reached = output ? output->GetFieldData()->GetArray("ProbeReached") : nullptr;
  return reached ? reached : this->NoProbes.Get();
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::SetGlobalProbeWarnings(bool warn)
{
  vtkChainMail::ProbeWarnings::AreOn = warn;
}

bool vtkChainMailDeformation::GetGlobalProbeWarnings()
{
  return vtkChainMail::ProbeWarnings::AreOn;
}

//------------------------------------------------------------------------------
// vtkSetMacro would treat every call with NaN as a change, because NaN differs from itself.
void vtkChainMailDeformation::SetTissueThreshold(double threshold)
{
  if (this->TissueThreshold != threshold && !(std::isnan(this->TissueThreshold) && std::isnan(threshold)))
  {
    this->TissueThreshold = threshold;
    this->Modified();
  }
}

void vtkChainMailDeformation::SetBackgroundValue(double value)
{
  if (this->BackgroundValue != value && !(std::isnan(this->BackgroundValue) && std::isnan(value)))
  {
    this->BackgroundValue = value;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::FitMaterial(
  const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function)
{
  vtkChainMailDeformation::GetPresetMaterial(MATERIAL_FUNCTION, range, tissueThreshold, function);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::GetPresetMaterial(
  int preset, const double range[2], double& tissueThreshold, vtkPiecewiseFunction* function)
{
  const auto chosen = static_cast<vtkChainMail::MaterialPresets>(preset);
  vtkChainMail::GetPresetMaterial(chosen, range, tissueThreshold, function);
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::AddLabelArray(const char* name)
{
  if (name && *name && !this->HasLabelArray(name))
  {
    this->LabelArrays.emplace_back(name);
    this->Modified();
  }
}

void vtkChainMailDeformation::RemoveLabelArray(const char* name)
{
  if (this->HasLabelArray(name))
  {
    this->LabelArrays.erase(std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name));
    this->Modified();
  }
}

void vtkChainMailDeformation::ClearLabelArrays()
{
  if (!this->LabelArrays.empty())
  {
    this->LabelArrays.clear();
    this->Modified();
  }
}

int vtkChainMailDeformation::GetNumberOfLabelArrays() const
{
  return static_cast<int>(this->LabelArrays.size());
}

const char* vtkChainMailDeformation::GetLabelArray(int index) const
{
  return index >= 0 && index < this->GetNumberOfLabelArrays() ? this->LabelArrays[index].c_str() : nullptr;
}

bool vtkChainMailDeformation::HasLabelArray(const char* name) const
{
  return name && std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name) != this->LabelArrays.end();
}

//------------------------------------------------------------------------------
vtkStringArray* vtkChainMailDeformation::GetAvailableDevices()
{
  this->AvailableDevices = vtkSmartPointer<vtkStringArray>::New();
  try
  {
    for (const chainmail::DeviceInfo& device : chainmail::listDevices())
    {
      this->AvailableDevices->InsertNextValue(device.name);
    }
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
  }
  return this->AvailableDevices;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkChainMailDeformation::GetMTime()
{
  return std::max(this->Internals->GetTimeOfState(), this->ModelArraySelection->GetMTime());
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), vtkChainMail::PortKinds[port].Type);
  // Without this the executive would run the filter once for every block, with one simulation for all blocks. A
  // composite image is an error, which the update reports.
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  if (port != IMAGE)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
    info->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestInformation(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* input = inputVector[IMAGE]->GetInformationObject(0);
  std::array<int, 6> extent{ { 0, -1, 0, -1, 0, -1 } };
  if (input->Has(Pipeline::WHOLE_EXTENT())) // a composite dataset has none
  {
    input->Get(Pipeline::WHOLE_EXTENT(), extent.data());
  }
  vtkInformation* deformed = outputVector->GetInformationObject(0);
  vtkInformation* model = outputVector->GetInformationObject(1);
  model->Set(Pipeline::WHOLE_EXTENT(), extent.data(), 6);
  if (this->ModelArraySelection->ArrayIsEnabled("Displacement"))
  {
    vtkDataObject::SetPointDataActiveScalarInfo(model, VTK_FLOAT, 3);
  }
  else if (this->ModelArraySelection->ArrayIsEnabled("Element"))
  {
    vtkDataObject::SetPointDataActiveScalarInfo(model, VTK_UNSIGNED_CHAR, 1);
  }

  vtkNew<vtkImageData> image; // geometry only: extent, origin, spacing and direction
  vtkChainMail::DescribeImage(input, image);
  vtkInternals::Place& place = this->Internals->Announced;
  place = vtkInternals::Place();
  place.Image = place.Deformed = extent;
  std::copy_n(image->GetSpacing(), 3, place.Spacing.begin());
  try
  {
    const vtkChainMail::OutputGrid grid(this->Internals->GetProperties(), image);
    place.Deformed = grid.ExtentOf(image);
    place.Spacing = grid.SpacingOf(image);
    place.Magnification = grid.Detail.finer;
  }
  catch (const InputError&)
  {
    // The update will report this error. It then shows the last good result if that fits this image, else the image as
    // it is. So announce the extent and spacing of that.
    const vtkInternals::Place& good = this->Internals->Good;
    place = good.Image == extent ? good : place;
  }
  deformed->Set(Pipeline::WHOLE_EXTENT(), place.Deformed.data(), 6);
  deformed->Set(vtkDataObject::SPACING(), place.Spacing.data(), 3);

  const vtkChainMail::MergedTimes times(inputVector, this->GetNumberOfInputPorts());
  for (vtkInformation* output : { deformed, model })
  {
    times.Tell(output);
    // Lets the executive translate a piece number to the extent of that piece.
    output->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), 1);
    // A failed update leaves its update extent behind. The executive would combine it with the next request, into an
    // extent that may exceed this image.
    output->Remove(Pipeline::COMBINED_UPDATE_EXTENT());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const int port = request->Get(vtkStreamingDemandDrivenPipeline::FROM_OUTPUT_PORT());
  vtkChainMail::AskForAll(inputVector, this->GetNumberOfInputPorts());
  vtkInformation* asked = outputVector->GetInformationObject(std::max(0, port));
  if (this->Internals->IsParallel(asked))
  {
    vtkChainMail::AskForPiece(
      inputVector[IMAGE], this->Controller->GetLocalProcessId(), this->Controller->GetNumberOfProcesses());
  }
  vtkChainMail::AskAlike(outputVector, port);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailDeformation::RequestData(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInternals& internals = *this->Internals;
  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    // VTK keeps the last scalars of an image for filters that overwrite them. This filter does not, so free their
    // memory.
    vtkImageData::GetData(outputVector, port)->GetPointData()->Initialize();
  }
  vtkInformation* asked = outputVector->GetInformationObject(0);
  const int pieces = asked->Get(Pipeline::UPDATE_NUMBER_OF_PIECES());
  const bool parallel = internals.IsParallel(asked);
  const Exchange exchange(parallel ? this->Controller.Get() : nullptr);
  vtkChainMail::Outputs::Request request;
  if (parallel)
  {
    request.emplace();
    for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
    {
      outputVector->GetInformationObject(port)->Get(Pipeline::UPDATE_EXTENT(), (*request)[port].data());
    }
  }

  const bool wasPart = internals.ComputedInParallel;
  internals.ComputedInParallel = parallel;
  Inputs mine = vtkChainMail::CollectInputs(inputVector);
  const bool isUnchanged =
    internals.Watch.IsUnchanged(inputVector, mine, internals.GetTimeOfState()) && wasPart == parallel;
  const bool isSameState = exchange.All(isUnchanged && !internals.Last.Stopped);
  const bool areSameParts = exchange.All(internals.Made == request);
  if (!isSameState || (!areSameParts && !internals.Last.Error.empty()))
  {
    const bool isKnown = parallel && exchange.All(wasPart && internals.Watch.IsImageUnchanged() && internals.IsKept &&
                                                  (internals.Known || !exchange.IsRoot()));
    Inputs all = exchange.Gather(mine, isKnown, internals.Known, internals.Held);
    internals.Keep(mine.Image, isKnown, exchange, all);
    internals.Last = internals.Compute(internals.MakeTeam(exchange), std::move(all), request);
    if (!exchange.IsRoot())
    {
      internals.Engine.DeleteAll();
      internals.Words.Set(std::string()); // a report that is not written yet needs the engine, which is gone
    }
    // The root prints the error; other processes only notify observers of ErrorEvent.
    if (!internals.Last.Error.empty() && (exchange.IsRoot() || this->HasObserver(vtkCommand::ErrorEvent)))
    {
      vtkErrorMacro(<< internals.Last.Error);
    }
  }
  else if (!areSameParts)
  {
    internals.Last = internals.Redistribute(internals.MakeTeam(exchange), request);
  }
  else if (internals.Last.Error.empty())
  {
    internals.ChangeModelArrays(internals.MakeTeam(exchange));
  }
  internals.Made = request;

  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    vtkInformation* info = outputVector->GetInformationObject(port);
    std::array<int, 6> extent;
    info->Get(Pipeline::UPDATE_EXTENT(), extent.data());
    if (pieces <= 1)
    {
      internals.Shows.Get(port)->GetExtent(extent.data());
    }
    const auto piece = vtkChainMail::Cut(internals.Shows.Get(port), extent);
    vtkImageData* output = vtkImageData::GetData(info);
    output->CopyStructure(piece);
    output->GetPointData()->ShallowCopy(piece->GetPointData());
    output->GetCellData()->ShallowCopy(piece->GetCellData());
    output->GetFieldData()->ShallowCopy(piece->GetFieldData());
  }
  if (internals.Last.Error.empty() && !internals.Last.Stopped)
  {
    internals.Good = internals.Announced;
  }
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 20220823)
  if (internals.Last.Stopped)
  {
    // The executive would empty the outputs of an aborted filter, so clear that mark. The setter changes MTime, by
    // which views would update again at once, so restore MTime.
    const vtkTimeStamp before = this->MTime;
    this->SetAbortOutput(false);
    this->MTime = before;
  }
#endif
  // SetErrorCode() would make this update out of date.
  this->ErrorCode = internals.Last.Error.empty() ? vtkErrorCode::NoError : vtkErrorCode::UserError;
  // A failed update shows the last good result, or the image as it is. If it returned 0 instead, views would have
  // nothing to draw, even after the mistake was corrected, and would report the error repeatedly.
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailDeformation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const vtkChainMail::Properties values = this->Internals->GetProperties();
  const auto name = [](auto value)
  {
    const char* const known = vtkChainMail::NameOf(value);
    return known ? known : "(unknown)";
  };
  os << indent << "MaterialPreset: " << name(values.MaterialPreset) << "\n";
  os << indent << "MaterialFunction: ";
  if (this->MaterialFunction)
  {
    os << "\n";
    this->MaterialFunction->PrintSelf(os, indent.GetNextIndent());
  }
  else
  {
    os << "(none)\n";
  }
  os << indent << "ConstraintArray: " << (this->ConstraintArray.empty() ? "(none)" : this->ConstraintArray) << "\n";
  os << indent << "BodyArray: " << (this->BodyArray.empty() ? "(none)" : this->BodyArray) << "\n";
  os << indent << "JointSize: " << this->JointSize << "\n";
  os << indent << "JointConstraint: " << this->JointConstraint << "\n";
  os << indent << "JointMargin: " << this->JointMargin << "\n";
  os << indent << "TissueThreshold: " << this->TissueThreshold << "\n";
  os << indent << "AnchorRigid: " << (this->AnchorRigid ? "On" : "Off") << "\n";
  os << indent << "AnchoredFaces:";
  for (int face : this->AnchoredFaces)
  {
    os << " " << face;
  }
  os << "\n";
  os << indent << "Mode: " << name(values.Mode) << "\n";
  os << indent << "PropagationMethod: " << name(values.PropagationMethod) << "\n";
  os << indent << "PropagationIterations: " << this->PropagationIterations << "\n";
  os << indent << "ConflictPolicy: " << name(values.ConflictPolicy) << "\n";
  os << indent << "ModelArrays:";
  for (int n = 0; n < this->ModelArraySelection->GetNumberOfArrays(); ++n)
  {
    os << (this->ModelArraySelection->GetArraySetting(n) ? " " : " no ") << this->ModelArraySelection->GetArrayName(n);
  }
  os << "\n";
  os << indent << "PropagationTimes: " << (this->PropagationTimes ? "On" : "Off") << "\n";
  os << indent << "RelaxationPreset: " << name(values.RelaxationPreset) << "\n";
  os << indent << "CoarseToFine: " << (this->CoarseToFine ? "On" : "Off") << "\n";
  os << indent << "RelaxationMethod: " << name(values.RelaxationMethod) << "\n";
  os << indent << "ElasticRecovery: " << this->ElasticRecovery << "\n";
  os << indent << "Rotations: " << (this->Rotations ? "On" : "Off") << "\n";
  os << indent << "PoissonRatio: " << this->PoissonRatio << "\n";
  os << indent << "RelaxationIterations: " << this->RelaxationIterations << "\n";
  os << indent << "RelaxationTolerance: " << this->RelaxationTolerance << "\n";
  os << indent << "RelaxationError: " << this->RelaxationError << "\n";
  os << indent << "ModelReduction: " << this->ModelReduction << "\n";
  os << indent << "Interpolation: " << name(values.Interpolation) << "\n";
  os << indent << "LabelArrays:";
  for (const std::string& name : this->LabelArrays)
  {
    os << " " << name;
  }
  os << "\n";
  os << indent << "BackgroundValue: " << this->BackgroundValue << "\n";
  os << indent << "OutputPadding: " << this->OutputPadding << "\n";
  os << indent << "OutputMagnification: " << this->OutputMagnification << "\n";
  os << indent << "UseOutputBounds: " << (this->UseOutputBounds ? "On" : "Off") << "\n";
  os << indent << "OutputBounds:";
  for (double bound : this->OutputBounds)
  {
    os << " " << bound;
  }
  os << "\n";
  os << indent << "SmoothCuts: " << (this->SmoothCuts ? "On" : "Off") << "\n";
  os << indent << "PullBack: " << (this->PullBack ? "On" : "Off") << "\n";
  os << indent << "ScalarSmoothing: " << this->ScalarSmoothing << "\n";
  os << indent << "Device: " << (this->Device.empty() ? "(best)" : this->Device) << "\n";
  os << indent << "BrickSize: " << this->BrickSize[0] << " " << this->BrickSize[1] << " " << this->BrickSize[2] << "\n";
}
