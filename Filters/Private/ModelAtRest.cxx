// SPDX-License-Identifier: BSD-3-Clause
#include "ModelAtRest.h"

#include "Arrays.h"
#include "CarryCells.h"
#include "Threads.h"

#include "vtkDataArraySelection.h"
#include "vtkFloatArray.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vtkChainMail
{

namespace
{

const char* const names[] = { "Displacement", "Element", "Links", "Constraint", "Cluster", "PropagationTime",
  "Wavefront" };

std::size_t BytesOf(vtkDataArray* array)
{
  return static_cast<std::size_t>(array->GetNumberOfValues()) * static_cast<std::size_t>(array->GetDataTypeSize());
}

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

const std::array<const char*, 4> ModelAtRest::Choices = { "Displacement", "Element", "Constraint", "Cluster" };

bool ModelAtRest::IsDefault(const std::string& array)
{
  return array == "Displacement" || array == "Element";
}

bool ModelAtRest::IsWanted(int array, vtkDataArraySelection* chosen) const
{
  switch (array)
  {
  case LINKS: // tell to which side of a cut a displacement belongs
    return chosen->ArrayIsEnabled(names[DISPLACEMENT]) && this->Plan.IsCut;
  case TIME:
  case WAVEFRONT:
    return false; // these are not chosen
  default:
    return chosen->ArrayIsEnabled(names[array]) != 0;
  }
}

/// Changes where an array changes that updates may share; -1 where each update makes it anew.
int ModelAtRest::VersionOf(int array) const
{
  return array == ELEMENT || array == CONSTRAINT ? this->Plan.TissueChanges
         : array == LINKS || array == CLUSTER    ? this->Plan.LinkChanges
                                                 : -1;
}

vtkSmartPointer<vtkImageData> ModelAtRest::Write(const Team& team, Steps& steps, const OutputPlan& plan,
  vtkDataArraySelection* chosen, bool times, const Extent& extent)
{
  const bool isSamePart = extent == this->Part && this->Plan.Whole && plan.Builds == this->Plan.Builds;
  this->Plan = plan;
  this->Part = extent;
  for (SharedArray<vtkDataArray>& shared : this->Shared)
  {
    if (!isSamePart)
    {
      shared.Forget();
    }
  }
  const auto part = vtkSmartPointer<vtkImageData>::New();
  part->SetOrigin(plan.Whole->GetOrigin());
  part->SetSpacing(plan.Whole->GetSpacing());
  part->SetDirectionMatrix(plan.Whole->GetDirectionMatrix());
  part->SetExtent(const_cast<int*>(extent.data()));
  this->Choose(team, steps, chosen, part);
  if (times)
  {
    std::array<bool, NUMBER_OF_ARRAYS> missing{};
    missing[TIME] = missing[WAVEFRONT] = true;
    std::array<vtkSmartPointer<vtkDataArray>, NUMBER_OF_ARRAYS> arrays;
    this->Begin(steps, 0.98, 1.0);
    this->Fetch(team, steps, missing, part, arrays);
    this->Reports.EndPart();
    for (const int array : { TIME, WAVEFRONT })
    {
      if (arrays[array])
      {
        part->GetPointData()->AddArray(arrays[array]);
      }
    }
  }
  return part;
}

void ModelAtRest::Begin(Steps& steps, double from, double to)
{
  steps.Run(
    [&]
    {
      if (!this->Reports.BeginPart(DOWNLOAD, from, to))
      {
        throw chainmail::Aborted();
      }
    });
}

void ModelAtRest::Choose(const Team& team, Steps& steps, vtkDataArraySelection* chosen, vtkImageData* part)
{
  vtkPointData* output = part->GetPointData();
  std::array<bool, NUMBER_OF_ARRAYS> missing{};
  std::array<vtkSmartPointer<vtkDataArray>, NUMBER_OF_ARRAYS> arrays;
  for (int array = 0; array < TIME; ++array)
  {
    SharedArray<vtkDataArray>& shared = this->Shared[array];
    if (!this->IsWanted(array, chosen))
    {
      shared.Forget();
      output->RemoveArray(names[array]);
      if (array == DISPLACEMENT)
      {
        this->Displacements.Forget();
      }
    }
    else if (!output->HasArray(names[array]))
    {
      const bool isKept = this->VersionOf(array) >= 0 && shared.IsIntact(this->VersionOf(array));
      arrays[array] = isKept ? shared.Get() : nullptr;
      missing[array] = !isKept;
    }
  }
  if (std::find(missing.begin(), missing.end(), true) != missing.end())
  {
    this->Begin(steps, 0.9, 0.98);
  }
  this->Fetch(team, steps, missing, part, arrays);
  this->Reports.EndPart();
  steps.Run(
    [&]
    {
      for (int array = 0; array < TIME; ++array)
      {
        if (missing[array] && arrays[array] && this->VersionOf(array) >= 0)
        {
          this->Shared[array].Set(arrays[array], this->VersionOf(array));
        }
        if (arrays[array])
        {
          output->AddArray(arrays[array]);
        }
      }
      if (arrays[DISPLACEMENT])
      {
        this->Displacements.Trim();
        output->SetVectors(arrays[DISPLACEMENT]);
      }
      // Writers of a single array, such as that of MetaImage, write the active scalars.
      const int most = this->IsWanted(DISPLACEMENT, chosen) ? DISPLACEMENT : ELEMENT;
      if (this->IsWanted(most, chosen))
      {
        output->SetActiveScalars(names[most]);
      }
    });
}

/// Makes what is missing, in all processes: the root reads it for each of them.
void ModelAtRest::Fetch(const Team& team, Steps& steps, const std::array<bool, NUMBER_OF_ARRAYS>& missing,
  vtkImageData* part, std::array<vtkSmartPointer<vtkDataArray>, NUMBER_OF_ARRAYS>& arrays)
{
  const Extent extent = ExtentOf(part);
  std::vector<int> mine(extent.begin(), extent.end());
  for (const bool one : missing)
  {
    mine.push_back(one && !IsEmpty(extent) ? 1 : 0);
  }
  const std::vector<int> all = team.GetLink().ToRoot(mine);
  std::array<bool, NUMBER_OF_ARRAYS> isThere{};
  for (int array = 0; array < NUMBER_OF_ARRAYS; ++array)
  {
    if (missing[array] && !IsEmpty(extent))
    {
      steps.Run(
        [&]
        {
          const vtkIdType voxels = part->GetNumberOfPoints();
          arrays[array] = array == DISPLACEMENT ? this->MakeDisplacement(voxels) : this->Make(array, voxels);
        });
    }
  }
  const auto lead = [&]
  {
    for (int p = 0; p < team.GetLink().GetSize(); ++p)
    {
      const int* given = all.data() + mine.size() * static_cast<std::size_t>(p);
      Extent other;
      std::copy_n(given, 6, other.begin());
      for (int array = 0; array < NUMBER_OF_ARRAYS; ++array)
      {
        if (given[6 + array] != 0 && p == Exchange::Root)
        {
          this->Read(array, this->Plan.BoxOf(other), arrays[array]->GetVoidPointer(0));
          isThere[array] = true;
        }
        else if (given[6 + array] != 0)
        {
          this->Send(team, array, this->Plan.BoxOf(other), p);
        }
      }
    }
  };
  const auto take = [&](int array, int layer)
  {
    const chainmail::VoxelBox box = this->Plan.BoxOf(extent);
    vtkDataArray* const values = arrays[array];
    isThere[array] = layer == box.size[2];
    if (!isThere[array])
    {
      const std::size_t first = box.at(box.first[0], box.first[1], box.first[2] + layer);
      char* const memory =
        values ? static_cast<char*>(values->GetVoidPointer(0)) + BytesOfVoxel(values) * first : nullptr;
      team.GetLink().ReceiveSparse(memory, Exchange::Root);
    }
  };
  team.Lead(steps, lead, take);
  for (int array = 0; array < NUMBER_OF_ARRAYS; ++array)
  {
    steps.Run(
      [&]
      {
        if (missing[array] && !IsEmpty(extent) && !isThere[array])
        {
          throw FailedElsewhere();
        }
      });
  }
}

/// Sends the values of a box to a process, in slabs that this process can read at once.
void ModelAtRest::Send(const Team& team, int array, const chainmail::VoxelBox& box, int to) const
{
  constexpr std::size_t most = std::size_t(1) << 24; // [bytes]
  chainmail::VoxelBox slab = box;
  slab.size[2] = 1;
  const std::size_t layer = BytesOf(this->Make(array, 1)) * slab.voxels();
  // Clusters are searched for in the whole grid, so all are read at once.
  const int layers = array == CLUSTER ? box.size[2] : static_cast<int>(std::max<std::size_t>(1, most / layer));
  for (int k = 0; k < box.size[2]; k += layers)
  {
    slab.first[2] = box.first[2] + k;
    slab.size[2] = std::min(layers, box.size[2] - k);
    const vtkSmartPointer<vtkDataArray> values = this->Make(array, static_cast<vtkIdType>(slab.voxels()));
    this->Read(array, slab, values->GetVoidPointer(0));
    team.Offer(to, array, k);
    team.GetLink().SendSparse(static_cast<const char*>(values->GetVoidPointer(0)), BytesOf(values), to);
  }
  team.Offer(to, array, box.size[2]);
}

vtkSmartPointer<vtkDataArray> ModelAtRest::Make(int array, vtkIdType voxels) const
{
  switch (array)
  {
  case DISPLACEMENT:
    return MakeArray<vtkFloatArray>(names[array], 3, voxels, true);
  case ELEMENT:
  case LINKS:
    return MakeArray<vtkUnsignedCharArray>(names[array], 1, voxels, true);
  case CLUSTER:
  case WAVEFRONT:
    return MakeArray<vtkIntArray>(names[array], this->Plan.Axes, voxels, true);
  default:
    return MakeArray<vtkFloatArray>(names[array], this->Plan.Axes, voxels, true);
  }
}

vtkSmartPointer<vtkDataArray> ModelAtRest::MakeDisplacement(vtkIdType voxels)
{
  const vtkSmartPointer<vtkDataArray> array = this->Make(DISPLACEMENT, 0);
  this->Displacements.Lend(array, sizeof(float) * 3 * static_cast<std::size_t>(voxels));
  return array;
}

void ModelAtRest::Read(int array, const chainmail::VoxelBox& box, void* out) const
{
  const chainmail::Simulation& simulation = this->Source.GetSimulation();
  switch (array)
  {
  case DISPLACEMENT:
    return this->ReadDisplacement(box, static_cast<float*>(out));
  case ELEMENT:
    return simulation.elements(box, static_cast<unsigned char*>(out));
  case LINKS:
    return this->ReadLinks(box, static_cast<unsigned char*>(out));
  case CONSTRAINT:
    return this->ReadConstraint(box, static_cast<float*>(out));
  case CLUSTER:
    return simulation.clusters(box, static_cast<int*>(out));
  case TIME:
    return this->ReadTime(box, static_cast<float*>(out));
  default:
    return simulation.wavefronts(box, static_cast<int*>(out), true);
  }
}

namespace
{

/// Calls f(row, at) for each row of the box, with its constraints at rest, before any carve, and the place of its first
/// voxel in an array over the box.
template <typename F> void ForRowsAtRest(const chainmail::Model& model, const chainmail::VoxelBox& box, const F& f)
{
  std::vector<float> row(static_cast<std::size_t>(box.size[0]) * model.axes());
  std::size_t at = 0;
  for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
  {
    for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j, at += box.size[0])
    {
      model.row(box.first[0], j, k, box.size[0], row.data());
      f(row.data(), at);
    }
  }
}

}

void ModelAtRest::ReadLinks(const chainmail::VoxelBox& box, unsigned char* links) const
{
  constexpr unsigned char carved = chainmail::RestModel::carved;
  const int axes = this->Plan.Axes;
  std::vector<unsigned char> element(box.voxels());
  this->Source.GetSimulation().elements(box, element.data());
  this->Source.GetSimulation().links(box, links, true);
  ForRowsAtRest(this->Source.GetModel(), box,
    [&](const float* row, std::size_t at)
    {
      for (int i = 0; i < box.size[0]; ++i)
      {
        if (element[at + i] == 0 && !std::isinf(row[static_cast<std::size_t>(i) * axes]))
        {
          links[at + i] = carved;
        }
      }
    });
}

void ModelAtRest::ReadConstraint(const chainmail::VoxelBox& box, float* constraint) const
{
  const int axes = this->Plan.Axes;
  std::vector<unsigned char> element(box.voxels());
  this->Source.GetSimulation().elements(box, element.data());
  ForRowsAtRest(this->Source.GetModel(), box,
    [&](const float* row, std::size_t at)
    {
      for (int i = 0; i < box.size[0]; ++i)
      {
        // The engine marks air by an infinite constraint, and anchors by a negative one.
        for (int a = 0; a < axes; ++a)
        {
          const std::size_t n = static_cast<std::size_t>(i) * axes + a;
          constraint[at * axes + n] = element[at + i] != 0 ? std::fabs(row[n]) : 0.0f;
        }
      }
    });
}

void ModelAtRest::ReadDisplacement(const chainmail::VoxelBox& box, float* u) const
{
  this->Source.GetSimulation().displacements(box, u, true);
  const Frame space(this->Plan.Whole);
  if (space.IsRotated())
  {
    ForPortions(static_cast<vtkIdType>(box.voxels()),
      [&](vtkIdType first, vtkIdType last)
      {
        for (vtkIdType v = first; v < last; ++v)
        {
          if (u[3 * v] != 0.0f || u[3 * v + 1] != 0.0f || u[3 * v + 2] != 0.0f)
          {
            space.VectorToWorld(u + 3 * v, u + 3 * v);
          }
        }
      });
  }
}

void ModelAtRest::ReadTime(const chainmail::VoxelBox& box, float* t) const
{
  const int axes = this->Plan.Axes;
  this->Source.GetSimulation().propagationTimes(box, t);
  const Frame space(this->Plan.Whole);
  const Vector3& spacing = space.GetSpacing();
  ForPortions(static_cast<vtkIdType>(box.voxels()),
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
}

void ModelAtRest::WriteBodies(vtkImageData* image) const
{
  image->CopyStructure(this->Plan.Whole);
  image->GetPointData()->Initialize();
  if (const vtkSmartPointer<vtkDataArray> labels = this->Source.GetBodyArray())
  {
    image->GetPointData()->AddArray(labels);
  }
  const vtkSmartPointer<vtkDataArray> cluster = this->Make(CLUSTER, this->Plan.Whole->GetNumberOfPoints());
  this->Read(CLUSTER, { {}, this->Plan.GetSize() }, cluster->GetVoidPointer(0));
  image->GetPointData()->AddArray(cluster);
}

}
