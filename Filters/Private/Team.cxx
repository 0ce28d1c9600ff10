// SPDX-License-Identifier: BSD-3-Clause
#include "Team.h"

#include "../vtkChainMailScanStatistics.h"
#include "PartTissue.h"
#include "Sampling.h"

#include "vtkNew.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace vtkChainMail
{

namespace
{

template <typename T> std::vector<char> ToBytes(const std::vector<T>& values)
{
  const auto* const first = reinterpret_cast<const char*>(values.data());
  return std::vector<char>(first, first + sizeof(T) * values.size());
}

}

/// A process that has to have a part of the image may have had no memory for it.
void Team::RequireOwn() const
{
  if (!this->Own)
  {
    throw FailedElsewhere();
  }
}

void Team::Serve(const Take& take) const
{
  for (;;)
  {
    const Exchange::Command command = this->Link.ReceiveRequest();
    if (command[0] == Exchange::END)
    {
      return;
    }
    if (command[0] == Exchange::OFFER)
    {
      take(command[1], command[2]);
      continue;
    }
    // A failure is an empty answer.
    std::vector<char> answer;
    try
    {
      std::vector<char> task;
      if (command[0] == Exchange::COUNT || command[0] == Exchange::REDUCE)
      {
        task = this->Link.Receive(Exchange::Root);
      }
      this->RequireOwn();
      auto* array = vtkDataArray::SafeDownCast(this->Own->GetPointData()->GetAbstractArray(command[1]));
      Extent box;
      std::copy_n(command.begin() + 2, 6, box.begin());
      if (command[0] == Exchange::VALUES)
      {
        answer.resize(BytesOfVoxel(array) * static_cast<std::size_t>(VoxelsOf(box)));
        CopyBox(static_cast<const char*>(array->GetVoidPointer(0)), ExtentOf(this->Own), answer.data(), box, box,
          BytesOfVoxel(array));
      }
      else if (command[0] == Exchange::COUNT)
      {
        answer = PartTissue::Pack(PartTissue::Unpack(task).Count(this->Own, box));
      }
      else if (command[0] == Exchange::REDUCE)
      {
        answer = PartTissue::Pack(PartTissue::Unpack(task).Reduce(this->Own, box));
      }
      else if (command[0] == Exchange::STATISTICS)
      {
        vtkNew<vtkChainMailScanStatistics> statistics;
        statistics->ReadPart(this->Own, array, this->Held.Whole.data());
        answer = ToBytes(statistics->Pack());
      }
      else
      {
        answer = Smallest(array).ToBytes();
      }
    }
    catch (const std::exception&)
    {
      answer.clear();
    }
    this->Link.Send(answer, Exchange::Root);
  }
}

/// A box of the part that this process has.
vtkSmartPointer<vtkImageData> Team::Give(const Extent& box) const
{
  this->RequireOwn();
  const vtkSmartPointer<vtkImageData> part = Cut(this->Own, box);
  part->GetFieldData()->Initialize();
  return part;
}

vtkSmartPointer<vtkImageData> Team::Fetch(const Extent& wanted, const Extent& known) const
{
  const int size = this->Link.GetSize();
  const std::vector<int> all = this->Link.ToAll(std::vector<int>(wanted.begin(), wanted.end()));
  const int me = this->Link.GetRank();
  Assembly assembly(wanted);
  assembly.LeaveOut(known);
  Steps steps;
  // All processes go through the pairs in the same order, so each one that sends meets one that receives.
  for (int from = 0; from < size; ++from)
  {
    for (int to = 0; to < size; ++to)
    {
      Extent box;
      std::copy_n(all.data() + 6 * to, 6, box.begin());
      const Extent common = IsEmpty(box) ? box : Common(this->Held.Owned[from], box);
      if (IsEmpty(common) || (from != me && to != me))
      {
        continue;
      }
      if (from == me && to == me)
      {
        steps.Run(
          [&]
          {
            for (const Extent& box : Without({ common }, known))
            {
              assembly.Add(this->Give(box));
            }
          });
        continue;
      }
      auto part = vtkSmartPointer<vtkImageData>::New();
      if (from == me)
      {
        steps.Run([&] { part = this->Give(common); });
        this->Link.Send(part, to); // empty after a failure
        continue;
      }
      steps.Exchange([&] { part = this->Link.ReceiveImage(from); });
      steps.Run(
        [&]
        {
          if (part->GetNumberOfPoints() == 0)
          {
            throw FailedElsewhere();
          }
          assembly.Add(part);
        });
    }
  }
  vtkSmartPointer<vtkImageData> image;
  steps.Run([&] { image = IsEmpty(wanted) ? nullptr : assembly.End(); });
  steps.End();
  return image;
}

}
