// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailCarry.h"

#include "Private/Carrying.h"
#include "Private/Exchange.h"
#include "Private/Pipeline.h"

#include "Error.h"

#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPointSet.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"
#include "vtkUniformGridAMR.h"

#include <algorithm>
#include <array>
#include <new>
#include <set>

using chainmail::InputError;
using vtkChainMail::Carrying;
using vtkChainMail::Exchange;
using vtkChainMail::Extent;
using Pipeline = vtkStreamingDemandDrivenPipeline;

namespace
{

enum Ports
{
  INPUT,
  DEFORMATION
};

Extent ExtentIn(vtkInformation* info, vtkInformationIntegerVectorKey* key)
{
  Extent extent{ { 0, -1, 0, -1, 0, -1 } };
  if (info->Has(key))
  {
    info->Get(key, extent.data());
  }
  return extent;
}

}

//------------------------------------------------------------------------------
class vtkChainMailCarry::vtkInternals
{
public:
  explicit vtkInternals(vtkChainMailCarry* self)
    : Self(self)
  {
  }

  /// Whether the processes of a parallel server request one piece each, all at once.
  bool IsParallel(vtkInformation* output) const
  {
    vtkMultiProcessController* controller = this->Self->Controller;
    const int pieces = output->Get(Pipeline::UPDATE_NUMBER_OF_PIECES());
    return controller && pieces > 1 && controller->GetNumberOfProcesses() == pieces &&
           controller->GetLocalProcessId() == output->Get(Pipeline::UPDATE_PIECE_NUMBER());
  }

  /// Reads the deformation again if it has changed since the last update. All processes have to call this.
  void Read(const Exchange& exchange, vtkImageData* part, const Extent& whole)
  {
    std::vector<Source> sources;
    for (const char* name : { "Displacement", "Element", "Links" })
    {
      vtkAbstractArray* array = part->GetPointData()->GetAbstractArray(name);
      sources.push_back({ array, array ? array->GetMTime() : 0 });
    }
    sources.push_back({ nullptr, part->GetMTime() });
    const bool isSame = this->Map && sources == this->Sources;
    if (exchange.All(isSame))
    {
      return;
    }
    this->Map.reset();
    this->Sources.clear();
    std::string problem;
    const auto model = exchange.Assemble(part, whole, problem);
    if (!problem.empty())
    {
      throw InputError(problem);
    }
    auto error = vtkStringArray::SafeDownCast(model->GetFieldData()->GetAbstractArray("Error"));
    if (error && error->GetNumberOfValues() > 0 && !model->GetPointData()->HasArray("Displacement"))
    {
      throw InputError("ChainMail Deformation failed: " + error->GetValue(0));
    }
    this->Map = std::make_unique<Carrying>(model);
    this->Sources = sources;
  }

  void Carry(const Exchange& exchange, vtkDataObject* input, const Extent& whole, Extent extent, vtkDataObject* output)
  {
    Carrying::Options options;
    options.Backward = this->Self->Direction == DIRECTION_BACKWARD;
    options.Nearest = this->Self->Interpolation == INTERPOLATION_NEAREST;
    options.Background = this->Self->FitBackground ? vtkMath::Nan() : this->Self->BackgroundValue;
    options.IsLabelArray = [this](const std::string& name) { return this->Self->HasLabelArray(name.c_str()); };
    options.Progress = [this](double done)
    {
      this->Self->UpdateProgress(done);
      if (this->Self->GetAbortExecute())
      {
        throw chainmail::Aborted();
      }
    };
    if (auto* composite = vtkCompositeDataSet::SafeDownCast(input))
    {
      this->Carry(composite, options, vtkCompositeDataSet::SafeDownCast(output));
    }
    else if (auto* image = vtkImageData::SafeDownCast(input))
    {
      std::string problem;
      const auto all = exchange.Assemble(image, whole, problem);
      if (!problem.empty())
      {
        throw InputError(problem);
      }
      this->Carry(all, options, extent, vtkImageData::SafeDownCast(output));
    }
    else
    {
      this->CarryPoints(input, options, output);
    }
  }

  vtkChainMailCarry* Self;

private:
  void Carry(vtkCompositeDataSet* input, const Carrying::Options& options, vtkCompositeDataSet* output)
  {
    if (input->IsA("vtkUniformGridAMR"))
    {
      throw InputError("An image of several resolutions (AMR) cannot be carried. Put Resample To Image before this "
                       "filter.");
    }
    output->CopyStructure(input);
    output->GetFieldData()->ShallowCopy(input->GetFieldData());
    const auto leaves = vtkSmartPointer<vtkCompositeDataIterator>::Take(input->NewIterator());
    for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
    {
      vtkDataObject* leaf = leaves->GetCurrentDataObject();
      const auto carried = vtkSmartPointer<vtkDataObject>::Take(leaf->NewInstance());
      if (auto* image = vtkImageData::SafeDownCast(leaf))
      {
        this->Carry(image, options, vtkChainMail::ExtentOf(image), vtkImageData::SafeDownCast(carried));
      }
      else
      {
        this->CarryPoints(leaf, options, carried);
      }
      output->SetDataSet(leaves, carried);
    }
  }

  void CarryPoints(vtkDataObject* input, const Carrying::Options& options, vtkDataObject* output)
  {
    auto* points = vtkPointSet::SafeDownCast(input);
    if (!points)
    {
      throw InputError("A " + std::string(input->GetClassName()) +
                       " cannot be carried: give points, a mesh or an image. Table To Points converts a table to "
                       "points, Resample To Image other grids to an image.");
    }
    this->Map->Carry(points, options, vtkPointSet::SafeDownCast(output));
  }

  void Carry(vtkImageData* input, const Carrying::Options& options, const Extent& extent, vtkImageData* output)
  {
    const std::vector<std::string> lost = this->Map->Carry(input, options, extent, output);
    if (!vtkChainMail::Contains(extent, vtkChainMail::ExtentOf(output)))
    {
      output->GetPointData()->CopyAllOn();
      output->GetCellData()->CopyAllOn();
      output->Crop(extent.data());
    }
    const std::set<std::string> names(lost.begin(), lost.end());
    if (!names.empty() && names != this->LostArrays)
    {
      std::string list;
      for (const std::string& name : names)
      {
        list += (list.empty() ? "" : ", ") + name;
      }
      vtkWarningWithObjectMacro(
        this->Self, "The output has no cell arrays, because only point arrays of images are carried. Left out: "
                      << list << ". To carry them, put Cell Data to Point Data before this filter.");
    }
    this->LostArrays = names;
  }

  /// An array of the deformation and the time of its last change. Keeping a reference prevents another array from being
  /// allocated at the same address.
  struct Source
  {
    vtkSmartPointer<vtkAbstractArray> Array;
    vtkMTimeType Time;
    bool operator==(const Source& other) const { return this->Array == other.Array && this->Time == other.Time; }
  };

  std::unique_ptr<Carrying> Map;
  std::vector<Source> Sources;
  std::set<std::string> LostArrays; // already warned about
};

//------------------------------------------------------------------------------
vtkStandardNewMacro(vtkChainMailCarry);

//------------------------------------------------------------------------------
vtkChainMailCarry::vtkChainMailCarry()
  : Controller(vtkMultiProcessController::GetGlobalController())
  , Internals(new vtkInternals(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkChainMailCarry::~vtkChainMailCarry() = default;

//------------------------------------------------------------------------------
void vtkChainMailCarry::AddLabelArray(const char* name)
{
  if (name && *name && !this->HasLabelArray(name))
  {
    this->LabelArrays.emplace_back(name);
    this->Modified();
  }
}

void vtkChainMailCarry::RemoveLabelArray(const char* name)
{
  if (this->HasLabelArray(name))
  {
    this->LabelArrays.erase(std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name));
    this->Modified();
  }
}

void vtkChainMailCarry::ClearLabelArrays()
{
  if (!this->LabelArrays.empty())
  {
    this->LabelArrays.clear();
    this->Modified();
  }
}

int vtkChainMailCarry::GetNumberOfLabelArrays() const
{
  return static_cast<int>(this->LabelArrays.size());
}

const char* vtkChainMailCarry::GetLabelArray(int index) const
{
  return index >= 0 && index < this->GetNumberOfLabelArrays() ? this->LabelArrays[index].c_str() : nullptr;
}

bool vtkChainMailCarry::HasLabelArray(const char* name) const
{
  return name && std::find(this->LabelArrays.begin(), this->LabelArrays.end(), name) != this->LabelArrays.end();
}

//------------------------------------------------------------------------------
void vtkChainMailCarry::SetController(vtkMultiProcessController* controller)
{
  if (this->Controller != controller)
  {
    this->Controller = controller;
    this->Modified();
  }
}

vtkMultiProcessController* vtkChainMailCarry::GetController()
{
  return this->Controller;
}

//------------------------------------------------------------------------------
int vtkChainMailCarry::FillInputPortInformation(int port, vtkInformation* info)
{
  // Any data object is accepted, so that the error for an unsupported one can say what to do. A composite dataset is
  // accepted as a whole because all processes have to take part in each update, whichever blocks they have.
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), port == INPUT ? "vtkDataObject" : "vtkImageData");
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailCarry::RequestInformation(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* output = outputVector->GetInformationObject(0);
  vtkChainMail::MergedTimes(inputVector, this->GetNumberOfInputPorts()).Tell(output);
  if (vtkImageData::GetData(inputVector[INPUT]))
  {
    output->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), 1);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailCarry::RequestUpdateExtent(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* output = outputVector->GetInformationObject(0);
  vtkInformation* model = inputVector[DEFORMATION]->GetInformationObject(0);
  if (!this->Internals->IsParallel(output))
  {
    const bool isImage = vtkImageData::GetData(inputVector[INPUT]) != nullptr;
    if (isImage) // a part of it may come from anywhere
    {
      vtkChainMail::AskForAll(inputVector, 1);
    }
    vtkChainMail::AskForAll(inputVector + DEFORMATION, 1);
    return 1;
  }
  // Each process requests a piece, because then the deformation computes once for all of them. The executive splits
  // this extent into pieces when it executes the deformation.
  const Extent whole = ExtentIn(model, Pipeline::WHOLE_EXTENT());
  model->Set(Pipeline::UPDATE_EXTENT(), whole.data(), 6);
  model->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  return 1;
}

//------------------------------------------------------------------------------
int vtkChainMailCarry::RequestData(
  vtkInformation* vtkNotUsed(request), vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* info = outputVector->GetInformationObject(0);
  vtkInformation* inputInfo = inputVector[INPUT]->GetInformationObject(0);
  vtkInformation* modelInfo = inputVector[DEFORMATION]->GetInformationObject(0);
  vtkDataObject* input = inputInfo->Get(vtkDataObject::DATA_OBJECT());
  vtkDataObject* output = info->Get(vtkDataObject::DATA_OBJECT());
  const Exchange exchange(this->Internals->IsParallel(info) ? this->Controller.Get() : nullptr);

  const Extent whole = ExtentIn(inputInfo, Pipeline::WHOLE_EXTENT());
  const bool isOnePiece = info->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()) <= 1;
  const Extent extent = isOnePiece ? whole : ExtentIn(info, Pipeline::UPDATE_EXTENT());
  std::string problem;
  bool isStopped = false;
  try
  {
    this->Internals->Read(exchange, vtkImageData::GetData(modelInfo), ExtentIn(modelInfo, Pipeline::WHOLE_EXTENT()));
    this->Internals->Carry(exchange, input, whole, extent, output);
  }
  catch (const chainmail::Aborted&)
  {
    isStopped = true;
    problem = "The update was stopped.";
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough main memory to carry this input. Crop it, or reduce its voxels or points.";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  if (!problem.empty())
  {
    if (!isStopped)
    {
      vtkErrorMacro(<< problem);
    }
    output->Initialize();
    output->ShallowCopy(input);
    vtkNew<vtkStringArray> error;
    error->SetName("Error");
    error->InsertNextValue(problem);
    vtkNew<vtkFieldData> fields;
    fields->ShallowCopy(input->GetFieldData());
    fields->AddArray(error);
    output->SetFieldData(fields);
  }
  // SetErrorCode() would make this update out of date.
  this->ErrorCode = problem.empty() || isStopped ? vtkErrorCode::NoError : vtkErrorCode::UserError;
  return 1; // downstream filters have something to show, and do not report the error again
}

//------------------------------------------------------------------------------
void vtkChainMailCarry::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Direction: " << (this->Direction == DIRECTION_BACKWARD ? "Backward" : "Forward") << "\n";
  os << indent << "Interpolation: " << (this->Interpolation == INTERPOLATION_NEAREST ? "Nearest" : "Linear") << "\n";
  os << indent << "LabelArrays:";
  for (const std::string& name : this->LabelArrays)
  {
    os << " " << name;
  }
  os << "\n";
  os << indent << "FitBackground: " << (this->FitBackground ? "On" : "Off") << "\n";
  os << indent << "BackgroundValue: " << this->BackgroundValue << "\n";
  os << indent << "Controller: " << this->Controller.Get() << "\n";
}
