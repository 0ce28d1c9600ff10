#include "Resampling.h"

#include "BrickSet.h"
#include "Error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace chainmail
{

namespace
{

/// Output voxels of a batch. Each takes 17 bytes on the device, but cells at the border of two batches are processed in
/// both.
constexpr std::size_t voxelsPerBatch = std::size_t(1) << 22;

/// Batches for which displacements that are not all made at once are made together.
constexpr std::size_t batchesPerWindow = 8;

/// Words of a conflict (DISPUTE in cover.cl). There is room for one conflict per `voxelsPerDispute` voxels at first.
constexpr std::size_t wordsOfDispute = 5;
constexpr std::size_t voxelsPerDispute = 64;

/// Bytes that a buffer may keep between two runs. Runs that need more take so long that a new allocation does not
/// count.
constexpr std::size_t keptBytes = std::size_t(1) << 22;

/// The finest detail for which cells near a cut surface need few enough iterations on a device that ends loops.
constexpr int finestWhereLoopsEnd = 2;

/// Keys can number fewer cells than this: 8 * cell + component is less than BORDER (resample.clh).
constexpr std::size_t mostCells = std::size_t(1) << 28;

/// The requested part of the output brick at `origin`. `offset` points to the first offset of the brick, and `step` is
/// the distance between neighbouring offsets along each axis. `coverage` is null or points to the brick's coverage. The
/// box is empty where a size is not positive.
ResampledBox clipped(const OutputFrame& frame, const OutputDetail& detail, const Index3& origin, const float* offset,
  const Index3& step, const float* coverage)
{
  ResampledBox box;
  box.offset = offset;
  box.step = step;
  box.coverage = coverage;
  for (int a = 0; a < 3; ++a)
  {
    const int begin = detail.finer * origin[a];
    const int end = begin + detail.finer * frame.brickSize[a] - 1;
    box.first[a] = std::max(begin, detail.finer * std::max(frame.low[a], detail.first[a]));
    box.size[a] = std::min(end, detail.finer * std::min(frame.high[a], detail.last[a])) - box.first[a] + 1;
    const int skipped = (box.first[a] - begin) * step[a];
    box.offset += skipped;
    box.coverage = coverage ? box.coverage + skipped / 3 : nullptr;
  }
  return box;
}

bool isEmpty(const ResampledBox& box)
{
  return *std::min_element(box.size.begin(), box.size.end()) <= 0;
}

cl_int4 int4(const Index3& v)
{
  return { { v[0], v[1], v[2], 0 } };
}

/// Divides listed output bricks, from `begin` to `end` - 1, into as few parts of at most `most` as possible, and adds
/// the end of each to `ends`. A part is in the order of bricks. Bricks that reach across the border of two batches are
/// processed in both. Each cut is across the axis where they are the smallest share.
void bisect(const OutputFrame& frame, std::vector<std::size_t>& listed, std::size_t begin, std::size_t end,
  std::size_t most, std::vector<std::size_t>& ends)
{
  const auto at = [&listed](std::size_t n) { return listed.begin() + static_cast<std::ptrdiff_t>(n); };
  const std::size_t parts = (end - begin + most - 1) / most;
  if (parts <= 1)
  {
    std::sort(at(begin), at(end));
    ends.push_back(end);
    return;
  }
  BrickBox box;
  std::for_each(at(begin), at(end), [&](std::size_t brick) { box.include(frame.bricks.indexOf(brick)); });
  constexpr double reach = 32.0; // of a brick beyond itself [voxels]: about as far as tissue is displaced
  std::array<double, 3> lengths; // of the box, as multiples of the length that a brick reaches
  for (int a = 0; a < 3; ++a)
  {
    lengths[a] = (box.last[a] - box.first[a] + 1) * frame.brickSize[a] / (frame.brickSize[a] + reach);
  }
  const auto axis = std::max_element(lengths.begin(), lengths.end()) - lengths.begin();
  // The first part is the largest one, so buffers do not grow from batch to batch.
  const std::size_t middle = begin + ((end - begin) * (parts / 2) + parts - 1) / parts;
  const auto keyOf = [&](std::size_t brick) { return std::make_pair(frame.bricks.indexOf(brick)[axis], brick); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) { return keyOf(a) < keyOf(b); });
  bisect(frame, listed, begin, middle, most, ends);
  bisect(frame, listed, middle, end, most, ends);
}

/// The number of voxels along the longest axis of a part of the output.
int longestAxis(const OutputDetail& part)
{
  int longest = 0;
  for (int a = 0; a < 3; ++a)
  {
    longest = std::max(longest, part.last[a] - part.first[a] + 1);
  }
  return longest;
}

/// Boxes of up to `edge` voxels along each axis, of about equal sizes, which together are a part of the output.
std::vector<OutputDetail> divided(const OutputFrame& frame, const OutputDetail& part, int edge)
{
  Index3 first;
  Index3 size;
  Grid counts;
  for (int a = 0; a < 3; ++a)
  {
    first[a] = std::max(frame.low[a], part.first[a]);
    size[a] = std::max(0, std::min(frame.high[a], part.last[a]) - first[a] + 1);
    counts.size[a] = (size[a] + edge - 1) / edge;
  }
  std::vector<OutputDetail> boxes(counts.voxels(), part);
  for (std::size_t n = 0; n < boxes.size(); ++n)
  {
    const Index3 at = counts.indexOf(n);
    for (int a = 0; a < 3; ++a)
    {
      const auto begin = [&](int box)
      { return first[a] + static_cast<int>(std::int64_t(size[a]) * box / counts.size[a]); };
      boxes[n].first[a] = begin(at[a]);
      // Voxels between those of the grid lie between two boxes, so finer ones share a layer of the grid.
      const int shared = part.finer > 1 && at[a] + 1 < counts.size[a] ? 1 : 0;
      boxes[n].last[a] = begin(at[a] + 1) - 1 + shared;
    }
  }
  return boxes;
}

/// The bricks of the grid among listed output bricks, from `begin` to `end` - 1. The kernels read their tissue, too,
/// where displaced tissue arrives.
std::vector<int> tissueOf(const Bricks& bricks, const OutputFrame& frame, const std::vector<std::size_t>& listed,
  std::size_t begin, std::size_t end)
{
  std::vector<int> tissue;
  for (std::size_t n = begin; n < end; ++n)
  {
    const Index3 origin = frame.origin(listed[n]);
    if (bricks.model().grid().contains(origin[0], origin[1], origin[2]))
    {
      tissue.push_back(bricks.brickAt(origin[0], origin[1], origin[2]));
    }
  }
  return tissue;
}

/// `listed` holds output bricks; the batch gets those from `begin` to `end` - 1.
Resampling::Batch makeBatch(const Bricks& bricks, const OutputFrame& frame, const std::vector<BrickExtents>& reaches,
  const std::vector<std::size_t>& listed, std::size_t begin, std::size_t end)
{
  const Index3 size = bricks.size();
  Resampling::Batch batch;
  batch.bricks = frame.bricks;
  batch.firstVoxel = frame.origin(0);
  batch.places.assign(frame.bricks.voxels(), -1);
  BrickBox box;
  for (std::size_t n = begin; n < end; ++n)
  {
    batch.places[listed[n]] = static_cast<int>(n - begin);
    batch.firsts.push_back(int4(frame.origin(listed[n])));
    box.include(frame.bricks.indexOf(listed[n]));
  }
  std::vector<char> isSource(frame.bricks.voxels(), 0);
  const auto isHandled = [&](std::size_t brick) { return batch.places[brick] >= 0; };
  for (const BrickExtents& reach : reaches)
  {
    if (reach.voxels.meets(box) && reach.voxels.any(frame.bricks, isHandled))
    {
      reach.cells.each(frame.bricks, [&](std::size_t brick) { isSource[brick] = 1; });
    }
  }
  batch.tissue = tissueOf(bricks, frame, listed, begin, end);
  BrickBox cells;
  for (std::size_t n = 0; n < isSource.size(); ++n)
  {
    if (isSource[n])
    {
      const Index3 origin = frame.origin(n);
      batch.sources.push_back(bricks.brickAt(origin[0], origin[1], origin[2]));
      cells.include(frame.bricks.indexOf(n));
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    batch.cells.size[a] = (cells.last[a] - cells.first[a] + 1) * size[a];
    batch.firstCell[a] = (cells.first[a] + frame.firstBrick[a]) * size[a];
    batch.cells.size[a] = std::min(batch.cells.size[a], bricks.model().grid().size[a] - batch.firstCell[a]);
  }
  return batch;
}

}

std::size_t Resampling::voxelsPerBrick() const
{
  const auto finer = static_cast<std::size_t>(this->detail_.finer);
  return this->bricks_.elementsPerBrick() * finer * finer * finer;
}

const cl::Buffer& Resampling::locate(const Batch& batch)
{
  Context& context = this->bricks_.context();
  const Grid& grid = this->bricks_.model().grid();
  const std::size_t shares = this->bricks_.options().sharesOfBrick(this->detail_.finer > 1 ? 1 : 2);
  const std::string defines = this->bricks_.defines(true, nullptr) + " -DSHARES=" + std::to_string(shares) +
                              (this->covers_ ? " -DSMOOTH_CUTS" : "") +
                              (this->detail_.finer > 1 ? " -DFINER=" + std::to_string(this->detail_.finer) : "");
  const std::size_t items = this->bricks_.workItems(true);
  const std::size_t voxels = batch.firsts.size() * this->voxelsPerBrick();
  const Index3 flat{ grid.size[0] == 1, grid.size[1] == 1, grid.size[2] == 1 };
  const cl::Buffer& claims = this->claims_.sized(context, sizeof(cl_uint) * voxels);
  const cl::Buffer& disputed = this->disputed_.sized(context, voxels);
  const cl::Buffer& found = this->offsets_.sized(context, sizeof(cl_float) * 3 * voxels);
  const auto tissue = std::make_tuple(this->bricks_.shownState(), int4(grid.size), int4(flat));
  const auto boxes =
    std::make_tuple(int4(batch.firstVoxel), int4(batch.bricks.size), int4(batch.firstCell), int4(batch.cells.size));
  const auto samples = [&](ArgumentList& own)
  {
    if (this->covers_)
    {
      own.add(this->coverage_.get(), this->behind_.get());
    }
  };
  const auto distances = [&](ArgumentList& own)
  {
    if (this->covers_)
    {
      own.add(this->bricks_.cutDistances().arguments());
    }
  };
  const cl::Buffer& list = this->list_.holding(context, batch.sources);
  const cl::Buffer& places = this->places_.holding(context, batch.places);
  // The room suffices for the conflicts of nearly all scenes. Where more tissue overlaps, the batch is computed once
  // more.
  cl_uint room = static_cast<cl_uint>(voxels / voxelsPerDispute), disputes = 0;
  do
  {
    room = std::max(room, disputes + disputes / 4);
    const cl::Buffer& noted = this->disputes_.sized(context, sizeof(cl_uint) * (1 + wordsOfDispute * room));
    context.queue().enqueueFillBuffer(claims, cl_uint(0xFFFFFFFFu), 0, sizeof(cl_uint) * voxels);
    context.queue().enqueueFillBuffer(disputed, cl_uchar(0), 0, voxels);
    context.queue().enqueueFillBuffer(noted, cl_uint(0), 0, sizeof(cl_uint));
    for (Scratch* scratch : { &this->coverage_, &this->behind_ })
    {
      if (this->covers_)
      {
        const std::size_t bytes = sizeof(cl_uint) * voxels;
        context.queue().enqueueFillBuffer(scratch->sized(context, bytes), cl_uint(0), 0, bytes);
      }
    }
    // A processor runs the work-items of a group one after the other anyway. A single work-item recognises its own
    // earlier candidates, which then count as no conflicts (isOurs() in cover.cl).
    context.launch(context.kernel("cover.cl", defines, "cover"), shares * batch.sources.size(),
      this->bricks_.options().width(true) > 1 ? 1 : items, list, tissue, boxes, places, claims, disputed, found, noted,
      room, distances, samples);
    context.queue().enqueueReadBuffer(noted, CL_TRUE, 0, sizeof(cl_uint), &disputes);
  } while (disputes > room);
  if (disputes > 0)
  {
    context.launchOver(context.kernel("cover.cl", defines, "settle"), disputes, claims, this->disputes_.get(), found);
  }
  context.launch(context.kernel("cover.cl", defines, "leave"), batch.firsts.size(), items, tissue,
    this->firsts_.holding(context, batch.firsts), claims, found, samples);
  return found;
}

Resampling::Resampling(Bricks& bricks, DisplacementSource* source)
  : bricks_(bricks)
  , source_(source)
  , changes_(bricks, source)
  , ranges_(bricks)
  , rest_(bricks)
{
}

/// Looks which bricks have changed.
ChangeTracker::Revision Resampling::look()
{
  const ChangeTracker::Revision now = this->changes_.revise();
  this->inParts_ = this->source_ && !this->source_->displaceAll();
  return now;
}

/// Displaces what a batch needs, and loads the tissue of its own bricks. Does nothing where there is no room for these.
bool Resampling::load(const Batch& batch)
{
  BrickSet sources(this->bricks_, this->bricks_.model().grid().size);
  for (const int brick : batch.sources)
  {
    sources.add(brick);
  }
  const std::vector<int> needed = sources.widened(aroundCells).all();
  if (needed.size() > this->source_->room())
  {
    return false;
  }
  this->source_->displace(needed);
  this->bricks_.loadTissue(batch.tissue);
  if (this->covers_)
  {
    this->bricks_.cutDistances().toDevice(this->bricks_.context());
  }
  return true;
}

/// Marks the output bricks that may differ from the last run: those whose content depended then, or depends now, on a
/// brick that changed.
void Resampling::noteChanges(const OutputFrame& frame)
{
  const ChangeTracker::Revision now = this->look();
  Ranges present(this->bricks_, this->changes_);
  for (int brick = 0; brick < this->bricks_.numbers(); ++brick)
  {
    if (this->changes_.changedAt(brick) <= this->last_)
    {
      continue;
    }
    const bool whole = this->ranges_.isCut(brick) || present.isCut(brick);
    const int beyond = whole && this->cuts_ == CutSurfaces::Smooth ? reachOfCarves : 0;
    for (const Ranges* ranges : { &this->ranges_, &present })
    {
      const Ranges::Shown shown = ranges->shown(brick, frame, whole, beyond);
      for (const BrickBox& box : { shown.reached, shown.left })
      {
        box.each(frame.bricks, [&](std::size_t n) { this->changedAt_[n] = now; });
      }
    }
  }
  // A new surface may cut no further link and still be nearer to grid points than earlier surfaces.
  for (const int brick : this->bricks_.cutDistances().takeChanged())
  {
    if (this->cuts_ == CutSurfaces::Smooth)
    {
      const Ranges::Shown shown = present.shown(brick, frame, true, reachOfCarves);
      for (const BrickBox& box : { shown.reached, shown.left })
      {
        box.each(frame.bricks, [&](std::size_t n) { this->changedAt_[n] = now; });
      }
    }
  }
  this->ranges_ = std::move(present);
  this->last_ = now;
}

Resampled Resampling::run(const Index3& padding, std::uint64_t since, CutSurfaces cuts, const OutputDetail& detail,
  const std::function<void(double)>& checkpoint, const BoxVisitor& visit)
{
  const Grid& grid = this->bricks_.model().grid();
  const OutputFrame frame(grid, padding, this->bricks_.size());
  if (this->changedAt_.empty() || padding != this->padding_ || cuts != this->cuts_ || detail != this->detail_)
  {
    this->padding_ = padding;
    this->cuts_ = cuts;
    this->detail_ = detail;
    this->changedAt_.assign(frame.bricks.voxels(), 0);
    this->first_ = this->last_ + 1;
    this->last_ = 0;
  }
  if (since != 0 && (since < this->first_ || since > this->last_))
  {
    throw InputError("There was no resampling of number " + std::to_string(since) + " with this padding and detail.");
  }
  this->noteChanges(frame);

  const std::vector<BrickExtents> reaches = findReaches(this->bricks_, frame, this->changes_, this->ranges_, cuts);
  std::vector<char> isReached(frame.bricks.voxels(), 0);
  for (const BrickExtents& reach : reaches)
  {
    reach.voxels.each(frame.bricks, [&](std::size_t brick) { isReached[brick] = 1; });
  }
  const std::array<float, 3> rest{};
  std::vector<ResampledBox> resting;
  std::vector<std::size_t> wanted; // bricks of the frame
  for (std::size_t n = 0; n < isReached.size(); ++n)
  {
    if (this->changedAt_[n] <= since)
    {
      continue;
    }
    const Index3 origin = frame.origin(n);
    const ResampledBox box = clipped(frame, detail, origin, rest.data(), {}, nullptr);
    if (isEmpty(box))
    {
      continue;
    }
    if (!isReached[n])
    {
      resting.push_back(box);
      continue;
    }
    wanted.push_back(n);
  }
  if (!resting.empty())
  {
    visit(resting);
  }
  if (!this->inParts_)
  {
    this->bricks_.loadTissue(tissueOf(this->bricks_, frame, wanted, 0, wanted.size()));
  }
  this->covers_ = cuts == CutSurfaces::Smooth && this->bricks_.anyCut() && this->bricks_.cutDistances().any();
  if (this->covers_)
  {
    const DeviceInfo& device = this->bricks_.context().info();
    if (device.endsLoops() && detail.finer > finestWhereLoopsEnd)
    {
      throw InputError("\"" + device.name + "\" ends loops of kernels too early for smooth cut surfaces at an " +
                       "OutputMagnification above " + std::to_string(finestWhereLoopsEnd) +
                       ". Choose another Device, such as PoCL, or lower OutputMagnification, or turn SmoothCuts off.");
    }
    this->bricks_.cutDistances().toDevice(this->bricks_.context());
  }
  this->locateAll(frame, reaches, wanted, checkpoint, visit);
  for (Scratch* scratch :
    { &this->claims_, &this->disputed_, &this->disputes_, &this->offsets_, &this->coverage_, &this->behind_ })
  {
    scratch->trim(keptBytes);
  }
  return { this->last_, reaches.empty() };
}

void Resampling::exportTissue(const Index3& padding, CutSurfaces cuts, std::uint64_t simulation,
  const std::vector<TissueReceiver>& receivers, const std::function<void(std::size_t, const std::vector<char>&)>& take)
{
  const ChangeTracker::Revision now = this->look();
  const OutputFrame frame(this->bricks_.model().grid(), padding, this->bricks_.size());
  const Ranges ranges(this->bricks_, this->changes_);
  const std::vector<BrickExtents> reaches = findReaches(this->bricks_, frame, this->changes_, ranges, cuts);
  for (std::size_t n = 0; n < receivers.size(); ++n)
  {
    const TissueReceiver& receiver = receivers[n];
    TissuePart part = partOf(this->bricks_, this->rest_, frame, reaches, this->changes_.displaced(), receiver.detail);
    part.frame.version = { simulation, now };
    part.frame.padding = padding;
    part.frame.cuts = cuts;
    part.frame.isPortion = this->inParts_;
    Sent& sent = this->sent_[receiver.number];
    if (receiver.has.simulation == simulation && receiver.has == sent.version)
    {
      part.frame.since = receiver.has;
      const auto hasIt = [&](int brick)
      {
        return this->changes_.changedAt(brick) <= receiver.has.revision &&
               std::binary_search(sent.displaced.begin(), sent.displaced.end(), brick);
      };
      part.changed.erase(std::remove_if(part.changed.begin(), part.changed.end(), hasIt), part.changed.end());
    }
    // A receiver that does not get all of this has another version later.
    sent = { part.frame.version, part.displaced };
    if (this->inParts_)
    {
      this->rest_.forget();
      if (part.changed.size() > this->source_->room())
      {
        throw MemoryError("A part of the output shows tissue from too many places at once. Crop the image, or resample "
                          "it to fewer voxels.");
      }
      this->source_->displace(part.changed);
    }
    take(n, part.toMessage());
    inMessages(this->bricks_, part.changed,
      [&](const std::vector<int>& displaced) { take(n, messageOf(this->bricks_, displaced)); });
  }
}

std::optional<std::vector<OutputDetail>> Resampling::portions(
  const Index3& padding, CutSurfaces cuts, const OutputDetail& part)
{
  this->look();
  if (!this->inParts_)
  {
    return std::nullopt;
  }
  const OutputFrame frame(this->bricks_.model().grid(), padding, this->bricks_.size());
  const Ranges ranges(this->bricks_, this->changes_);
  const std::vector<BrickExtents> reaches = findReaches(this->bricks_, frame, this->changes_, ranges, cuts);
  std::vector<char> isReached(frame.bricks.voxels(), 0);
  for (const BrickExtents& reach : reaches)
  {
    reach.voxels.each(frame.bricks, [&](std::size_t brick) { isReached[brick] = 1; });
  }
  // What is around a portion takes most of the room.
  const double room = static_cast<double>(this->source_->room()) * this->bricks_.elementsPerBrick();
  const int edge = std::max(1, static_cast<int>(std::cbrt(room / 8)));
  std::vector<OutputDetail> open = divided(frame, part, edge);
  std::vector<OutputDetail> portions;
  while (!open.empty())
  {
    const OutputDetail portion = open.back();
    open.pop_back();
    const BrickBox shown = bricksOf(frame, portion);
    if (!shown.any(frame.bricks, [&](std::size_t brick) { return isReached[brick] != 0; }))
    {
      continue;
    }
    const BrickSet near = bricksAround(this->bricks_, frame, reaches, portion);
    const auto needed = static_cast<std::size_t>(std::count_if(this->changes_.displaced().begin(),
      this->changes_.displaced().end(), [&](int brick) { return near.has(brick); }));
    if (needed <= this->source_->room() || shown.bricks() == 1 || longestAxis(portion) <= 2)
    {
      portions.push_back(portion);
      continue;
    }
    const std::vector<OutputDetail> halves = divided(frame, portion, (longestAxis(portion) + 1) / 2);
    open.insert(open.end(), halves.begin(), halves.end());
  }
  return portions;
}

Sources Resampling::sources(const Index3& padding, CutSurfaces cuts, const OutputDetail& detail)
{
  this->look();
  const OutputFrame frame(this->bricks_.model().grid(), padding, this->bricks_.size());
  const Ranges ranges(this->bricks_, this->changes_);
  const std::vector<BrickExtents> reaches = findReaches(this->bricks_, frame, this->changes_, ranges, cuts);
  if (!this->inParts_)
  {
    this->bricks_.loadTissue(reachedBricks(this->bricks_, frame, reaches, detail)); // as run() does
  }
  return sourcesOf(this->bricks_, frame, reaches, detail);
}

/// Computes the offsets of the voxels of these output bricks, batch by batch.
void Resampling::locateAll(const OutputFrame& frame, const std::vector<BrickExtents>& reaches,
  std::vector<std::size_t>& wanted, const std::function<void(double)>& checkpoint, const BoxVisitor& visit)
{
  const Index3 size = this->bricks_.size();
  const int finer = this->detail_.finer;
  const Index3 step{ 3, 3 * finer * size[0], 3 * finer * size[0] * finer * size[1] };
  const std::size_t perBrick = this->voxelsPerBrick();
  const std::size_t perBatch = std::max<std::size_t>(1, voxelsPerBatch / perBrick);
  std::vector<std::size_t> windows; // the end of each
  std::vector<std::size_t> batches;
  bisect(frame, wanted, 0, wanted.size(),
    this->inParts_ ? batchesPerWindow * perBatch : std::max<std::size_t>(1, wanted.size()), windows);
  for (std::size_t n = 0; n < windows.size(); ++n)
  {
    bisect(frame, wanted, n == 0 ? 0 : windows[n - 1], windows[n], perBatch, batches);
  }
  std::vector<ResampledBox> boxes;
  std::size_t endOfWindow = 0;
  bool isLoaded = false; // all that this window needs
  for (std::size_t begin = 0, end = 0; begin < wanted.size(); begin = end)
  {
    checkpoint(static_cast<double>(begin) / wanted.size());
    if (begin >= endOfWindow)
    {
      endOfWindow = *std::upper_bound(windows.begin(), windows.end(), begin);
      isLoaded = !this->inParts_ || this->load(makeBatch(this->bricks_, frame, reaches, wanted, begin, endOfWindow));
    }
    end = *std::upper_bound(batches.begin(), batches.end(), begin);
    Batch batch = makeBatch(this->bricks_, frame, reaches, wanted, begin, end);
    while (batch.cells.voxels() >= mostCells || (!isLoaded && !this->load(batch)))
    {
      if (end - begin == 1)
      {
        throw InputError("The tissue of one brick of the output comes from a box of " +
                         std::to_string(batch.cells.size[0]) + " x " + std::to_string(batch.cells.size[1]) + " x " +
                         std::to_string(batch.cells.size[2]) +
                         " voxels; that is too much at once. Crop the image, or resample it to fewer voxels.");
      }
      end = begin + (end - begin) / 2;
      batch = makeBatch(this->bricks_, frame, reaches, wanted, begin, end);
    }
    const Context::View<float> offsets(this->bricks_.context(), this->locate(batch), 0, 3 * perBrick * (end - begin));
    std::optional<Context::View<float>> coverage;
    if (this->covers_)
    {
      coverage.emplace(this->bricks_.context(), this->coverage_.get(), 0, perBrick * (end - begin));
    }
    boxes.clear();
    for (std::size_t n = begin; n < end; ++n)
    {
      const float* offset = offsets.get() + 3 * perBrick * (n - begin);
      boxes.push_back(clipped(frame, this->detail_, frame.origin(wanted[n]), offset, step,
        coverage ? coverage->get() + perBrick * (n - begin) : nullptr));
    }
    visit(boxes);
  }
}

}
