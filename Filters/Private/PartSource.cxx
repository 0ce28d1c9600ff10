// SPDX-License-Identifier: BSD-3-Clause
#include "PartSource.h"

#include "Convert.h"
#include "ImageParts.h"
#include "Sampling.h"

#include "vtkPointData.h"

#include <algorithm>
#include <utility>

namespace vtkChainMail
{

namespace
{

/// Voxels that a process gets in addition on every side, for the next updates of a drag.
constexpr int reserve = 8;

/// When the image or one of its point arrays was last modified. VTK counts all modifications in a process.
vtkMTimeType TimeOf(vtkImageData* image)
{
  vtkMTimeType time = image->GetMTime();
  for (int a = 0; a < image->GetPointData()->GetNumberOfArrays(); ++a)
  {
    time = std::max(time, image->GetPointData()->GetAbstractArray(a)->GetMTime());
  }
  return time;
}

}

void PartSource::Update(const Exchange& exchange, Steps& steps, const Scene* scene, const OutputPlan& plan,
  const Properties& properties, const std::optional<chainmail::OutputDetail>& part, vtkImageData* own)
{
  this->Plan = plan;
  this->Part = part;
  this->Cuts = properties.SmoothCuts ? chainmail::CutSurfaces::Smooth : chainmail::CutSurfaces::Stepped;
  if (scene)
  {
    this->Image = scene->Image;
    this->Box = { {}, plan.GetSize() };
    this->Scalars = this->Source.GetEngineScalars();
    this->Version += this->Elsewhere ? 1 : 0;
    this->Elsewhere.reset();
  }
  else if (!this->Elsewhere || properties.Device != this->Device)
  {
    steps.Run(
      [&]
      {
        ++this->Version;
        this->Device = properties.Device;
        this->Elsewhere = std::make_unique<chainmail::Resampler>(this->Device);
        this->Elsewhere->setProgress([this](double share) { return this->Reports.Show(share); });
        this->Elsewhere->setCompiling([this] { return this->Reports.ShowCompiling(); });
      });
  }
  if (exchange.GetSize() == 1)
  {
    this->Smallest.clear();
    return;
  }
  this->ShareTissue(exchange, steps, scene);
  this->ShareVoxels(exchange, steps, scene, own);
  this->ShareSmallest(exchange, steps, scene);
}

void PartSource::ShareTissue(const Exchange& exchange, Steps& steps, const Scene* scene)
{
  std::vector<int> mine(7, 0);
  if (this->Part)
  {
    mine[0] = 1;
    std::copy_n(this->Part->first.begin(), 3, mine.begin() + 1);
    std::copy_n(this->Part->last.begin(), 3, mine.begin() + 4);
  }
  const std::vector<int> all = exchange.ToRoot(mine);
  if (!scene)
  {
    if (this->Part)
    {
      const std::vector<char> tissue = exchange.Receive(Exchange::Root);
      steps.Run(
        [&]
        {
          if (tissue.empty())
          {
            throw FailedElsewhere();
          }
          this->Elsewhere->take(tissue);
        });
    }
    return;
  }
  std::vector<int> receivers;
  std::vector<chainmail::OutputDetail> parts;
  for (int p = 1; p < exchange.GetSize(); ++p)
  {
    const int* given = all.data() + 7 * p;
    if (given[0] != 0)
    {
      chainmail::OutputDetail part = this->Plan.Detail;
      std::copy_n(given + 1, 3, part.first.begin());
      std::copy_n(given + 4, 3, part.last.begin());
      receivers.push_back(p);
      parts.push_back(part);
    }
  }
  std::size_t sent = 0;
  steps.Run(
    [&]
    {
      this->Source.GetSimulation().exportTissue(this->Plan.Padding, this->Cuts, parts,
        [&](std::size_t n, const std::vector<char>& tissue)
        {
          exchange.Send(tissue, receivers[n]);
          ++sent;
        });
    });
  for (; sent < receivers.size(); ++sent)
  {
    exchange.Send(std::vector<char>(), receivers[sent]);
  }
}

/// Whether an image has all voxels that this part shows.
bool PartSource::HasVoxels(vtkImageData* image) const
{
  return image && image->GetNumberOfPoints() > 0 && ListTypes(image) == this->Plan.Arrays &&
         this->Plan.BoxOf(ExtentOf(image)).contains(this->Elsewhere->sources());
}

void PartSource::ShareVoxels(const Exchange& exchange, Steps& steps, const Scene* scene, vtkImageData* own)
{
  const std::uint64_t time = exchange.FromRoot(scene ? TimeOf(scene->Image) : 0);
  std::vector<int> mine(7, 0);
  chainmail::VoxelBox wanted;
  steps.Run(
    [&]
    {
      if (scene || !this->Part || (this->ImageTime == time && this->HasVoxels(this->Image)))
      {
        return;
      }
      this->Image = nullptr;
      // Values of ghost voxels may be outdated.
      if (this->HasVoxels(own) && !own->GetPointGhostArray())
      {
        this->Image = own;
        return;
      }
      const chainmail::VoxelBox sources = this->Elsewhere->sources();
      const chainmail::Index3 size = this->Plan.GetSize();
      for (int a = 0; a < 3; ++a)
      {
        wanted.first[a] = std::max(sources.first[a] - reserve, 0);
        wanted.size[a] = std::min(sources.first[a] + sources.size[a] + reserve, size[a]) - wanted.first[a];
      }
      mine[0] = 1;
      std::copy_n(wanted.first.begin(), 3, mine.begin() + 1);
      std::copy_n(wanted.size.begin(), 3, mine.begin() + 4);
    });
  const std::vector<int> all = exchange.ToRoot(mine);
  if (scene)
  {
    const Extent whole = ExtentOf(scene->Image);
    for (int p = 1; p < exchange.GetSize(); ++p)
    {
      const int* given = all.data() + 7 * p;
      if (given[0] != 0)
      {
        Extent extent;
        for (int a = 0; a < 3; ++a)
        {
          extent[2 * a] = whole[2 * a] + given[1 + a];
          extent[2 * a + 1] = extent[2 * a] + given[4 + a] - 1;
        }
        auto voxels = vtkSmartPointer<vtkImageData>::New();
        steps.Run([&] { voxels = Cut(scene->Image, extent); });
        voxels->GetFieldData()->Initialize();
        exchange.Send(voxels, p);
      }
    }
    return;
  }
  if (mine[0] != 0)
  {
    const vtkSmartPointer<vtkImageData> voxels = exchange.ReceiveImage(Exchange::Root);
    steps.Run(
      [&]
      {
        if (voxels->GetNumberOfPoints() == 0)
        {
          throw FailedElsewhere();
        }
        this->Image = voxels;
      });
  }
  steps.Run(
    [&]
    {
      if (this->Part)
      {
        this->ImageTime = time;
        this->Box = this->Plan.BoxOf(ExtentOf(this->Image));
        this->Scalars =
          ToEngineArray(vtkDataArray::SafeDownCast(this->Image->GetPointData()->GetAbstractArray(this->Plan.Scalars)));
      }
    });
}

void PartSource::ShareSmallest(const Exchange& exchange, Steps& steps, const Scene* scene)
{
  const std::uint64_t time = exchange.FromRoot(scene ? TimeOf(scene->Image) : 0);
  if (!exchange.All(!this->Smallest.empty() && this->SmallestTime == time))
  {
    steps.Run(
      [&]
      {
        this->Smallest.clear();
        for (int a = 0; scene && a < scene->Image->GetPointData()->GetNumberOfArrays(); ++a)
        {
          this->Smallest.push_back(SmallestOf(scene->Image->GetPointData()->GetAbstractArray(a)));
        }
      });
    this->Smallest = exchange.FromRoot(this->Smallest);
    this->SmallestTime = time;
  }
}

void PartSource::Forget()
{
  this->Elsewhere.reset();
  ++this->Version;
}

chainmail::Resampled PartSource::Resample(const chainmail::BoxVisitor& visit, std::uint64_t since)
{
  return this->Elsewhere
           ? this->Elsewhere->resample(visit, since)
           : this->Source.GetSimulation().resample(this->Plan.Padding, visit, since, this->Cuts, *this->Part);
}

}
