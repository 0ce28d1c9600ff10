// SPDX-License-Identifier: BSD-3-Clause
#include "BodyMiddles.h"

#include "Text.h"

#include "vtkCommunicator.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cstring>

namespace vtkChainMail
{

namespace
{

/// The bodies of all processes, sorted and unique. They are sent as doubles, which hold labels up to 2^53.
std::vector<double> BodiesOfAll(const std::vector<BodyMotion>& motions, vtkMultiProcessController* controller)
{
  std::vector<double> mine;
  for (const BodyMotion& motion : motions)
  {
    mine.push_back(static_cast<double>(motion.Body));
  }
  std::vector<double> all = mine;
  if (controller && controller->GetNumberOfProcesses() > 1)
  {
    const auto count = static_cast<vtkIdType>(mine.size());
    std::vector<vtkIdType> counts(static_cast<std::size_t>(controller->GetNumberOfProcesses()));
    std::vector<vtkIdType> offsets(counts.size());
    controller->AllGather(&count, counts.data(), 1);
    vtkIdType total = 0;
    for (std::size_t p = 0; p < counts.size(); ++p)
    {
      offsets[p] = total;
      total += counts[p];
    }
    all.resize(static_cast<std::size_t>(total) + 1); // a buffer of 0 elements has no memory
    mine.resize(mine.size() + 1);
    controller->AllGatherV(mine.data(), all.data(), count, counts.data(), offsets.data());
    all.pop_back();
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// Gives `frame` the origin, spacing and direction of the first process with voxels of the image. Returns false where
/// no process has any.
bool TakeFrame(vtkImageData* mine, vtkMultiProcessController* controller, vtkImageData* frame)
{
  std::array<double, 16> numbers{}; // 1 if this process has voxels, origin, spacing, direction
  if (mine && mine->GetNumberOfPoints() > 0)
  {
    numbers[0] = 1.0;
    std::copy(mine->GetOrigin(), mine->GetOrigin() + 3, &numbers[1]);
    std::copy(mine->GetSpacing(), mine->GetSpacing() + 3, &numbers[4]);
    const double* const direction = mine->GetDirectionMatrix()->GetData();
    std::copy(direction, direction + 9, &numbers[7]);
  }
  if (controller && controller->GetNumberOfProcesses() > 1)
  {
    std::vector<double> all(16 * static_cast<std::size_t>(controller->GetNumberOfProcesses()));
    controller->AllGather(numbers.data(), all.data(), 16);
    for (std::size_t p = all.size(); p >= 16; p -= 16)
    {
      if (all[p - 16] == 1.0)
      {
        std::copy(&all[p - 16], &all[p - 16] + 16, numbers.begin());
      }
    }
  }
  frame->SetOrigin(&numbers[1]);
  frame->SetSpacing(&numbers[4]);
  frame->SetDirectionMatrix(&numbers[7]);
  return numbers[0] == 1.0;
}

}

//------------------------------------------------------------------------------
std::string BodyMiddles::Find(
  vtkImageData* labels, vtkInformation* info, const std::string& arrayName, const std::vector<BodyMotion>& motions)
{
  vtkMultiProcessController* const controller = vtkMultiProcessController::GetGlobalController();
  const std::vector<double> bodies = BodiesOfAll(motions, controller);
  // For each body: the number of voxels and the sums of their indices i, j, k. These are integers, so neither the order
  // nor the number of processes matters.
  std::vector<long long> sums(4 * bodies.size() + 1);
  std::string problem;
  vtkDataArray* array = nullptr;
  int extent[6] = { 0, -1, 0, -1, 0, -1 };
  if (labels && labels->GetNumberOfPoints() > 0)
  {
    labels->GetExtent(extent);
    vtkPointData* arrays = labels->GetPointData();
    array = arrayName.empty() ? arrays->GetScalars() : arrays->GetArray(arrayName.c_str());
    if (!array || array->GetNumberOfComponents() != 1)
    {
      problem =
        (arrayName.empty()
            ? std::string("LabelArray is empty, but the image of labels has no active point array of one component. ")
            : "LabelArray is \"" + arrayName +
                "\", but the image of labels has no such point array of one component. ") +
        ListArrays(arrays);
      array = nullptr;
    }
  }
  if (array)
  {
    // Neighbouring pieces share the voxels at their border. A voxel at the upper end of a piece is counted by the next
    // piece, except at the end of the whole extent.
    int whole[6];
    std::memcpy(whole, extent, sizeof(whole));
    if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
    }
    int last[3];
    for (int a = 0; a < 3; ++a)
    {
      last[a] = extent[2 * a + 1] < whole[2 * a + 1] ? extent[2 * a + 1] - 1 : extent[2 * a + 1];
    }
    std::size_t found = bodies.size(); // cached from the previous voxel, whose label is mostly the same
    double before = -1.0;
    for (int k = extent[4]; k <= last[2]; ++k)
    {
      for (int j = extent[2]; j <= last[1]; ++j)
      {
        int ijk[3] = { extent[0], j, k };
        vtkIdType voxel = labels->ComputePointId(ijk);
        for (int i = extent[0]; i <= last[0]; ++i, ++voxel)
        {
          const double label = array->GetComponent(voxel, 0);
          if (label != before)
          {
            const auto at = std::lower_bound(bodies.begin(), bodies.end(), label);
            found = at != bodies.end() && *at == label ? static_cast<std::size_t>(at - bodies.begin()) : bodies.size();
            before = label;
          }
          if (found < bodies.size())
          {
            long long* const sum = &sums[4 * found];
            ++sum[0];
            sum[1] += i;
            sum[2] += j;
            sum[3] += k;
          }
        }
      }
    }
  }
  if (controller && controller->GetNumberOfProcesses() > 1)
  {
    std::vector<long long> all(sums.size());
    controller->AllReduce(sums.data(), all.data(), static_cast<vtkIdType>(sums.size()), vtkCommunicator::SUM_OP);
    sums = all;
  }
  vtkNew<vtkImageData> frame; // geometry of a process with voxels, equal on all processes
  if (!TakeFrame(labels, controller, frame))
  {
    return problem;
  }
  for (std::size_t n = 0; n < bodies.size(); ++n)
  {
    const auto count = static_cast<double>(sums[4 * n]);
    if (count > 0)
    {
      const double index[3] = { static_cast<double>(sums[4 * n + 1]) / count,
        static_cast<double>(sums[4 * n + 2]) / count, static_cast<double>(sums[4 * n + 3]) / count };
      std::array<double, 3> middle;
      frame->TransformContinuousIndexToPhysicalPoint(index, middle.data());
      this->Middles[static_cast<long long>(bodies[n])] = middle;
    }
  }
  return problem;
}

bool BodyMiddles::Get(long long body, std::array<double, 3>& middle) const
{
  const auto at = this->Middles.find(body);
  if (at == this->Middles.end())
  {
    return false;
  }
  middle = at->second;
  return true;
}

}
