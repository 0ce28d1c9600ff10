#include "Resampler.h"

#include "Error.h"
#include "Process.h"
#include "Resampling.h"
#include "TissuePart.h"

#include <algorithm>
#include <deque>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <utility>

namespace chainmail
{

namespace
{

/// The elements of the bricks that were received.
class Received
{
public:
  Received(const Grid& grid, const Index3& brickSize)
    : table_(grid, brickSize)
    , grid_(grid)
    , bytes_(static_cast<std::size_t>(this->table_.elementsPerBrick()) / 8)
  {
  }

  /// The number of bricks of a part that have an element.
  std::size_t count(const std::vector<std::uint8_t>& elements) const
  {
    std::size_t count = 0;
    for (std::size_t n = 0; n < elements.size(); n += this->bytes_)
    {
      const auto first = elements.begin() + static_cast<std::ptrdiff_t>(n);
      count += std::any_of(
                 first, first + static_cast<std::ptrdiff_t>(this->bytes_), [](std::uint8_t byte) { return byte != 0; })
                 ? 1
                 : 0;
    }
    return count;
  }

  void add(const TissuePart& part)
  {
    for (std::size_t n = 0; n < part.bricks.size(); ++n)
    {
      const auto bits = part.elements.begin() + static_cast<std::ptrdiff_t>(this->bytes_ * n);
      this->bits_[part.bricks[n]].assign(bits, bits + static_cast<std::ptrdiff_t>(this->bytes_));
    }
  }

  /// See Model::RowReader. Resampling needs to know only where tissue is.
  void row(std::size_t first, int count, float* out) const
  {
    constexpr float tissue = 0.5f;
    const Index3 at = this->grid_.indexOf(first);
    for (int n = 0, end = 0; n < count; n = end)
    {
      const int x = at[0] + n;
      const auto found = this->bits_.find(this->table_.brickAt(x, at[1], at[2]));
      if (found == this->bits_.end())
      {
        throw std::logic_error("The output shows tissue that was not received from the first process.");
      }
      const std::vector<std::uint8_t>& bits = found->second;
      const int width = this->table_.size()[0];
      end = std::min(count, n + width - x % width);
      // Every second one has the next place.
      const std::uint32_t firsts[2] = { this->table_.local(x, at[1], at[2]), this->table_.local(x + 1, at[1], at[2]) };
      for (int m = 0; m < end - n; ++m)
      {
        const std::uint32_t local = firsts[m & 1] + static_cast<std::uint32_t>(m >> 1);
        out[n + m] = (bits[local / 8] >> local % 8 & 1) != 0 ? tissue : -std::numeric_limits<float>::infinity();
      }
    }
  }

private:
  BrickTable table_;
  Grid grid_;
  std::size_t bytes_;
  std::unordered_map<int, std::vector<std::uint8_t>> bits_;
};

/// The tissue of one simulation.
struct Copy
{
  Copy(std::shared_ptr<Context> context, const TissuePart::Frame& frame)
    : received(std::make_shared<Received>(frame.grid, frame.brickSize))
    , bricks(std::move(context),
        std::make_shared<const Model>(frame.grid, 1,
          [from = this->received](std::size_t first, int count, float* out) { from->row(first, count, out); }),
        frame.brickSize)
    , resampling(this->bricks, nullptr)
  {
  }

  std::shared_ptr<Received> received;
  Bricks bricks;
  Resampling resampling;
  Tissue::Topology topology;
  std::vector<int> displaced; ///< bricks that may be displaced
};

}

class Resampler::Impl
{
public:
  explicit Impl(const std::string& device)
    : context(Context::of(device))
  {
  }

  void begin(TissuePart part);
  void goOn(const float* displacements);

  std::shared_ptr<Context> context;
  std::function<bool(double)> progress;
  std::function<bool()> compiling;
  TissuePart::Frame frame;
  std::unique_ptr<Copy> copy;
  std::deque<std::vector<int>> awaited; ///< bricks whose displacements come in further messages
  TissueVersion version;                ///< none while messages are awaited
};

void Resampler::Impl::begin(TissuePart part)
{
  const TissueVersion before = std::exchange(this->version, TissueVersion());
  const auto isSame = [](const TissuePart::Frame& a, const TissuePart::Frame& b)
  { return a.version.simulation == b.version.simulation && a.grid.size == b.grid.size && a.brickSize == b.brickSize; };
  if (!(part.frame.since == TissueVersion()) && !(part.frame.since == before))
  {
    throw std::logic_error("The tissue that was received continues from another one than the last.");
  }
  if (!this->copy || part.frame.isPortion || !isSame(part.frame, this->frame))
  {
    this->copy.reset(); // frees its memory first
    this->copy = std::make_unique<Copy>(this->context, part.frame);
  }
  this->frame = part.frame;
  Copy& own = *this->copy;
  Bricks& bricks = own.bricks;
  own.received->add(part);
  if (part.frame.isPortion)
  {
    // All that this copy will ever hold.
    const std::size_t withTissue = own.received->count(part.elements);
    bricks.reserve(withTissue, std::min(withTissue, part.displaced.size()));
  }
  if (!(own.topology == part.topology))
  {
    own.topology = part.topology;
    bricks.replaceTopology(part.topology);
  }
  std::vector<int> atRest;
  std::set_difference(own.displaced.begin(), own.displaced.end(), part.displaced.begin(), part.displaced.end(),
    std::back_inserter(atRest));
  inMessages(bricks, atRest,
    [&](const std::vector<int>& list)
    {
      const std::vector<float> zeros(static_cast<std::size_t>(3 * bricks.elementsPerBrick()) * list.size(), 0.0f);
      bricks.writeSlots(bricks.slotsOf(list), zeros.data());
    });
  bricks.makeUpdatable(part.displaced);
  own.displaced = std::move(part.displaced);
  this->awaited.clear();
  inMessages(bricks, part.changed, [&](const std::vector<int>& list) { this->awaited.push_back(list); });
  this->version = this->awaited.empty() ? this->frame.version : TissueVersion();
}

void Resampler::Impl::goOn(const float* displacements)
{
  if (this->awaited.empty())
  {
    throw std::logic_error("Displacements were received that nothing announced.");
  }
  Bricks& bricks = this->copy->bricks;
  bricks.writeSlots(bricks.slotsOf(this->awaited.front()), displacements);
  this->awaited.pop_front();
  this->version = this->awaited.empty() ? this->frame.version : TissueVersion();
}

Resampler::Resampler(const std::string& device)
  : impl_(translated([&] { return std::make_unique<Impl>(device); }))
{
}

Resampler::~Resampler() = default;
Resampler::Resampler(Resampler&&) noexcept = default;
Resampler& Resampler::operator=(Resampler&&) noexcept = default;

void Resampler::setProgress(std::function<bool(double)> progress)
{
  this->impl_->progress = std::move(progress);
}

void Resampler::setCompiling(std::function<bool()> compiling)
{
  this->impl_->compiling = std::move(compiling);
}

void Resampler::take(const std::vector<char>& message)
{
  requireOwnOpenCL();
  translated(
    [&]
    {
      const float* const displacements = displacementsOf(message);
      displacements ? this->impl_->goOn(displacements) : this->impl_->begin(TissuePart::fromMessage(message));
    });
}

TissueVersion Resampler::version() const
{
  return this->impl_->version;
}

Sources Resampler::sources() const
{
  return this->impl_->frame.sources;
}

Resampled Resampler::resample(const BoxVisitor& visit, std::uint64_t since)
{
  requireOwnOpenCL();
  Impl& impl = *this->impl_;
  if (impl.version == TissueVersion())
  {
    throw InputError("There is no tissue to resample, or not all of it.");
  }
  const WhileCompiling report(
    [&impl]
    {
      if (impl.compiling && !impl.compiling())
      {
        throw Aborted();
      }
    });
  const auto checkpoint = [&impl](double share)
  {
    if (impl.progress && !impl.progress(share))
    {
      throw Aborted();
    }
  };
  return translated(
    [&]
    {
      return impl.copy->resampling.run(
        impl.frame.padding, since, impl.frame.cuts, impl.frame.detail, checkpoint, visit);
    });
}

}
