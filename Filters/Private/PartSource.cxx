// SPDX-License-Identifier: BSD-3-Clause
#include "PartSource.h"

#include "Convert.h"
#include "ImageParts.h"
#include "Sampling.h"

#include "vtkPointData.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

namespace vtkChainMail
{

namespace
{

/// Voxels that a process gets in addition on every side, for the next updates of a drag.
constexpr int reserve = 8;

/// Whether all arrays can be sampled from two images (MakeSampler()).
bool AreNumbers(vtkPointData* arrays)
{
  bool are = true;
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkDataArray* numbers = vtkDataArray::SafeDownCast(arrays->GetAbstractArray(a));
    are = are && numbers && numbers->GetDataType() != VTK_BIT;
  }
  return are;
}

/// What the root offers.
enum Offers
{
  TISSUE,  // a message for the Resampler
  PORTIONS // an Announcement, where tissue comes in portions later
};

struct Announcement
{
  chainmail::Sources Sources; // of the whole part
  int Portions = 0;

  std::vector<char> ToBytes() const
  {
    const auto* const first = reinterpret_cast<const char*>(this);
    return std::vector<char>(first, first + sizeof(*this));
  }
  static Announcement FromBytes(const std::vector<char>& bytes)
  {
    static_assert(std::is_trivially_copyable<Announcement>::value, "it is copied as bytes");
    Announcement announced;
    std::memcpy(&announced, bytes.data(), sizeof(announced));
    return announced;
  }
};

/// Changes where the image or one of its point arrays has changed. VTK counts all modifications in a process.
vtkTypeUInt64 TimeOf(const Scene& scene)
{
  vtkMTimeType time = scene.Image->GetMTime();
  for (int a = 0; a < scene.Image->GetPointData()->GetNumberOfArrays(); ++a)
  {
    time = std::max(time, scene.Image->GetPointData()->GetAbstractArray(a)->GetMTime());
  }
  return scene.Given.Spread ? scene.Given.Spread->FingerprintFor(scene.Scalars) : time;
}

}

void PartSource::Update(const Team& team, Steps& steps, const Scene* scene, const OutputPlan& plan,
  const Properties& properties, const std::optional<chainmail::OutputDetail>& part)
{
  this->Plan = plan;
  this->Part = part;
  this->Cuts = properties.SmoothCuts ? chainmail::CutSurfaces::Smooth : chainmail::CutSurfaces::Stepped;
  if (scene)
  {
    this->Version += this->Elsewhere ? 1 : 0;
    this->Elsewhere.reset();
  }
  const bool isOther = properties.Device != this->Device;
  this->Device = properties.Device;
  if (!scene && (!this->Elsewhere || isOther))
  {
    steps.Run([&] { this->Renew(); });
  }
  if (scene && !team.IsSpread())
  {
    this->Image = scene->Image;
    this->Box = { {}, plan.GetSize() };
    this->Scalars = this->Source.GetEngineScalars();
    this->FarImage = nullptr;
  }
  if (team.GetLink().GetSize() == 1)
  {
    this->Smallest.clear();
    return;
  }
  this->ShareTissue(team, steps, scene);
  this->ShareVoxels(team, steps, scene);
  this->ShareSmallest(team, steps, scene);
}

void PartSource::Renew()
{
  ++this->Version;
  this->Elsewhere = std::make_unique<chainmail::Resampler>(this->Device);
  this->Elsewhere->setProgress(
    [this](double share)
    {
      const double portions = std::max(this->NumberOfPortions, 1);
      return this->Reports.Show((this->PortionsShown + share) / portions);
    });
  this->Elsewhere->setCompiling([this] { return this->Reports.ShowCompiling(); });
}

void PartSource::ShareTissue(const Team& team, Steps& steps, const Scene* scene)
{
  const Exchange& exchange = team.GetLink();
  // Whether this process wants tissue, the part that it makes, and the version that it has.
  std::vector<vtkTypeInt64> mine(9, 0);
  if (this->Part)
  {
    mine[0] = 1;
    std::copy_n(this->Part->first.begin(), 3, mine.begin() + 1);
    std::copy_n(this->Part->last.begin(), 3, mine.begin() + 4);
    const chainmail::TissueVersion has = this->Elsewhere ? this->Elsewhere->version() : chainmail::TissueVersion();
    mine[7] = static_cast<vtkTypeInt64>(has.simulation);
    mine[8] = static_cast<vtkTypeInt64>(has.revision);
  }
  const std::vector<vtkTypeInt64> all = exchange.ToRoot(mine);
  bool isTaken = false;
  this->IsInPortions = false;
  this->Portions.clear();
  const auto lead = [&]
  {
    const chainmail::Simulation& simulation = this->Source.GetSimulation();
    std::vector<chainmail::TissueReceiver> receivers;
    std::vector<std::vector<chainmail::OutputDetail>> portions;
    for (int p = 0; p < exchange.GetSize(); ++p)
    {
      const vtkTypeInt64* given = all.data() + mine.size() * static_cast<std::size_t>(p);
      if (given[0] != 0)
      {
        chainmail::OutputDetail part = this->Plan.Detail;
        for (int a = 0; a < 3; ++a)
        {
          part.first[a] = static_cast<int>(given[1 + a]);
          part.last[a] = static_cast<int>(given[4 + a]);
        }
        receivers.push_back(
          { p, part, { static_cast<std::uint64_t>(given[7]), static_cast<std::uint64_t>(given[8]) } });
        const auto inPortions = simulation.portions(this->Plan.Padding, this->Cuts, part);
        this->IsInPortions = inPortions.has_value();
        portions.push_back(inPortions.value_or(std::vector<chainmail::OutputDetail>()));
      }
    }
    const auto isLast = [&](std::size_t n)
    {
      return std::all_of(portions.begin(), portions.end(),
        [n](const std::vector<chainmail::OutputDetail>& one) { return n >= one.size(); });
    };
    for (std::size_t n = 0; !isLast(n); ++n)
    {
      for (std::size_t r = 0; r < receivers.size(); ++r)
      {
        if (n < portions[r].size())
        {
          this->Portions.push_back({ receivers[r].number, portions[r][n], {} });
        }
      }
    }
    for (std::size_t r = 0; r < receivers.size(); ++r)
    {
      const int process = receivers[r].number;
      const bool isMine = process == Exchange::Root;
      if (isMine || this->IsInPortions)
      {
        const Announcement announced{ simulation.sources(this->Plan.Padding, this->Cuts, receivers[r].detail),
          static_cast<int>(portions[r].size()) };
        if (isMine)
        {
          this->Sources = announced.Sources;
          this->NumberOfPortions = announced.Portions;
        }
        else
        {
          team.Offer(process, PORTIONS);
          exchange.Send(announced.ToBytes(), process);
        }
      }
    }
    receivers.erase(std::remove_if(receivers.begin(), receivers.end(),
                      [](const chainmail::TissueReceiver& one) { return one.number == Exchange::Root; }),
      receivers.end());
    if (!this->IsInPortions)
    {
      simulation.exportTissue(this->Plan.Padding, this->Cuts, receivers,
        [&](std::size_t n, const std::vector<char>& message)
        {
          team.Offer(receivers[n].number, TISSUE);
          exchange.Send(message, receivers[n].number);
        });
    }
  };
  const auto take = [&](int what, int)
  {
    std::vector<char> message;
    steps.Exchange([&] { message = exchange.Receive(Exchange::Root); });
    steps.Run(
      [&]
      {
        if (what == PORTIONS)
        {
          const Announcement announced = Announcement::FromBytes(message);
          this->Sources = announced.Sources;
          this->NumberOfPortions = announced.Portions;
          return;
        }
        isTaken = true;
        this->Elsewhere->take(message);
        this->Sources = this->Elsewhere->sources();
      });
  };
  team.Lead(steps, lead, take);
  this->IsInPortions = exchange.FromRoot(static_cast<vtkTypeUInt64>(this->IsInPortions ? 1 : 0)) != 0;
  steps.Run(
    [&]
    {
      if (this->IsInPortions)
      {
        this->Renew();
        return;
      }
      const bool isComplete = isTaken && !(this->Elsewhere->version() == chainmail::TissueVersion());
      if (this->Part && !scene && !isComplete)
      {
        throw FailedElsewhere();
      }
    });
}

/// Whether an image has all voxels of a box, and the arrays of the whole image.
bool PartSource::Has(vtkImageData* image, const chainmail::VoxelBox& box) const
{
  return image && image->GetNumberOfPoints() > 0 && ListTypes(image) == this->Plan.Arrays &&
         this->Plan.BoxOf(ExtentOf(image)).contains(box);
}

/// Decides which voxels this process lacks; `wanted` gets their extent.
void PartSource::Choose(const Team& team, const Scene* scene, vtkTypeUInt64 time, Extent& wanted)
{
  if (!this->Part || (scene && !team.IsSpread()))
  {
    return;
  }
  const chainmail::VoxelBox& resting = this->Sources.resting;
  const chainmail::VoxelBox& moved = this->Sources.moved;
  const bool isOld = this->ImageTime != time;
  this->FarImage = isOld ? nullptr : this->FarImage;
  const auto isComplete = [&](vtkImageData* image)
  { return this->Has(image, resting) && (moved.voxels() == 0 || this->Has(image, moved)); };
  if (!isOld && isComplete(this->Image))
  {
    this->FarImage = nullptr;
    return;
  }
  if (!isOld && this->Has(this->Image, resting) && this->Has(this->FarImage, moved))
  {
    return;
  }
  // Values of ghost voxels may be outdated.
  vtkImageData* const own = team.GetOwn();
  const bool isOwn =
    this->Has(own, resting) && !own->GetPointGhostArray() && (isComplete(own) || AreNumbers(own->GetPointData()));
  this->Image = isOwn ? own : nullptr;
  this->FarImage = nullptr;
  if (isOwn && isComplete(own))
  {
    return;
  }
  const Extent whole = ExtentOf(this->Plan.Whole);
  for (int a = 0; a < 3; ++a)
  {
    int first = moved.first[a];
    int last = first + moved.size[a] - 1;
    if (!isOwn)
    {
      first = moved.voxels() > 0 ? std::min(first, resting.first[a]) : resting.first[a];
      last = std::max(last, resting.first[a] + resting.size[a] - 1);
    }
    wanted[2 * a] = std::max(whole[2 * a] + first - reserve, whole[2 * a]);
    wanted[2 * a + 1] = std::min(whole[2 * a] + last + reserve, whole[2 * a + 1]);
  }
}

void PartSource::ShareVoxels(const Team& team, Steps& steps, const Scene* scene)
{
  const Exchange& exchange = team.GetLink();
  const vtkTypeUInt64 time = exchange.FromRoot(scene ? TimeOf(*scene) : 0);
  Extent wanted{ { 0, -1, 0, -1, 0, -1 } };
  steps.Run([&] { this->Choose(team, scene, time, wanted); });
  vtkSmartPointer<vtkImageData> voxels;
  if (exchange.All(IsEmpty(wanted)))
  {
    // all have what they need
  }
  else if (team.IsSpread())
  {
    // The cells at the border of the present voxels, where the whole image goes on, lie in both images.
    Extent known = this->Image ? ExtentOf(this->Image) : Extent{ { 0, -1, 0, -1, 0, -1 } };
    const Extent whole = ExtentOf(this->Plan.Whole);
    for (int a = 0; a < 3; ++a)
    {
      known[2 * a] += known[2 * a] > whole[2 * a] ? 1 : 0;
      known[2 * a + 1] -= known[2 * a + 1] < whole[2 * a + 1] ? 1 : 0;
    }
    steps.Exchange([&] { voxels = team.Fetch(wanted, known); });
  }
  else
  {
    const std::vector<int> all = exchange.ToRoot(std::vector<int>(wanted.begin(), wanted.end()));
    if (scene)
    {
      this->SendVoxels(exchange, steps, *scene, all);
    }
    else if (!IsEmpty(wanted))
    {
      steps.Exchange([&] { voxels = exchange.ReceiveImage(Exchange::Root); });
    }
  }
  steps.Run(
    [&]
    {
      if (!this->Part || (scene && !team.IsSpread()))
      {
        return;
      }
      if (!IsEmpty(wanted))
      {
        (this->Image ? this->FarImage : this->Image) = voxels;
      }
      const chainmail::VoxelBox& moved = this->Sources.moved;
      if (!this->Has(this->Image, this->Sources.resting) ||
          (moved.voxels() > 0 && !this->Has(this->FarImage ? this->FarImage : this->Image, moved)))
      {
        throw FailedElsewhere();
      }
      this->ImageTime = time;
      this->Box = this->Plan.BoxOf(ExtentOf(this->Image));
      this->Scalars = this->ScalarsOf(this->Image);
      this->FarBox = this->FarImage ? this->Plan.BoxOf(ExtentOf(this->FarImage)) : chainmail::VoxelBox();
      this->FarScalars = this->FarImage ? this->ScalarsOf(this->FarImage) : nullptr;
    });
}

vtkSmartPointer<vtkDataArray> PartSource::ScalarsOf(vtkImageData* image) const
{
  return ToEngineArray(vtkDataArray::SafeDownCast(image->GetPointData()->GetAbstractArray(this->Plan.Scalars)));
}

/// Sends the parts of the whole image that the other processes want.
void PartSource::SendVoxels(
  const Exchange& exchange, Steps& steps, const Scene& scene, const std::vector<int>& wanted) const
{
  for (int p = 1; p < exchange.GetSize(); ++p)
  {
    Extent extent;
    std::copy_n(wanted.data() + 6 * p, 6, extent.begin());
    if (!IsEmpty(extent))
    {
      auto voxels = vtkSmartPointer<vtkImageData>::New();
      steps.Run([&] { voxels = Cut(scene.Image, extent); });
      voxels->GetFieldData()->Initialize();
      exchange.Send(voxels, p);
    }
  }
}

void PartSource::ShareSmallest(const Team& team, Steps& steps, const Scene* scene)
{
  const Exchange& exchange = team.GetLink();
  const vtkTypeUInt64 time = exchange.FromRoot(scene ? TimeOf(*scene) : 0);
  if (exchange.All(!this->Smallest.empty() && this->SmallestTime == time))
  {
    return;
  }
  const auto lead = [&]
  {
    this->Smallest.clear();
    for (int a = 0; a < scene->Image->GetPointData()->GetNumberOfArrays(); ++a)
    {
      vtkAbstractArray* array = scene->Image->GetPointData()->GetAbstractArray(a);
      this->Smallest.push_back(scene->Given.Spread
                                 ? scene->Given.Spread->GetSmallest(array)
                                 : vtkChainMail::Smallest(vtkDataArray::SafeDownCast(array)).ToArray());
    }
  };
  team.Lead(steps, lead);
  this->Smallest = exchange.FromRoot(this->Smallest);
  this->SmallestTime = time;
}

void PartSource::Forget()
{
  this->Elsewhere.reset();
  ++this->Version;
}

chainmail::Resampled PartSource::Resample(
  const Team& team, Steps& steps, const chainmail::BoxVisitor& visit, std::uint64_t since)
{
  chainmail::Resampled resampled;
  if (this->IsInPortions)
  {
    this->ResamplePortions(team, steps, visit, resampled);
  }
  else if (this->Part)
  {
    steps.Run(
      [&]
      {
        resampled = this->Elsewhere ? this->Elsewhere->resample(visit, since)
                                    : this->Source.GetSimulation().resample(
                                        this->Plan.Padding, visit, since, this->Cuts, *this->Part);
      });
  }
  return resampled;
}

/// Each process resamples a portion when it has got its tissue, while the root makes that of the next process.
void PartSource::ResamplePortions(
  const Team& team, Steps& steps, const chainmail::BoxVisitor& visit, chainmail::Resampled& resampled)
{
  const Exchange& exchange = team.GetLink();
  resampled.atRest = true;
  const auto show = [&](const std::vector<char>& message)
  {
    this->Elsewhere->take(message);
    if (!(this->Elsewhere->version() == chainmail::TissueVersion()))
    {
      const chainmail::Resampled one = this->Elsewhere->resample(visit);
      resampled = { one.number, resampled.atRest && one.atRest };
      ++this->PortionsShown;
    }
  };
  const auto lead = [&]
  {
    this->Source.GetSimulation().exportTissue(this->Plan.Padding, this->Cuts, this->Portions,
      [&](std::size_t n, const std::vector<char>& message)
      {
        const int process = this->Portions[n].number;
        if (process == Exchange::Root)
        {
          show(message);
          return;
        }
        team.Offer(process, TISSUE);
        exchange.Send(message, process);
        if (exchange.Receive(process).empty())
        {
          throw FailedElsewhere();
        }
      });
  };
  const auto take = [&](int, int)
  {
    std::vector<char> message;
    steps.Exchange([&] { message = exchange.Receive(Exchange::Root); });
    // So the root does not go on for long after another process has failed or was stopped.
    exchange.Send(std::vector<char>(steps.HaveFailed() ? 0 : 1), Exchange::Root);
    steps.Run([&] { show(message); });
  };
  this->PortionsShown = 0;
  team.Lead(steps, lead, take);
  steps.Run(
    [&]
    {
      if (this->PortionsShown < this->NumberOfPortions)
      {
        throw FailedElsewhere();
      }
    });
  this->PortionsShown = 0;
  this->NumberOfPortions = 0;
  this->Elsewhere.reset(); // frees the tissue of the last portion
  ++this->Version;         // and nothing goes on from it
}

}
