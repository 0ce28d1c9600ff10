// SPDX-License-Identifier: BSD-3-Clause
#include "Inputs.h"

#include "SpreadImage.h"

#include "Error.h"
#include "Model.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix3x3.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPointSet.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <utility>

namespace vtkChainMail
{

const std::array<PortKind, NUMBER_OF_PORTS> PortKinds = { {
  { "Input", "vtkImageData", nullptr },
  { "Probes", "vtkPointSet", "probes" },
  { "Cuts", "vtkPolyData", nullptr },
  { "Carves", "vtkPolyData", nullptr },
  { "Regions", "vtkPointSet", "regions" },
} };

namespace
{

Fingerprint OfCells(vtkCellArray* cells, Fingerprint before)
{
  const Fingerprint parts[] = { before, FingerprintOf(cells->GetOffsetsArray()),
    FingerprintOf(cells->GetConnectivityArray()) };
  return FingerprintOf(parts, sizeof(parts));
}

/// The part of a dataset that an update reads; null where it reads nothing. `problem` gets what is wrong with the
/// dataset.
vtkSmartPointer<vtkPolyData> TakeLeaf(int port, vtkDataObject* data, std::string& problem)
{
  auto leaf = vtkSmartPointer<vtkPolyData>::New();
  if (const char* things = PortKinds[port].Points)
  {
    vtkPointSet* points = vtkPointSet::SafeDownCast(data);
    if (!points)
    {
      problem = std::string(things) + " are points; give a point set such as a vtkPolyData.";
      return nullptr;
    }
    leaf->SetPoints(points->GetPoints());
    leaf->GetPointData()->ShallowCopy(points->GetPointData());
    return points->GetNumberOfPoints() > 0 ? leaf : nullptr;
  }
  vtkPolyData* surface = vtkPolyData::SafeDownCast(data);
  if (!surface)
  {
    problem = "surfaces are polygons; give a vtkPolyData (Extract Surface makes one).";
    return nullptr;
  }
  leaf->SetPoints(surface->GetPoints());
  leaf->SetPolys(surface->GetPolys());
  leaf->SetStrips(surface->GetStrips());
  return leaf->GetNumberOfPolys() > 0 || leaf->GetNumberOfStrips() > 0 ? leaf : nullptr;
}

/// The name that the user gave a block or, in a collection, the partitioned dataset that the block belongs to.
std::string NameOfBlock(vtkCompositeDataIterator* leaf, vtkCompositeDataSet* composite)
{
  vtkInformation* info = leaf->HasCurrentMetaData() ? leaf->GetCurrentMetaData() : nullptr;
  auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(composite);
  for (unsigned int n = 0; collection && n < collection->GetNumberOfPartitionedDataSets(); ++n)
  {
    for (unsigned int p = 0; p < collection->GetNumberOfPartitions(n); ++p)
    {
      if (collection->GetPartitionAsDataObject(n, p) == leaf->GetCurrentDataObject())
      {
        info = collection->HasMetaData(n) ? collection->GetMetaData(n) : info;
      }
    }
  }
  const char* name = info ? info->Get(vtkCompositeDataSet::NAME()) : nullptr;
  return name ? name : "";
}

}

std::string InputDataset::ToString() const
{
  return PortKinds[this->Port].Name + std::string(" input ") + std::to_string(this->Input) +
         (this->Block >= 0 ? ", block " + std::to_string(this->Block) : "") +
         (this->BlockName.empty() ? "" : " (" + this->BlockName + ")") +
         (this->Process > 0 ? " of process " + std::to_string(this->Process) : "");
}

Fingerprint InputDataset::GetFingerprint() const
{
  vtkPoints* points = this->Data->GetPoints();
  Fingerprint h = FingerprintOf(points ? points->GetData() : nullptr);
  if (PortKinds[this->Port].Points)
  {
    // All arrays, instead of a list of names that would have to be kept up to date.
    vtkPointData* arrays = this->Data->GetPointData();
    for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
    {
      const std::string name = arrays->GetArrayName(n) ? arrays->GetArrayName(n) : "";
      h = FingerprintOf(name.data(), name.size(), h);
      const Fingerprint parts[] = { h, FingerprintOf(arrays->GetArray(n)) }; // 0 where it has no numbers
      h = FingerprintOf(parts, sizeof(parts));
    }
    return h;
  }
  return OfCells(this->Data->GetStrips(), OfCells(this->Data->GetPolys(), h));
}

vtkImageData* Inputs::GetWhole() const
{
  return this->Spread ? this->Spread->GetWhole() : this->Image.Get();
}

Fingerprint Inputs::GetImageFingerprint() const
{
  Fingerprint h = 0;
  if (this->Image)
  {
    vtkImageData* image = this->Image;
    h = FingerprintOf(image->GetExtent(), 6 * sizeof(int), h);
    h = FingerprintOf(image->GetOrigin(), 3 * sizeof(double), h);
    h = FingerprintOf(image->GetSpacing(), 3 * sizeof(double), h);
    h = FingerprintOf(image->GetDirectionMatrix()->GetData(), 9 * sizeof(double), h);
    const std::array<vtkFieldData*, 3> groups = { { image->GetPointData(), image->GetCellData(),
      image->GetFieldData() } };
    for (vtkFieldData* group : groups)
    {
      for (int a = 0; a < group->GetNumberOfArrays(); ++a)
      {
        vtkAbstractArray* array = group->GetAbstractArray(a);
        const std::string name = array->GetName() ? array->GetName() : "";
        vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
        const Fingerprint values = numbers ? FingerprintOf(numbers) : array->GetMTime();
        h = FingerprintOf(name.data(), name.size(), FingerprintOf(&values, sizeof(values), h));
      }
    }
    for (vtkDataSetAttributes* group : { static_cast<vtkDataSetAttributes*>(image->GetPointData()),
           static_cast<vtkDataSetAttributes*>(image->GetCellData()) })
    {
      int active[vtkDataSetAttributes::NUM_ATTRIBUTES];
      group->GetAttributeIndices(active);
      h = FingerprintOf(active, sizeof(active), h);
    }
  }
  return h;
}

Fingerprint Inputs::GetLeavesFingerprint() const
{
  Fingerprint h = 0;
  for (const InputDataset& leaf : this->Leaves)
  {
    const int place[] = { leaf.Port, leaf.Input, leaf.Block };
    const Fingerprint values = leaf.GetFingerprint();
    h = FingerprintOf(place, sizeof(place), FingerprintOf(&values, sizeof(values), h));
  }
  return h;
}

Inputs CollectInputs(vtkInformationVector** inputs)
{
  Inputs all;
  if (vtkInformation* info = inputs[IMAGE]->GetInformationObject(0))
  {
    vtkDataObject* data = info->Get(vtkDataObject::DATA_OBJECT());
    all.Image = vtkImageData::SafeDownCast(data);
    all.IsReleased =
      info->Get(vtkDemandDrivenPipeline::RELEASE_DATA()) != 0 || vtkDataObject::GetGlobalReleaseDataFlag() != 0;
    if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), all.WholeExtent.data());
    }
    if (data && !all.Image)
    {
      all.Problem = "The input is a " + std::string(data->GetClassName()) +
                    ", but the filter deforms a single image (vtkImageData). Use a filter for each image, or make one "
                    "image of all with Resample To Image.";
    }
    if (all.Image && all.Image->GetNumberOfPoints() > 0)
    {
      chainmail::Grid grid;
      all.Image->GetDimensions(grid.size.data());
      all.Image->GetSpacing(grid.spacing.data());
      try
      {
        grid.check(); // before any array of the image is read
      }
      catch (const chainmail::InputError& error)
      {
        all.Problem = error.what();
      }
    }
  }

  for (int port = PROBES; port < NUMBER_OF_PORTS; ++port)
  {
    for (int input = 0; input < inputs[port]->GetNumberOfInformationObjects(); ++input)
    {
      const auto take = [&](vtkDataObject* data, int block, const std::string& name)
      {
        InputDataset leaf;
        leaf.Port = port;
        leaf.Input = input;
        leaf.Block = block;
        leaf.BlockName = name;
        std::string problem;
        leaf.Data = TakeLeaf(port, data, problem);
        if (leaf.Data)
        {
          all.Leaves.push_back(leaf);
        }
        if (!problem.empty() && all.Problem.empty())
        {
          all.Problem = leaf.ToString() + " is a " + data->GetClassName() + ": " + problem;
        }
      };
      vtkDataObject* data = vtkDataObject::GetData(inputs[port], input);
      if (auto composite = vtkCompositeDataSet::SafeDownCast(data))
      {
        const auto leaves = vtk::TakeSmartPointer(composite->NewIterator());
        for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
        {
          take(leaves->GetCurrentDataObject(), static_cast<int>(leaves->GetCurrentFlatIndex()),
            NameOfBlock(leaves, composite));
        }
      }
      else if (data)
      {
        take(data, -1, {});
      }
    }
  }
  return all;
}

bool InputWatch::IsUnchanged(vtkInformationVector** connected, const Inputs& inputs, vtkMTimeType filterTime)
{
  // Equal times prove quickly that nothing changed. Different times do not prove a change, because a reader runs again
  // for every piece. Contents are compared then.
  const auto isUnchanged = [connected](Watched& watched, int firstPort, int endPort, const auto& fingerprint)
  {
    decltype(watched.Times) times;
    for (int port = firstPort; port < endPort; ++port)
    {
      for (int input = 0; input < connected[port]->GetNumberOfInformationObjects(); ++input)
      {
        vtkDataObject* data = vtkDataObject::GetData(connected[port], input);
        times.emplace_back(data, data ? data->GetMTime() : 0, data ? data->GetUpdateTime() : 0);
      }
      times.emplace_back(); // the end of a port
    }
    if (times == watched.Times)
    {
      return true;
    }
    const Fingerprint before = watched.Contents;
    watched.Times = std::move(times);
    watched.Contents = fingerprint();
    return watched.Contents == before;
  };
  const bool sameProblem = this->Problem == inputs.Problem;
  const bool sameFilter = this->FilterTime == filterTime;
  this->Problem = inputs.Problem;
  this->FilterTime = filterTime;
  if (!inputs.Problem.empty())
  {
    // Image and leaves are not read now, so forget their former contents.
    this->Image = Watched();
    this->Leaves = Watched();
    this->SameImage = false;
    return sameProblem && sameFilter;
  }
  this->SameImage = isUnchanged(this->Image, IMAGE, IMAGE + 1, [&] { return inputs.GetImageFingerprint(); });
  const bool sameLeaves =
    isUnchanged(this->Leaves, PROBES, NUMBER_OF_PORTS, [&] { return inputs.GetLeavesFingerprint(); });
  return sameProblem && sameFilter && this->SameImage && sameLeaves;
}

}
