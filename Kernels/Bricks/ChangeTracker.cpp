#include "ChangeTracker.h"

#include <algorithm>

namespace chainmail
{

namespace
{

/// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
std::uint64_t mix(std::uint64_t h)
{
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return h ^ (h >> 31);
}

/// The hash of a brick is 0 only where the brick is uncut and at rest.
std::uint64_t hashOf(std::uint64_t before, const BrickExtent& extent)
{
  const std::uint64_t both = std::uint64_t(extent.hashes[0]) << 32 | extent.hashes[1];
  return std::max<std::uint64_t>(1, mix(mix(before) ^ both));
}

std::uint64_t hashOf(std::uint64_t before, const std::vector<std::uint8_t>& bytes)
{
  std::uint64_t h = mix(before ^ bytes.size());
  for (std::size_t n = 0; n < bytes.size(); n += 8)
  {
    std::uint64_t word = 0;
    for (std::size_t m = n; m < std::min(n + 8, bytes.size()); ++m)
    {
      word = word << 8 | bytes[m];
    }
    h = mix(h ^ word);
  }
  return std::max<std::uint64_t>(1, h);
}

}

ChangeTracker::ChangeTracker(Bricks& bricks, DisplacementSource* source)
  : bricks_(bricks)
  , source_(source)
  , contents_(bricks.numbers(), 0)
  , changedAt_(bricks.numbers(), 0)
{
}

std::vector<BrickExtent> ChangeTracker::measure(const std::vector<int>& slots)
{
  static_assert(sizeof(BrickExtent) == 14 * sizeof(cl_uint), "survey.cl writes 14 numbers a brick");
  std::vector<BrickExtent> extents(slots.size());
  if (!slots.empty())
  {
    Context& context = this->bricks_.context();
    const std::size_t items = this->bricks_.workItems(true);
    const cl::Buffer& result = this->result_.sized(context, sizeof(BrickExtent) * slots.size());
    context.launch(context.kernel("changetracker.cl", this->bricks_.defines(true), "survey"), slots.size(), items,
      this->list_.holding(context, slots), this->bricks_.pitch(), this->bricks_.displacement(),
      cl::Local(sizeof(BrickExtent) * items), result);
    context.read(result, extents);
  }
  return extents;
}

ChangeTracker::Revision ChangeTracker::revise()
{
  this->displaced_.clear();
  this->extents_.clear();
  std::vector<std::uint64_t> contents(this->contents_.size(), 0);
  if (this->source_ && !this->source_->displaceAll())
  {
    this->displaced_ = this->source_->displaced();
    this->extents_ = this->source_->extents();
    for (const int brick : this->displaced_)
    {
      contents[brick] = std::max<std::uint64_t>(1, mix(this->source_->version()));
    }
  }
  else
  {
    const std::vector<int> slots = this->bricks_.dirtySlots();
    const std::vector<BrickExtent> extents = this->measure(slots);
    for (std::size_t n = 0; n < slots.size(); ++n)
    {
      const BrickExtent& extent = extents[n];
      if (extent.displaced())
      {
        const int brick = this->bricks_.brick(slots[n]);
        contents[brick] = hashOf(0, extent);
        this->displaced_.push_back(brick);
        this->extents_.push_back(extent);
      }
    }
  }
  for (const auto& [brick, bits] : this->bricks_.links().all())
  {
    contents[brick] = hashOf(contents[brick], bits);
  }
  ++this->look_;
  for (std::size_t brick = 0; brick < contents.size(); ++brick)
  {
    this->changedAt_[brick] = contents[brick] == this->contents_[brick] ? this->changedAt_[brick] : this->look_;
  }
  this->contents_ = std::move(contents);
  return this->look_;
}

}
