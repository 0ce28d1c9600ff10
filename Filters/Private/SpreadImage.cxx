// SPDX-License-Identifier: BSD-3-Clause
#include "SpreadImage.h"

#include "../vtkChainMailScanStatistics.h"
#include "Arrays.h"
#include "Convert.h"
#include "Sampling.h"
#include "Steps.h"

#include "vtkPointData.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <unordered_map>

namespace vtkChainMail
{

/// Values of one array, in pages of which the last used ones are kept.
class SpreadImage::Pages
{
public:
  Pages(const SpreadImage& image, int array, std::size_t bytesOfVoxel)
    : Image(image)
    , Array(array)
    , Bytes(bytesOfVoxel)
    , Whole(ExtentOf(image.Whole))
  {
    for (int a = 0; a < 3; ++a)
    {
      this->Grid.size[a] = this->Whole[2 * a + 1] - this->Whole[2 * a] + 1;
      this->Counts.size[a] = (this->Grid.size[a] + Size[a] - 1) / Size[a];
    }
    // All rows of one layer of pages, for passes over the whole image.
    const std::size_t layer = static_cast<std::size_t>(this->Grid.size[0]) * this->Grid.size[1] * Size[2];
    this->Most = std::max<std::size_t>(std::size_t(1) << 23, this->Bytes * layer * 3 / 2);
  }

  const void* Read(std::size_t first, int count)
  {
    const chainmail::Index3 at = this->Grid.indexOf(first);
    const int low = at[0] / Size[0];
    const int high = (at[0] + count - 1) / Size[0];
    const int y = at[1] / Size[1];
    const int z = at[2] / Size[2];
    this->Load(low, high, y, z);
    this->Row.resize(this->Bytes * static_cast<std::size_t>(count));
    for (int x = low; x <= high; ++x)
    {
      Page& page = this->Kept.at(this->Counts.at(x, y, z));
      page.Used = ++this->Clock;
      const int begin = std::max(at[0], x * Size[0]);
      const int end = std::min(at[0] + count, (x + 1) * Size[0]);
      const std::size_t from = page.Box.at(begin, at[1], at[2]);
      std::memcpy(this->Row.data() + this->Bytes * static_cast<std::size_t>(begin - at[0]),
        page.Values.data() + this->Bytes * from, this->Bytes * static_cast<std::size_t>(end - begin));
    }
    return this->Row.data();
  }

  void Clear()
  {
    this->Kept.clear();
    this->Total = 0;
  }

private:
  static constexpr int Size[3] = { 64, 16, 16 };

  struct Page
  {
    chainmail::VoxelBox Box;
    std::vector<char> Values;
    std::uint64_t Used = 0;
  };

  /// Reads the missing ones among the pages from `low` to `high` along x, all at once.
  void Load(int low, int high, int y, int z)
  {
    const std::uint64_t before = this->Clock;
    for (int x = low; x <= high; ++x)
    {
      const auto kept = this->Kept.find(this->Counts.at(x, y, z));
      if (kept != this->Kept.end())
      {
        kept->second.Used = ++this->Clock; // so they stay when others make room
      }
    }
    const auto isKept = [&](int x) { return this->Kept.count(this->Counts.at(x, y, z)) > 0; };
    while (low <= high && isKept(low))
    {
      ++low;
    }
    while (low <= high && isKept(high))
    {
      --high;
    }
    if (low > high)
    {
      return;
    }
    chainmail::VoxelBox all;
    all.first = { low * Size[0], y * Size[1], z * Size[2] };
    all.size = { (high - low + 1) * Size[0], Size[1], Size[2] };
    Extent extent;
    for (int a = 0; a < 3; ++a)
    {
      all.size[a] = std::min(all.size[a], this->Grid.size[a] - all.first[a]);
      extent[2 * a] = this->Whole[2 * a] + all.first[a];
      extent[2 * a + 1] = extent[2 * a] + all.size[a] - 1;
    }
    std::vector<char> values(this->Bytes * all.voxels());
    this->Image.Read(this->Array, extent, values.data());
    this->MakeRoom(values.size(), before);
    for (int x = low; x <= high; ++x)
    {
      Page page;
      page.Box = all;
      page.Box.first[0] = x * Size[0];
      page.Box.size[0] = std::min(Size[0], this->Grid.size[0] - page.Box.first[0]);
      page.Values.resize(this->Bytes * page.Box.voxels());
      page.Used = ++this->Clock;
      const auto extentOf = [](const chainmail::VoxelBox& box)
      {
        return Extent{ { box.first[0], box.first[0] + box.size[0] - 1, box.first[1], box.first[1] + box.size[1] - 1,
          box.first[2], box.first[2] + box.size[2] - 1 } };
      };
      CopyBox(values.data(), extentOf(all), page.Values.data(), extentOf(page.Box), extentOf(page.Box), this->Bytes);
      this->Kept[this->Counts.at(x, y, z)] = std::move(page);
    }
  }

  /// Drops the pages that were not used for longest, but none that was used after `before`, where there is no room.
  void MakeRoom(std::size_t bytes, std::uint64_t before)
  {
    this->Total += bytes;
    if (this->Total <= this->Most)
    {
      return;
    }
    std::vector<std::uint64_t> used;
    for (const auto& [number, page] : this->Kept)
    {
      used.push_back(page.Used);
    }
    const auto middle = used.begin() + static_cast<std::ptrdiff_t>(used.size() / 4);
    std::nth_element(used.begin(), middle, used.end());
    this->Total = bytes;
    for (auto page = this->Kept.begin(); page != this->Kept.end();)
    {
      const bool isOld = middle != used.end() && page->second.Used <= std::min(*middle, before);
      this->Total += isOld ? 0 : page->second.Values.size();
      page = isOld ? this->Kept.erase(page) : std::next(page);
    }
  }

  const SpreadImage& Image;
  int Array;
  std::size_t Bytes; // of a voxel
  Extent Whole;
  chainmail::Grid Grid;
  chainmail::Grid Counts; // each page as a voxel
  std::size_t Most;       // bytes that are kept
  std::size_t Total = 0;
  std::uint64_t Clock = 0;
  std::unordered_map<std::size_t, Page> Kept;
  std::vector<char> Row;
};

SpreadImage::SpreadImage(const Exchange& link, vtkImageData* own, const Holding& holding)
  : Link(link)
  , Own(own)
  , Held(holding)
  , Whole(vtkSmartPointer<vtkImageData>::New())
{
  static std::atomic<Fingerprint> last{ 0 };
  this->Number = ++last;
  this->Whole->SetOrigin(own->GetOrigin());
  this->Whole->SetSpacing(own->GetSpacing());
  this->Whole->SetDirectionMatrix(own->GetDirectionMatrix());
  this->Whole->SetExtent(const_cast<int*>(holding.Whole.data()));
}

SpreadImage::~SpreadImage() = default;

void SpreadImage::Close()
{
  this->IsOpen = false;
  for (const std::weak_ptr<Pages>& viewed : this->Viewed)
  {
    if (const std::shared_ptr<Pages> pages = viewed.lock())
    {
      pages->Clear();
    }
  }
}

int SpreadImage::IndexOf(vtkAbstractArray* ofOwn) const
{
  int index = 0;
  while (this->Own->GetPointData()->GetAbstractArray(index) != ofOwn)
  {
    ++index;
  }
  return index;
}

void SpreadImage::RequireOpen() const
{
  if (!this->IsOpen)
  {
    throw std::logic_error("The image is spread over several processes, which answer only during an update.");
  }
}

std::vector<char> SpreadImage::Ask(int process, int command, int array, const Extent& box) const
{
  this->RequireOpen();
  this->Link.Request(process, { { command, array, box[0], box[1], box[2], box[3], box[4], box[5] } });
  std::vector<char> answer = this->Link.Receive(process);
  if (answer.empty())
  {
    throw std::bad_alloc(); // nothing else fails there
  }
  return answer;
}

void SpreadImage::Read(int array, const Extent& box, char* out) const
{
  vtkDataArray* own = vtkDataArray::SafeDownCast(this->Own->GetPointData()->GetAbstractArray(array));
  const std::size_t bytes = BytesOfVoxel(own);
  for (int p = 0; p < this->Link.GetSize(); ++p)
  {
    const Extent common = Common(this->Held.Owned[p], box);
    if (IsEmpty(common))
    {
      continue;
    }
    if (p == Exchange::Root)
    {
      CopyBox(static_cast<const char*>(own->GetVoidPointer(0)), ExtentOf(this->Own), out, box, common, bytes);
    }
    else
    {
      const std::vector<char> values = this->Ask(p, Exchange::VALUES, array, common);
      CopyBox(values.data(), common, out, box, common, bytes);
    }
  }
}

chainmail::ArrayView SpreadImage::View(vtkDataArray* ofOwn)
{
  chainmail::ArrayView view = vtkChainMail::View(ofOwn);
  view.data = nullptr;
  const auto pages = std::make_shared<Pages>(*this, this->IndexOf(ofOwn), BytesOfVoxel(ofOwn));
  this->Viewed.push_back(pages);
  view.read = [pages](std::size_t first, int count) { return pages->Read(first, count); };
  return view;
}

void SpreadImage::Share(int command, const PartTissue& tissue, const std::vector<int>& others,
  const std::function<void()>& own, const std::function<void(int, const std::vector<char>&)>& take) const
{
  this->RequireOpen();
  const std::vector<char> task = tissue.Pack();
  for (const int p : others)
  {
    const Extent& part = this->Held.Owned[p];
    this->Link.Request(p, { { command, 0, part[0], part[1], part[2], part[3], part[4], part[5] } });
    this->Link.Send(task, p);
  }
  Steps steps;
  steps.Run(own);
  for (const int p : others)
  {
    std::vector<char> answer;
    steps.Exchange([&] { answer = this->Link.Receive(p); });
    steps.Run(
      [&]
      {
        if (answer.empty())
        {
          throw std::bad_alloc(); // nothing else fails there
        }
        take(p, answer);
      });
  }
  steps.End();
}

chainmail::TissueCounts SpreadImage::Count(const PartTissue& tissue) const
{
  std::vector<int> others;
  for (int p = 0; p < this->Link.GetSize(); ++p)
  {
    if (p != Exchange::Root && !IsEmpty(this->Held.Owned[p]))
    {
      others.push_back(p);
    }
  }
  chainmail::TissueCounts all;
  const Extent& mine = this->Held.Owned[Exchange::Root];
  this->Share(
    Exchange::COUNT, tissue, others,
    [&] { all = IsEmpty(mine) ? chainmail::TissueCounts() : tissue.Count(this->Own, mine); },
    [&](int, const std::vector<char>& answer) { all.add(PartTissue::UnpackCounts(answer)); });
  return all;
}

std::vector<chainmail::ReducedBox> SpreadImage::Reduce(const PartTissue& tissue) const
{
  std::vector<int> others;
  for (int p = 0; p < this->Link.GetSize(); ++p)
  {
    if (p != Exchange::Root && tissue.ElementsIn(this->Held.Owned[p]).voxels() > 0)
    {
      others.push_back(p);
    }
  }
  std::vector<chainmail::ReducedBox> boxes;
  const Extent& mine = this->Held.Owned[Exchange::Root];
  this->Share(
    Exchange::REDUCE, tissue, others, [&] { boxes.push_back(tissue.Reduce(this->Own, mine)); },
    [&](int p, const std::vector<char>& answer) { boxes.push_back(tissue.UnpackBox(answer, this->Held.Owned[p])); });
  return boxes;
}

vtkSmartPointer<vtkDataArray> SpreadImage::Gather(vtkDataArray* ofOwn) const
{
  auto all = vtkSmartPointer<vtkDataArray>::Take(ofOwn->NewInstance());
  Describe(all, ofOwn);
  Allocate(all, this->Whole->GetNumberOfPoints());
  Extent slab = this->Held.Whole;
  char* out = static_cast<char*>(all->GetVoidPointer(0));
  for (int k = this->Held.Whole[4]; k <= this->Held.Whole[5]; ++k)
  {
    slab[4] = slab[5] = k;
    this->Read(this->IndexOf(ofOwn), slab, out);
    out += BytesOfVoxel(ofOwn) * static_cast<std::size_t>(VoxelsOf(slab));
  }
  return all;
}

vtkSmartPointer<vtkDataArray> SpreadImage::GetSmallest(vtkAbstractArray* ofOwn)
{
  const int index = this->IndexOf(ofOwn);
  vtkSmartPointer<vtkDataArray>& known = this->Smallests[index];
  if (!known)
  {
    Smallest all(vtkDataArray::SafeDownCast(ofOwn));
    for (int p = 1; p < this->Link.GetSize(); ++p)
    {
      if (!IsEmpty(this->Held.Owned[p]))
      {
        all.Add(this->Ask(p, Exchange::SMALLEST, index, {}));
      }
    }
    known = all.ToArray();
  }
  return known;
}

vtkSmartPointer<vtkChainMailScanStatistics> SpreadImage::GetStatistics(vtkDataArray* ofOwn)
{
  const int index = this->IndexOf(ofOwn);
  vtkSmartPointer<vtkChainMailScanStatistics>& known = this->Statistics[index];
  if (!known)
  {
    const auto all = vtkSmartPointer<vtkChainMailScanStatistics>::New();
    all->ReadPart(this->Own, ofOwn, this->Held.Whole.data());
    for (int p = 1; p < this->Link.GetSize(); ++p)
    {
      if (!IsEmpty(this->Held.Owned[p]))
      {
        const std::vector<char> bytes = this->Ask(p, Exchange::STATISTICS, index, {});
        std::vector<double> numbers(bytes.size() / sizeof(double));
        std::memcpy(numbers.data(), bytes.data(), bytes.size());
        const auto other = vtkSmartPointer<vtkChainMailScanStatistics>::New();
        other->Unpack(numbers);
        all->Merge(other);
      }
    }
    known = all;
  }
  return known;
}

Fingerprint SpreadImage::FingerprintFor(vtkDataArray* ofOwn) const
{
  const Fingerprint parts[] = { this->Number, static_cast<Fingerprint>(this->IndexOf(ofOwn)) };
  return FingerprintOf(parts, sizeof(parts));
}

}
